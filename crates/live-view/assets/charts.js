// Charts of the selected vehicle: what is remembered of it, up to the shown time.

const DEGREES = 180 / Math.PI;

const CHARTS = [
  { title: "Speed (m/s)", lines: [["flown", (m, i) => m.speed(i)], ["asked", (m, i) => m.speedAsked(i)]] },
  { title: "Course (\u00b0)", lines: [["flown", (m, i) => (m.course(i) * DEGREES) % 360], ["asked", (m, i) => m.courseAsked(i) * DEGREES]] },
  { title: "Altitude (m)", lines: [["flown", (m, i) => m.altitude(i)], ["asked", (m, i) => m.altitudeAsked(i)]] },
  { title: "Weights \u03b1", lines: [["formation", (m, i) => m.weight(0, i)], ["obstacle", (m, i) => m.weight(1, i)], ["velocity", (m, i) => m.weight(2, i)]] },
  { title: "Distances (m)", lines: [["separation", (m, i) => m.separation(i)], ["clearance", (m, i) => m.clearance(i)]] },
  { title: "Link age (s)", lines: [["age", (m, i) => m.age(i)]] },
];
const DASHES = [[], [6, 4], [2, 3]];

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
    const css = (name) => style.getPropertyValue(`--${name}`).trim();
    const colours = [css("s1"), css("s2"), css("s3")];
    for (const chart of CHARTS) {
      const data = this.read(chart);
      // Nobody needs a chart of what this flight does not have.
      const lines = chart.lines.map((line, k) => ({ line, values: data[k + 1] })).filter(({ values }) => values.some((v) => v !== null));
      if (!lines.length) continue;
      const axis = { stroke: css("soft"), grid: { stroke: css("line"), width: 1 }, ticks: { stroke: css("line") }, font: "11px system-ui" };
      const options = {
        title: chart.title, width: Math.max(200, this.element.clientWidth - 8), height: 132,
        scales: { x: { time: false } },
        cursor: { sync: { key: "vehicle" }, y: false },
        legend: { show: true, live: true },
        axes: [{ ...axis, size: 26 }, { ...axis, size: 46 }],
        series: [{ label: "s" }, ...chart.lines.map(([label], k) => ({ label, stroke: colours[k], width: 1.6, dash: DASHES[k], spanGaps: false }))],
        hooks: { ready: [(plot) => plot.over.addEventListener("dblclick", () => this.onSeek(plot.posToVal(plot.cursor.left, "x")))] },
      };
      this.plots.push({ chart, plot: new uPlot(options, data, this.element) });
    }
  }

  read(chart) {
    const i = this.index;
    return this.player.series(chart.lines.map(([, read]) => (moment) => i < moment.n && moment.isPlaced(i) ? read(moment, i) : NaN));
  }

  draw() {
    if (this.index === null) return;
    if (!this.plots.length) this.make();
    for (const { chart, plot } of this.plots) plot.setData(this.read(chart));
  }

  resize() {
    for (const { plot } of this.plots) plot.setSize({ width: Math.max(200, this.element.clientWidth - 8), height: 132 });
  }
}
