// What the optimiser had to choose from for the selected vehicle: the Pareto front of the shown time, and where each of
// its members would have led.

/** A choice is shown until the next one, but for no longer than so many of the times between two. */
const PERIODS_MAX = 3, PERIOD_MIN_S = 0.5;
/** A live picture may be a little behind the choice that is told beside it, s. */
const LIVE_LEAD_S = 0.25;
/** So many choices of a vehicle are remembered. */
const KEPT_MAX = 3000;
const HEIGHT = 168, MARGIN = { left: 46, right: 12, top: 10, bottom: 32 };
const TERMS = ["formation", "obstacle", "velocity"];

export class Choices {
  constructor(element, player) {
    this.element = element;
    this.player = player;
    this.number = null;   // of the vehicle that is selected
    this.known = new Map(); // choices by vehicle, each in order of time
    this.drawn = null;
    this.pointed = null;  // index of the member under the pointer
    this.onPoint = () => {};
    element.addEventListener("keydown", (event) => this.step(event));
  }

  /** Looks at the vehicle of a number, or at none. */
  select(number) {
    if (number === this.number) return;
    this.number = number;
    this.pointed = null;
    this.drawn = undefined;
  }

  /** Takes choices as the program tells them. */
  take(choices) {
    for (const choice of choices) {
      const own = this.known.get(choice.vehicle) ?? [];
      this.known.set(choice.vehicle, own);
      const before = own.findLastIndex((other) => other.at_s < choice.at_s - 1e-6);
      // A choice that is told again replaces what was known; one of an earlier time is of another flight.
      own.splice(before + 1, own.length, choice);
      if (own.length > KEPT_MAX) own.shift();
    }
  }

  /** The program tells all anew. */
  forget() {
    this.known.clear();
  }

  /** The choice that held at the shown time, or null. */
  shown() {
    const own = this.known.get(this.number) ?? [];
    const time = this.player.now + (this.player.isLive ? LIVE_LEAD_S : 1e-6);
    const index = own.findLastIndex((choice) => choice.at_s <= time);
    if (index < 0) return null;
    const period = index > 0 ? own[index].at_s - own[index - 1].at_s : own.length > 1 ? own[1].at_s - own[0].at_s : 1;
    return time - own[index].at_s <= Math.max(PERIOD_MIN_S, PERIODS_MAX * period) ? own[index] : null;
  }

  /** The ways to draw in the picture: all members', the chosen one, the one that is pointed at, the evasion. */
  ways() {
    const choice = this.shown();
    if (!choice) return null;
    const { members, chosen, evasion_path_m: evasion } = choice;
    const pointed = members[this.pointed]?.path_m ?? null;
    return { all: members.map(({ path_m }) => path_m), chosen: members[chosen].path_m, pointed, evasion };
  }

  /** Draws the front beside the picture, if it is another one. */
  draw() {
    const choice = this.shown();
    if (choice === this.drawn && this.element.clientWidth === this.width) return;
    this.drawn = choice;
    this.width = this.element.clientWidth;
    this.element.hidden = !choice;
    if (!choice) { this.element.replaceChildren(); return; }
    if (this.pointed >= choice.members.length) this.pointed = null;
    const title = document.createElement("h3");
    const { optimizer, at_s: time, front_len: members } = choice;
    title.textContent = `What ${optimizer} chose at ${time.toFixed(1)} s, of a Pareto front of ${members}`;
    this.words = document.createElement("p");
    this.words.className = "note";
    this.words.setAttribute("aria-live", "off");
    // Of one member there is nothing to compare.
    this.element.replaceChildren(title, ...(choice.members.length > 1 ? [this.front(choice)] : []), this.words);
    this.say(choice);
  }

  /** What is said of the chosen member, or of the one that is pointed at. */
  say(choice) {
    const member = choice.members[this.pointed ?? choice.chosen];
    const weights = TERMS.map((term, k) => `${term} ${member.weights[k].toFixed(2)}`).join(", ");
    const isAlone = choice.members.length === 1;
    const words = [`${this.pointed === null || this.pointed === choice.chosen ? "Chosen" : "Not chosen"}: ${weights}.`];
    if (isAlone) words.push("No other choice was found that is better in either cost.");
    const short_m = choice.violation_m;
    if (short_m > 0) words.push(`No member keeps all distances: ${short_m.toFixed(2)} m short in all.`);
    if (choice.evasion_path_m) {
      words.push("Evasion: the ways of the flock came too near, and another command was sent.");
    }
    this.words.textContent = words.join(" ");
  }

