// What is written and marked above the picture: scales, numbers, rings, the north arrow, the wind, a box that is drawn.

import { hasGpu } from "./painter.js";

const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000];
/** Numbers are written beside so many vehicles at most. */
const LABELS_MAX = 60;
/** Marks of plans are drawn for so many lines, or for the selected vehicles. */
const OUTLINES_FEW = 12;
/** Where a number may stand beside its vehicle, from there to its middle, px. */
const CORNERS = [[14, -13], [14, 13], [-14, -13], [-14, 13]];

/** Metres between two lines of the grid. */
export function gridStep(scale) {
  return STEPS.find((metres) => metres * scale >= 70) ?? 50000;
}

export class Overlay {
  constructor(canvas) {
    this.canvas = canvas;
    // Without a GPU the marks are drawn faster by the processor than by a GPU that it only plays.
    this.context = canvas.getContext("2d", { willReadFrequently: !hasGpu() });
    this.corners = new Map(); // at which corner of its vehicle each number was last written
  }

  resize(width, height, ratio) {
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.ratio = ratio;
    // As large as the page's words are: 1 on most screens, more on very large ones.
    this.size = parseFloat(getComputedStyle(document.documentElement).fontSize) / 14;
  }

  /** Draws all marks. `marks` are [index, colour, rings]. */
  draw({ camera, palette, flock, ahead, marks, labels, box, wind, fenceText, ways, height, outlines, own }) {
    const context = this.context;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    context.font = `${Math.round(12 * this.size)}px system-ui, sans-serif`;
    context.lineJoin = "round";
    const at = (i) => camera.project(
      flock.x[i] + Math.cos(flock.course[i]) * flock.speed[i] * ahead,
      flock.y[i] + Math.sin(flock.course[i]) * flock.speed[i] * ahead, flock.z[i]);
    for (const [i, colour, rings] of marks) {
      const place = flock.x[i] === flock.x[i] ? at(i) : null;
      if (!place) continue;
      context.strokeStyle = colour;
      context.lineWidth = 2;
      for (let ring = 0; ring < rings; ring++) {
        context.beginPath();
        context.arc(place[0], place[1], (12 + 4 * ring) * this.size, 0, 2 * Math.PI);
        context.stroke();
      }
    }
    this.drawPlaces(camera, palette, outlines, own);
    if (ways) this.drawWays(camera, palette, ways, height);
    this.writeNumbers(camera, palette, flock, labels, at);
    this.drawScale(camera, palette);
    this.drawNorth(camera, palette);
    if (wind) this.drawWind(camera, palette, wind);
    if (fenceText) this.write(fenceText, 12, 20, palette);
    if (box) {
      context.strokeStyle = palette.ink;
      context.setLineDash([4, 3]);
      context.lineWidth = 1;
      const [x0, y0, x1, y1] = box;
      context.strokeRect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
      context.setLineDash([]);
    }
  }

  write(text, x, y, palette, colour = palette.ink) {
    const context = this.context;
    context.lineWidth = 3;
    context.strokeStyle = palette.page;
    context.strokeText(text, x, y);
    context.fillStyle = colour;
    context.fillText(text, x, y);
  }

  writeNumbers(camera, palette, flock, labels, at) {
    const seen = [];
    for (let i = 0; i < flock.n && seen.length <= LABELS_MAX; i++) {
      const place = flock.x[i] === flock.x[i] ? at(i) : null;
      if (place && camera.shows(place)) seen.push([i, place]);
    }
    if (seen.length > LABELS_MAX) return;
    // A number that would cover another stands at another corner, or is left out; it stays where it was if it can.
    const taken = [];
    this.context.textAlign = "center";
    for (const [i, place] of seen) {
      const text = labels(i);
      const half = (4 + 4 * text.length) * this.size;
      const before = this.corners.get(i) ?? 0;
      const at = (corner, k) => place[k] + this.size * CORNERS[corner][k];
      const box = (corner) => [at(corner, 0), at(corner, 1), half];
      const isFree = ([x, y, width]) => taken.every(([x2, y2, width2]) =>
        Math.abs(x - x2) >= width + width2 - 4 || Math.abs(y - y2) >= 13 * this.size);
      const corner = [before, 0, 1, 2, 3].find((corner) => isFree(box(corner)));
      if (corner === undefined) continue;
      this.corners.set(i, corner);
      taken.push(box(corner));
      this.write(text, box(corner)[0], box(corner)[1] + 4, palette);
    }
    this.context.textAlign = "start";
  }

