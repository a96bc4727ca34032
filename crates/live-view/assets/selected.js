// What is known of the selected vehicles: facts and events of one, a line for each of several.

import { stateOf } from "./table.js";

const SEVERAL_MAX = 20;
const EVENTS_MAX = 50;

function number(value, digits, unit) {
  if (!Number.isFinite(value)) return "\u2013";
  return `${value.toFixed(digits).replace("-", "\u2212")}${unit === "\u00b0" ? "" : " "}${unit}`;
}

const degrees = (angle) => number(angle * 180 / Math.PI, 0, "\u00b0");

export class Selected {
  /** The page's elements, the picture, and how a list of events is filled. */
  constructor(page, stage, fillEvents) {
    this.page = page;
    this.stage = stage;
    this.fillEvents = fillEvents;
    this.told = null;
  }

  /** Draws what is known now. */
  draw(roster, events) {
    const { page, stage } = this;
    const chosen = [...stage.selected];
    const moment = stage.player.shownStatus();
    const isOne = chosen.length === 1;
    page.hint.hidden = chosen.length > 0;
    page.name.textContent = this.nameOf(chosen, roster);
    const several = isOne || !moment ? [] : chosen.filter((k) => k < moment.n);
    page.several.replaceChildren(...(several.length ? this.severalOf(several, moment, roster) : []));
    const [i] = chosen;
    if (!isOne || !moment || i >= moment.n) {
      page.facts.replaceChildren();
      page.events.replaceChildren();
      this.told = null;
      return;
    }
    page.facts.replaceChildren(...factsOf(i, moment, roster).map(([name, value]) => {
      const [row, term, definition] = ["div", "dt", "dd"].map((kind) => document.createElement(kind));
      term.textContent = name;
      definition.textContent = value;
      row.append(term, definition);
      return row;
    }));
    const own = events.filter((event) => event.vehicles.includes(roster.numbers[i]));
    // A list that is made anew four times a second could be neither read aloud nor clicked.
    const told = `${i} ${own.length}`;
    if (told !== this.told) {
      this.told = told;
      this.fillEvents(page.events, own.slice(-EVENTS_MAX).reverse());
    }
  }

  nameOf(chosen, roster) {
    const numbers = chosen.slice(0, 12).map((k) => roster.numbers[k] ?? k + 1).join(", ");
    if (!chosen.length) return "No vehicle is selected";
    if (chosen.length === 1) return `Vehicle ${numbers}`;
    return `${chosen.length} vehicles: ${numbers}${chosen.length > 12 ? " \u2026" : ""}`;
  }

  /** Several vehicles in a line each; of two, how far they are apart. */
  severalOf(chosen, moment, roster) {
    const { stage } = this;
    const lines = chosen.slice(0, SEVERAL_MAX).map((k) => {
      const button = document.createElement("button");
      button.type = "button";
      const separation = `separation ${number(moment.separation(k), 1, "m")}`;
      const clearance = `clearance ${number(moment.clearance(k), 1, "m")}`;
      const words = [roster.modes[moment.mode(k)], stateOf(moment.flags(k)), separation, clearance];
      button.textContent = `vehicle ${roster.numbers[k] ?? k + 1}: ${words.filter(Boolean).join(", ")}`;
      button.onclick = () => stage.select([k]);
      return button;
    });
    if (chosen.length === 2) {
      const [a, b] = chosen;
      const { x, y, z } = stage.flock;
      const [metres, higher] = [Math.hypot(x[a] - x[b], y[a] - y[b]), Math.abs(z[a] - z[b])];
      const apart = document.createElement("p");
      const time = `At ${stage.player.now.toFixed(1)} s`;
      apart.textContent = `${time} they are ${number(metres, 1, "m")} apart, and ${number(higher, 1, "m")} in height.`;
      lines.push(apart);
    }
    return lines;
  }
}

/** What is known of one vehicle, each by its name. */
function factsOf(i, moment, roster) {
  const weights = [0, 1, 2].map((term) => moment.weight(term, i));
  const speedAsked = moment.speedAsked(i);
  return [
    ["is", roster.kinds[i]],
    ["system id", roster.systems[i] || ""],
    ["mode", roster.modes[moment.mode(i)]],
    ["state", stateOf(moment.flags(i))],
    ["north", number(moment.x(i), 1, "m")],
    ["east", number(moment.y(i), 1, "m")],
    ["altitude", number(moment.altitude(i), 1, "m")],
    ["speed", number(moment.speed(i), 1, "m/s")],
    ["course", degrees(moment.course(i))],
    ["separation", number(moment.separation(i), 1, "m")],
    ["clearance", number(moment.clearance(i), 1, "m")],
    ["link age", Number.isFinite(moment.age(i)) ? number(moment.age(i), 1, "s") : ""],
    ["weights chosen", Number.isFinite(weights[0]) ? weights.map((value) => value.toFixed(2)).join(" / ") : ""],
    ["asked", Number.isFinite(speedAsked) ? `${number(speedAsked, 1, "m/s")}, ${degrees(moment.courseAsked(i))}` : ""],
  ].filter(([, value]) => value);
}
