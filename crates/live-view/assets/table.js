// The table of vehicles: sorted and filtered, with only those rows in the page that are in sight.

import { FLAG } from "./wire.js";
import { severity } from "./stage.js";

const ROW_PX = 28;

const text = (value, digits) => Number.isFinite(value) ? value.toFixed(digits).replace("-", "\u2212") : "\u2013";

/** What a vehicle's flags say, the worst first. */
export function stateOf(flags) {
  const words = [
    [FLAG.lost, "lost"], [FLAG.clearance, "in a circle"], [FLAG.separation, "too near"], [FLAG.failsafe, "failsafe"],
    [FLAG.left, "left"], [FLAG.stale, "stale"], [FLAG.out, "out"],
  ].filter(([flag]) => flags & flag).map(([, word]) => word);
  if (words.length) return words.join(", ");
  return flags & FLAG.ground ? (flags & FLAG.armed ? "armed" : "on ground") : flags & FLAG.armed ? "flies" : "disarmed";
}

export class Table {
  constructor(element, count, filter, stage) {
    this.stage = stage;
    this.body = element.querySelector(".rows");
    this.room = element.querySelector(".room");
    this.count = count;
    this.filter = filter;
    this.sort = "number";
    this.descending = false;
    this.roster = { numbers: [], modes: [], systems: [], kinds: [] };
    this.order = [];
    this.columns = {
      number: { value: (moment, i) => this.roster.numbers[i] ?? i + 1, text: (value) => String(value) },
      mode: { value: (moment, i) => this.roster.modes[moment.mode(i)] ?? "\u2013", text: (value) => value },
      state: {
        value: (moment, i) => stateOf(moment.flags(i)), text: (value) => value,
        rank: (moment, i) => -severity(moment.flags(i)) * 1000 - moment.flags(i),
      },
      separation: {
        value: (moment, i) => moment.separation(i), text: (value) => value > 655 ? "> 655" : text(value, 1),
      },
      clearance: { value: (moment, i) => moment.clearance(i), text: (value) => value > 327 ? "> 327" : text(value, 1) },
      age: { value: (moment, i) => moment.age(i), text: (value) => text(value, 1) },
      altitude: { value: (moment, i) => moment.altitude(i), text: (value) => text(value, 0) },
      speed: { value: (moment, i) => moment.speed(i), text: (value) => text(value, 1) },
    };
    for (const button of element.querySelectorAll("[data-sort]")) {
      button.addEventListener("click", () => {
        this.descending = this.sort === button.dataset.sort && !this.descending;
        this.sort = button.dataset.sort;
        for (const other of element.querySelectorAll("[data-sort]")) {
          const order = this.descending ? "descending" : "ascending";
          other.parentElement.setAttribute("aria-sort", other === button ? order : "none");
        }
        this.draw();
      });
    }
    filter.addEventListener("input", () => this.draw());
    element.addEventListener("scroll", () => this.drawRows());
    this.element = element;
    this.body.addEventListener("click", (event) => {
      const row = event.target.closest("[data-index]");
      if (!row) return;
      const index = Number(row.dataset.index);
      const more = event.ctrlKey || event.metaKey;
      stage.select(more ? [...stage.selected, index] : [index]);
      if (!more) stage.lookAt([index]);
    });
    this.body.addEventListener("keydown", (event) => {
      if (event.key === "Enter") event.target.click();
    });
  }

  /** Sorts and filters anew, and draws. */
  draw() {
    const moment = this.stage.player.shownStatus();
    this.moment = moment;
    if (!moment) return;
    const words = this.filter.value.trim().toLowerCase().split(/\s+/).filter(Boolean);
    const { columns, roster } = this;
    const fits = (i) => words.every((word) => {
      const less = /^(sep|separation|clear|clearance|age|alt|altitude|speed)([<>])(-?[\d.]+)$/.exec(word);
      if (less) {
        const name = Object.keys(columns).find((column) => column.startsWith(less[1]));
        const value = columns[name].value(moment, i);
        return less[2] === "<" ? value < Number(less[3]) : value > Number(less[3]);
      }
      if (/^\d+$/.test(word)) return String(roster.numbers[i] ?? i + 1) === word;
      const own = `${columns.mode.value(moment, i)} ${stateOf(moment.flags(i))} ${roster.kinds[i] ?? ""}`.toLowerCase();
      return word === "alarm" ? severity(moment.flags(i)) > 0 : own.includes(word);
    });
    const order = [];
    for (let i = 0; i < moment.n; i++) if (!words.length || fits(i)) order.push(i);
    const column = columns[this.sort];
    const key = new Map(order.map((i) => [i, column.rank ? column.rank(moment, i) : column.value(moment, i)]));
    const sign = this.descending ? -1 : 1;
    order.sort((a, b) => {
      const [x, y] = [key.get(a), key.get(b)];
      if (typeof x === "string") return sign * x.localeCompare(y) || a - b;
      // What is unknown is last, however it is sorted.
      if (Number.isNaN(x) || Number.isNaN(y)) return (Number.isNaN(x) ? 1 : 0) - (Number.isNaN(y) ? 1 : 0) || a - b;
      return sign * (x - y) || a - b;
    });
    this.order = order;
    this.count.textContent = words.length ? `${order.length} of ${moment.n}` : `${moment.n}`;
    this.room.style.height = `${order.length * ROW_PX}px`;
    this.drawRows();
  }

  drawRows() {
    const { moment, order, columns } = this;
    if (!moment) return;
    const first = Math.max(0, Math.floor(this.element.scrollTop / ROW_PX) - 2);
    const shown = order.slice(first, first + Math.ceil(this.element.clientHeight / ROW_PX) + 4);
    this.body.style.transform = `translateY(${first * ROW_PX}px)`;
    while (this.body.children.length > shown.length) this.body.lastChild.remove();
    while (this.body.children.length < shown.length) {
      const row = document.createElement("div");
      row.className = "row";
      row.setAttribute("role", "row");
      row.tabIndex = 0;
      for (let k = 0; k < Object.keys(columns).length; k++) {
        const cell = document.createElement("span");
        cell.setAttribute("role", "cell");
        row.append(cell);
      }
      this.body.append(row);
    }
    shown.forEach((i, at) => {
      const row = this.body.children[at];
      row.dataset.index = i;
      const level = severity(moment.flags(i));
      row.className = `row level-${level}`;
      row.setAttribute("aria-selected", this.stage.selected.has(i));
      Object.values(columns).forEach((column, k) => {
        const words = column.text(column.value(moment, i));
        if (row.children[k].textContent !== words) row.children[k].textContent = words;
      });
    });
  }
}
