// The picture: one scene from above or from the side, and the hands on it: mouse, touch, keyboard.

import { Camera } from "./camera.js";
import { painterFor } from "./painter.js";
import { Shapes, wordOfCss, colourWord } from "./shapes.js";
import { Overlay } from "./overlay.js";
import { Grid, makeScenery } from "./scenery.js";
import { Hands } from "./hands.js";
import { Flock } from "./player.js";
import { FLAG } from "./wire.js";

/** Trails are drawn for so many vehicles, and reach back so far, s. */
const TRAILS_MAX = 500, TRAIL_S = 20, TRAIL_OF_MANY_S = 6;
const ALARMS = FLAG.failsafe | FLAG.stale | FLAG.lost | FLAG.separation | FLAG.clearance | FLAG.left;
const FAULTS = FLAG.lost | FLAG.clearance;
const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]]; // viridis

/** Colours by a quantity: its name, its unit, and how it is read from a moment. */
const QUANTITIES = {
  altitude: { unit: "m", of: (moment, i) => moment.altitude(i) },
  speed: { unit: "m/s", of: (moment, i) => moment.speed(i) },
  separation: { unit: "m", of: (moment, i) => moment.separation(i) },
  clearance: { unit: "m", of: (moment, i) => moment.clearance(i) },
  formation: { unit: "", of: (moment, i) => moment.weight(0, i) },
  obstacle: { unit: "", of: (moment, i) => moment.weight(1, i) },
  velocity: { unit: "", of: (moment, i) => moment.weight(2, i) },
};

/** What asks for a look, worst first: 2 a fault, 1 an alarm, 0 nothing. */
export function severity(flags) {
  return flags & FAULTS ? 2 : flags & ALARMS ? 1 : 0;
}

