// Charts of the selected vehicle: what is remembered of it, up to the shown time.

const DEGREES = 180 / Math.PI;

const CHARTS = [
  { title: "Speed (m/s)", lines: [["flown", (m, i) => m.speed(i)], ["asked", (m, i) => m.speedAsked(i)]] },
  { title: "Course (\u00b0)", isAngle: true,
    lines: [["flown", (m, i) => m.course(i) * DEGREES], ["asked", (m, i) => m.courseAsked(i) * DEGREES]] },
  { title: "Altitude (m)", lines: [["flown", (m, i) => m.altitude(i)], ["asked", (m, i) => m.altitudeAsked(i)]] },
  { title: "Weights \u03b1",
    lines: ["formation", "obstacle", "velocity"].map((term, k) => [term, (m, i) => m.weight(k, i)]) },
  { title: "Distances (m)",
    lines: [["separation", (m, i) => m.separation(i)], ["clearance", (m, i) => m.clearance(i)]] },
  { title: "Link age (s)", lines: [["age", (m, i) => m.age(i)]] },
];
const DASHES = [[], [6, 4], [2, 3]];
// No axis is shorter than this: of values that differ by a rounding error uPlot would draw lines without end.
const LEAST_RANGE = 0.02;

export class Charts {
  constructor(element, player, onSeek) {
    this.element = element;
    this.player = player;
    this.onSeek = onSeek;
    this.plots = [];
    this.index = null;
    new ResizeObserver(() => this.resize()).observe(element);
  }

  show(index) {
    if (index === this.index) return;
    this.index = index;
    this.make();
  }

  make() {
    this.plots.forEach(({ plot }) => plot.destroy());
    this.element.replaceChildren();
    this.plots = [];
    if (this.index === null || typeof uPlot === "undefined") return;
    const style = getComputedStyle(document.documentElement);
    const rem = parseFloat(style.fontSize);
    const css = (name) => style.getPropertyValue(`--${name}`).trim();
    const colours = [css("s1"), css("s2"), css("s3")];
    for (const chart of CHARTS) {
      const data = this.read(chart);
      // Nobody needs a chart of what this flight does not have.
      if (!data.slice(1).some((values) => values.some((value) => value !== null))) continue;
      const axis = {
        stroke: css("soft"), grid: { stroke: css("line"), width: 1 }, ticks: { stroke: css("line") },
        font: `${Math.round(0.8 * rem)}px system-ui`,
      };
      const series = chart.lines.map(([label], k) => ({
        label, stroke: colours[k], width: 1.6, dash: DASHES[k], spanGaps: false,
      }));
      const seek = (plot) => this.onSeek(plot.posToVal(plot.cursor.left, "x"));
      const options = {
        title: chart.title, width: this.width(), height: 9.4 * rem,
        scales: { x: { time: false, range: (_, ...ends) => widened(...ends) },
          y: { range: (_, ...ends) => uPlot.rangeNum(...widened(...ends), 0.1, true) } },
        cursor: { sync: { key: "vehicle" }, y: false },
        legend: { show: true, live: true },
        axes: [{ ...axis, size: 1.9 * rem }, { ...axis, size: 3.3 * rem }],
        series: [{ label: "s" }, ...series],
        hooks: { ready: [(plot) => plot.over.addEventListener("dblclick", () => seek(plot))] },
      };
      this.plots.push({ chart, plot: new uPlot(options, data, this.element) });
    }
  }

  read(chart) {
    const i = this.index;
    const where = (read) => (moment) => i < moment.n && moment.isPlaced(i) ? read(moment, i) : NaN;
    const data = this.player.series(chart.lines.map(([, read]) => where(read)));
    if (chart.isAngle) unwrap(data);
    return data;
  }

  draw() {
    if (this.index === null) return;
    if (!this.plots.length) this.make();
    for (const { chart, plot } of this.plots) {
      const data = this.read(chart);
      plot.setData(data);
      // While nobody points at a time, the numbers are the last ones.
      if (!(plot.cursor.left >= 0)) plot.setLegend({ idx: data[0].length - 1 });
    }
  }

  resize() {
    for (const { plot } of this.plots) plot.setSize({ width: this.width(), height: plot.height });
  }

  width() {
    return Math.max(200, this.element.clientWidth - 8);
  }
}

/** The ends of an axis, as far apart as they have to be; without values they are none. */
function widened(low, high) {
  const room = Math.max(0, LEAST_RANGE - (high - low)) / 2;
  return low === null || high === null ? [0, 1] : [low - room, high + room];
}

/**
 * Courses without jumps from 360 to 0: each value is the nearest to the one before, the first within half a turn of
 * north.
 */
function unwrap([, ...columns]) {
  let before = 0;
  for (let at = 0; at < columns[0].length; at++) {
    for (const column of columns) {
      if (column[at] === null) continue;
      column[at] -= 360 * Math.round((column[at] - before) / 360);
      before = columns[0][at] ?? column[at];
    }
  }
}