  front(choice) {
    const width = Math.max(220, this.width - 8);
    const viewBox = `0 0 ${width} ${HEIGHT}`;
    const svg = shape("svg", { width, height: HEIGHT, viewBox, role: "img", class: "front" });
    const label = `Pareto front of ${choice.members.length} choices; left and right arrows go from one to the next`;
    svg.setAttribute("aria-label", label);
    const range = (k) => {
      const values = choice.members.map(({ costs }) => costs[k]);
      const [low, high] = [Math.min(...values), Math.max(...values)];
      const room = (high - low) * 0.06 || Math.abs(low) * 0.01 || 0.01;
      return [low - room, high + room];
    };
    const [xs, ys] = [range(0), range(1)];
    const place = (costs) => [
      MARGIN.left + (width - MARGIN.left - MARGIN.right) * (costs[0] - xs[0]) / (xs[1] - xs[0]),
      HEIGHT - MARGIN.bottom - (HEIGHT - MARGIN.top - MARGIN.bottom) * (costs[1] - ys[0]) / (ys[1] - ys[0])];
    const [left, bottom] = [MARGIN.left, HEIGHT - MARGIN.bottom];
    svg.append(shape("path", { d: `M${left} ${MARGIN.top}V${bottom}H${width - MARGIN.right}`, class: "axis" }));
    const write = (text, x, y, anchor, turn) => {
      const turned = turn ? { transform: `rotate(-90 ${x} ${y})` } : {};
      const words = shape("text", { x, y, "text-anchor": anchor, ...turned });
      words.textContent = text;
      svg.append(words);
    };
    for (const [value, anchor] of [[xs[0], "start"], [xs[1], "end"]]) {
      write(short(value, xs), anchor === "start" ? left : width - MARGIN.right, bottom + 13, anchor);
    }
    write(short(ys[0], ys), left - 4, bottom, "end");
    write(short(ys[1], ys), left - 4, MARGIN.top + 9, "end");
    write(choice.costs[0], (left + width - MARGIN.right) / 2, HEIGHT - 4, "middle");
    write(choice.costs[1].replace(/ and .* \(/, " ("), 11, (MARGIN.top + bottom) / 2, "middle", true);
    // The ideal has the least of both costs; the member nearest to it is chosen.
    const ideal = place([0, 1].map((k) => Math.min(...choice.members.map(({ costs }) => costs[k]))));
    svg.append(shape("path", { d: `M${ideal[0] - 4} ${ideal[1] - 4}l8 8m0 -8l-8 8`, class: "ideal" }));
    this.dots = choice.members.map((member, index) => {
      const [cx, cy] = place(member.costs);
      const [r, kind] = index === choice.chosen ? [6, "chosen"] : [3.5, "member"];
      const dot = shape("circle", { cx, cy, r, class: kind });
      dot.addEventListener("pointerenter", () => this.point(index));
      dot.addEventListener("pointerleave", () => this.point(null));
      return dot;
    });
    svg.append(...this.dots, this.dots[choice.chosen]);
    return svg;
  }

  /** Points at a member: its weights are said, and its way is drawn. */
  point(index) {
    this.pointed = index;
    this.dots?.forEach((dot, k) => dot.classList.toggle("pointed", k === index));
    this.say(this.drawn);
    this.onPoint();
  }

  step(event) {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by || !this.drawn) return;
    event.preventDefault();
    event.stopPropagation();
    const last = this.drawn.members.length - 1;
    this.point(Math.min(last, Math.max(0, (this.pointed ?? this.drawn.chosen) + by)));
  }
}

/** An element of a drawing; the page's own parser knows the name space. */
function shape(kind, attributes) {
  const element = document.createElementNS(document.getElementById("drawing").namespaceURI, kind);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

/** A number with as many digits as tell the ends of its axis apart. */
function short(value, [low, high]) {
  const digits = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(high - low))));
  return value.toFixed(digits).replace("-", "\u2212");
}