export class Stage {
  constructor(element, player, wanted) {
    this.player = player;
    this.element = element;
    [this.canvas, this.over] = ["picture", "marks"].map((name) => {
      const canvas = document.createElement("canvas");
      canvas.className = name;
      element.append(canvas);
      return canvas;
    });
    this.painter = painterFor(this.canvas, wanted);
    this.overlay = new Overlay(this.over);
    this.camera = new Camera();
    this.flock = new Flock();
    this.scene = { circles: [], outlines: [] };
    this.numbers = [];
    this.grid = new Grid();
    this.selected = new Set();
    this.follows = false;
    this.isTouched = false;  // whether somebody has moved the camera
    this.colourBy = "state";
    this.drawn = -1;
    this.drawnMarks = 0;
    this.frames = 0;
    this.onSelect = () => {};
    this.ways = () => null;  // predicted ways of the selected vehicle
    this.readPalette();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.readPalette());
    new ResizeObserver(() => this.resize()).observe(element);
    this.hands = new Hands(this, this.over);
  }

  readPalette() {
    const style = getComputedStyle(document.documentElement);
    const css = (name) => style.getPropertyValue(`--${name}`).trim();
    const names = ["page", "ink", "soft", "accent", "calm", "warn", "fault", "circle", "line", "fence"];
    this.palette = Object.fromEntries(names.map((name) => [name, css(name)]));
    this.palette.chosen = css("s2");
    this.painter.setBackground(this.palette.page);
    this.isStale = true;
    makeScenery(this.painter, this.palette, this.scene);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    const ratio = Math.min(2, devicePixelRatio || 1);
    const isFirst = this.camera.width === 1;
    [this.camera.width, this.camera.height] = [width, height];
    this.camera.update();
    this.painter.resize(width, height, ratio);
    this.overlay.resize(width, height, ratio);
    if (isFirst && !this.isTouched) this.fit();
    this.isStale = true;
  }

  setScene(scene) {
    // Wind that turns moves no camera.
    const places = ({ circles, outlines }) => JSON.stringify([circles, outlines]);
    if (places(scene) !== places(this.scene)) this.isFitted = false;
    this.scene = scene;
    makeScenery(this.painter, this.palette, scene);
    this.isStale = true;
  }

  // ---- What moves ----

  makeTrails() {
    const { player, flock } = this;
    const whose = flock.n <= TRAILS_MAX ? null : [...this.selected];
    const trails = new Shapes(4096);
    if (whose === null || whose.length) {
      const span = flock.n > 100 ? TRAIL_OF_MANY_S : TRAIL_S;
      const until = player.now, from = until - span;
      const first = player.indexAt(from);
      const last = player.indexAt(until);
      const isShown = ({ time }) => time >= from && time <= until;
      const moments = player.moments.slice(first, last + 1).filter(isShown);
      // A trail needs few corners, however many moments there are.
      const stride = Math.max(1, Math.ceil(moments.length / (flock.n > 100 ? 20 : 80)));
      const base = wordOfCss(this.palette.calm, 0) & 0xffffff;
      const draw = (i) => {
        let before = null;
        for (let k = moments.length - 1; k >= -stride; k -= stride) {
          const moment = moments[Math.max(0, k)];
          if (!moment || i >= moment.n) break;
          const then = () => [moment.x(i), moment.y(i), moment.altitude(i), moment.time];
          const here = before ? then() : [flock.x[i], flock.y[i], flock.z[i], until];
          if (before && Number.isFinite(here[0]) && Number.isFinite(before[0])) {
            // In a few steps: all of one colour is drawn in one go.
            const opacity = 20 * Math.round(10 * Math.max(0, 1 - (until - here[3]) / span));
            const colour = (base | (opacity << 24)) >>> 0;
            trails.corner(before[0], before[1], before[2], colour);
            trails.corner(here[0], here[1], here[2], colour);
          }
          before = here;
          if (k <= 0) break;
        }
      };
      if (whose) whose.forEach(draw); else for (let i = 0; i < flock.n; i++) draw(i);
    }
    // In 3-D a selected vehicle stands on a line down to the ground.
    const ink = wordOfCss(this.palette.ink, 0.6);
    if (this.camera.is3d) {
      for (let i = 0; i < flock.n; i++) {
        if (flock.n > 60 && !this.selected.has(i)) continue;
        trails.corner(flock.x[i], flock.y[i], flock.z[i], ink);
        trails.corner(flock.x[i], flock.y[i], 0, ink);
      }
    }
    this.painter.setShapes("trails", "lines", trails.used);
  }

  colour() {
    const { flock } = this;
    const status = this.player.shownStatus();
    const quantity = QUANTITIES[this.colourBy];
    this.scaleText = "";
    if (quantity && status) {
      let [low, high] = [Infinity, -Infinity];
      const values = Array.from({ length: Math.min(flock.n, status.n) }, (_, i) => quantity.of(status, i));
      for (const value of values) {
        if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
      for (let i = 0; i < flock.n; i++) flock.colour[i] = ramp((values[i] - low) / Math.max(1e-6, high - low));
      if (low <= high) this.scaleText = `${low.toFixed(1)} to ${high.toFixed(1)} ${quantity.unit}`;
      return;
    }
    const words = [this.palette.calm, this.palette.warn, this.palette.fault].map((css) => wordOfCss(css));
    const soft = wordOfCss(this.palette.soft, 0.8);
    for (let i = 0; i < flock.n; i++) {
      const flags = status && i < status.n ? status.flags(i) : 0;
      flock.colour[i] = flags & FLAG.ground && !severity(flags) ? soft : words[severity(flags)];
    }
  }

  /** Draws what is to be seen at the page's clock, ms. */
  draw(clock) {
    const { player, camera, flock } = this;
    const ahead = player.ahead(clock);
    const isNew = player.version !== this.drawn;
    if (isNew) {
      this.drawn = player.version;
      player.fill(flock);
      if (!this.isFitted && flock.n) { this.isFitted = true; if (!this.isTouched) this.fit(); }
      this.colour();
      this.painter.setFlock(flock);
      this.makeTrails();
    } else if (this.isStale) {
      this.colour();
      this.painter.setFlock(flock);
      this.makeTrails();
    }
    if (this.follows) this.followOn(ahead);
    const moves = ahead > 0 && flock.n > 0 && player.newest && player.newest.rate > 0;
    if (!isNew && !this.isStale && !moves) return;
    this.grid.make(this.painter, this.palette, camera);
    const [walls, posts] = camera.is3d ? [["walls"], ["posts"]] : [[], []];
    const layers = ["grid", "discs", ...walls, "edges", ...posts, "outlines", "trails"];
    const size = (flock.n > 2000 ? 4 : flock.n > 60 ? 6 : 9) * this.overlay.size;
    this.painter.draw(camera, layers, size, ahead);
    this.frames++;
    // Marks are dear where a page has no GPU: with many vehicles they follow ten times a second.
    if (isNew || this.isStale || (flock.n <= 1500 && clock - this.drawnMarks > 30)) {
      this.drawnMarks = clock;
      this.drawMarks(ahead);
    }
    this.isStale = false;
  }

  drawMarks(ahead) {
    const { flock, palette } = this;
    const status = this.player.shownStatus();
    const marks = [];
    for (let i = 0; status && i < Math.min(flock.n, status.n); i++) {
      const level = severity(status.flags(i));
      if (level) marks.push([i, level === 2 ? palette.fault : palette.warn, level]);
      if (marks.length > 300) break;
    }
    for (const i of this.selected) marks.push([i, palette.ink, 1]);
    const wind = this.scene.wind;
    const [one] = this.selected;
    const ways = this.selected.size === 1 && one < flock.n ? this.ways() : null;
    this.overlay.draw({
      camera: this.camera, palette, flock, ahead, marks, box: this.hands.box, wind, ways, height: flock.z[one],
      outlines: this.scene.outlines, own: new Set([...this.selected].map((i) => this.numbers[i])),
      labels: (i) => String(this.numbers[i] ?? i + 1),
      fenceText: this.scaleText,
    });
  }

  // ---- The camera ----

  fit() {
    const { flock, scene } = this;
    let [north, south, east, west] = [-Infinity, Infinity, -Infinity, Infinity];
    const add = (x, y, radius) => {
      if (!Number.isFinite(x) || !Number.isFinite(y)) return;
      north = Math.max(north, x + radius); south = Math.min(south, x - radius);
      east = Math.max(east, y + radius); west = Math.min(west, y - radius);
    };
    for (let i = 0; i < flock.n; i++) add(flock.x[i], flock.y[i], 10);
    for (const { x_m, y_m, radius_m } of scene.circles) add(x_m, y_m, radius_m);
    for (const { points_m } of scene.outlines) for (const [x, y] of points_m) add(x, y, 0);
    if (this.player.isRecording) {
      const moments = this.player.moments;
      const stride = Math.max(1, Math.floor(moments.length / 50));
      for (let k = 0; k < moments.length; k += stride) {
        for (let i = 0; i < moments[k].n; i++) add(moments[k].x(i), moments[k].y(i), 0);
      }
    }
    if (north < south) [north, south, east, west] = [50, -50, 50, -50];
    // A field that is longer than wide lies across a wide picture, and stands in a tall one.
    const isLongNorth = north - south > 1.6 * (east - west);
    const isLongEast = east - west > 1.6 * (north - south);
    const isWide = this.camera.width > this.camera.height;
    const across = isLongNorth && isWide ? -Math.PI / 2 : isLongEast && !isWide ? Math.PI / 2 : 0;
    if (!this.isTurned) this.camera.heading = across;
    this.camera.fit([north, south, east, west], this.camera.is3d ? this.meanAltitude() : 0);
    this.isStale = true;
  }

  meanAltitude() {
    const { flock } = this;
    let [sum, count] = [0, 0];
    for (let i = 0; i < flock.n; i++) if (Number.isFinite(flock.x[i])) { sum += flock.z[i]; count++; }
    return count ? sum / count : 0;
  }

  followOn(ahead) {
    const { flock } = this;
    const whose = this.selected.size ? [...this.selected] : Array.from({ length: flock.n }, (_, i) => i);
    let [x, y, count] = [0, 0, 0];
    for (const i of whose) {
      if (!Number.isFinite(flock.x[i])) continue;
      x += flock.x[i] + Math.cos(flock.course[i]) * flock.speed[i] * ahead;
      y += flock.y[i] + Math.sin(flock.course[i]) * flock.speed[i] * ahead;
      count++;
    }
    if (!count) return;
    const to = [x / count, y / count];
    if (Math.hypot(to[0] - this.camera.centre[0], to[1] - this.camera.centre[1]) * this.camera.scale < 0.3) return;
    [this.camera.centre[0], this.camera.centre[1]] = to;
    this.camera.update();
    this.isStale = true;
  }

  set3d(is3d) {
    this.camera.is3d = is3d;
    if (is3d && this.camera.tilt > 1.2) this.camera.tilt = 0.6;
    this.camera.centre[2] = is3d ? this.meanAltitude() : 0;
    this.camera.update();
    this.isStale = true;
  }

  northUp() {
    this.isTurned = true;
    this.camera.heading = 0;
    this.camera.update();
    this.isStale = true;
  }

  /** Puts vehicles into the middle of the picture, large enough to see. */
  lookAt(indices) {
    const placed = indices.filter((i) => Number.isFinite(this.flock.x[i]));
    if (!placed.length) return;
    const mean = (values) => placed.reduce((sum, i) => sum + values[i], 0) / placed.length;
    this.camera.centre[0] = mean(this.flock.x);
    this.camera.centre[1] = mean(this.flock.y);
    // Several that are near to one another are told apart.
    const spread = (values) => Math.max(...placed.map((i) => values[i])) - Math.min(...placed.map((i) => values[i]));
    const apart = 120 / Math.max(10, Math.hypot(spread(this.flock.x), spread(this.flock.y)));
    this.camera.scale = Math.max(this.camera.scale, placed.length > 1 ? Math.min(12, apart) : 3);
    this.camera.update();
    // What moves stays in the picture, until somebody moves the picture by hand.
    this.follows = this.player.isLive || this.player.isPlaying;
    this.isTouched = true;
    this.isStale = true;
    this.onSelect();
  }

  select(indices) {
    this.selected = new Set(indices);
    this.isStale = true;
    this.onSelect();
  }

  /** Somebody has moved the camera: it is not moved by itself any more. */
  touched() {
    this.isTouched = true;
    this.isStale = true;
  }

  nearest([px, py]) {
    let [best, least] = [null, 22];
    for (let i = 0; i < this.flock.n; i++) {
      const place = this.placeOf(i);
      const distance = place ? Math.hypot(place[0] - px, place[1] - py) : Infinity;
      if (distance < least) [best, least] = [i, distance];
    }
    return best;
  }

  inBox([x0, y0, x1, y1]) {
    const inside = [];
    for (let i = 0; i < this.flock.n; i++) {
      const place = this.placeOf(i);
      const isBetween = (value, from, to) => value >= Math.min(from, to) && value <= Math.max(from, to);
      if (place && isBetween(place[0], x0, x1) && isBetween(place[1], y0, y1)) inside.push(i);
    }
    return inside;
  }

  /** Where a vehicle is in the picture, or null. */
  placeOf(i) {
    const { x, y, z } = this.flock;
    return Number.isFinite(x[i]) ? this.camera.project(x[i], y[i], z[i]) : null;
  }
}

function ramp(share) {
  if (!Number.isFinite(share)) return colourWord(128, 128, 128);
  const place = Math.min(1, Math.max(0, share)) * (RAMP.length - 1);
  const index = Math.min(RAMP.length - 2, Math.floor(place));
  const [low, high] = [RAMP[index], RAMP[index + 1]];
  return colourWord(...low.map((from, part) => Math.round(from + (place - index) * (high[part] - from))));
}