  /** Homes, rally points and the places of missions: of the selected vehicles, or of all of a few. */
  drawPlaces(camera, palette, outlines, own) {
    const isFew = outlines.length <= OUTLINES_FEW;
    for (const { kind, vehicle, points_m: points } of outlines) {
      if (!isFew && vehicle !== null && !own.has(vehicle)) continue;
      const letter = { home: "H", rally: "R" }[kind];
      if (!letter && kind !== "mission") continue;
      points.forEach((point) => {
        const place = camera.project(...point);
        if (!place) return;
        const context = this.context;
        [context.fillStyle, context.strokeStyle, context.lineWidth] = [palette.page, palette.accent, 1.5];
        context.beginPath();
        context.arc(place[0], place[1], letter ? 8 : 3.5, 0, 2 * Math.PI);
        context.fill();
        context.stroke();
        if (!letter) return;
        context.fillStyle = palette.ink;
        context.textAlign = "center";
        context.fillText(letter, place[0], place[1] + 4);
        context.textAlign = "start";
      });
    }
  }

  /** Where the selected vehicle could have been sent, and where it is: a dot for each control period. */
  drawWays(camera, palette, { all, chosen, pointed, evasion }, height) {
    const context = this.context;
    const trace = (path) => {
      const points = path.map(([x, y]) => camera.project(x, y, height)).filter(Boolean);
      points.forEach((point, k) => k ? context.lineTo(...point) : context.moveTo(...point));
      return points;
    };
    const line = (path, colour, width) => {
      [context.strokeStyle, context.fillStyle, context.lineWidth] = [colour, colour, width];
      context.beginPath();
      const points = trace(path);
      context.stroke();
      for (const [x, y] of points.slice(1)) {
        context.beginPath();
        context.arc(x, y, width + 0.5, 0, 2 * Math.PI);
        context.fill();
      }
    };
    [context.strokeStyle, context.lineWidth, context.globalAlpha] = [palette.calm, 1, 0.35];
    context.beginPath();
    all.forEach(trace);
    context.stroke();
    context.globalAlpha = 1;
    line(chosen, palette.chosen, 2);
    if (pointed) line(pointed, palette.ink, 2);
    if (evasion) {
      context.setLineDash([6, 4]);
      line(evasion, palette.fault, 2);
      context.setLineDash([]);
    }
  }

  /** How long a stretch of the ground is. */
  drawScale(camera, palette) {
    const metres = gridStep(camera.scale);
    const width = metres * camera.scale;
    const context = this.context;
    const [x, y] = [12, camera.height - 14];
    context.strokeStyle = palette.ink;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y - 5); context.lineTo(x, y); context.lineTo(x + width, y); context.lineTo(x + width, y - 5);
    context.stroke();
    this.write(metres >= 1000 ? `${metres / 1000} km` : `${metres} m`, x + 6, y - 6, palette);
  }

  drawNorth(camera, palette) {
    const context = this.context;
    const [x, y] = [camera.width - 26, 30];
    context.save();
    context.translate(x, y);
    context.rotate(-camera.heading);
    context.beginPath();
    context.moveTo(0, -16); context.lineTo(6, 6); context.lineTo(0, 2); context.lineTo(-6, 6); context.closePath();
    context.fillStyle = palette.ink;
    context.fill();
    context.restore();
    const [dx, dy] = [-Math.sin(camera.heading) * 14, Math.cos(camera.heading) * 14];
    this.write("N", x + dx - 4, y + dy + 5, palette);
  }

  /** An arrow that points where the wind blows to. */
  drawWind(camera, palette, wind) {
    const context = this.context;
    const [x, y] = [camera.width - 70, 30];
    context.save();
    context.translate(x, y);
    context.rotate((wind.from_deg + 180) * Math.PI / 180 - camera.heading);
    context.strokeStyle = palette.accent;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(0, 14);
    context.lineTo(0, -14);
    context.lineTo(-5, -7);
    context.moveTo(0, -14);
    context.lineTo(5, -7);
    // A calm has no direction.
    if (wind.speed_mps >= 0.1) context.stroke();
    context.restore();
    this.write(`wind ${wind.speed_mps.toFixed(1)} m/s`, x - 42, y + 30, palette);
  }
}
