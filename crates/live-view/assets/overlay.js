// What is written and marked above the picture: scales, numbers, rings, the north arrow, the wind, a box that is drawn.

const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000];
/** Numbers are written beside so many vehicles at most. */
const LABELS_MAX = 60;

/** Metres between two lines of the grid. */
export function gridStep(scale) {
  return STEPS.find((metres) => metres * scale >= 70) ?? 50000;
}

export class Overlay {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  resize(width, height, ratio) {
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.ratio = ratio;
  }

  /** Draws all marks. `marks` are [index, colour, rings]. */
  draw({ camera, palette, flock, ahead, marks, labels, box, wind, fenceText }) {
    const context = this.context;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    context.font = "12px system-ui, sans-serif";
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
        context.arc(place[0], place[1], 12 + 4 * ring, 0, 2 * Math.PI);
        context.stroke();
      }
    }
    this.writeNumbers(camera, palette, flock, labels, at);
    this.drawScale(camera, palette);
    this.drawNorth(camera, palette);
    if (wind) this.drawWind(camera, palette, wind);
    if (fenceText) this.write(fenceText, 12, 20, palette);
    if (box) {
      context.strokeStyle = palette.ink;
      context.setLineDash([4, 3]);
      context.lineWidth = 1;
      context.strokeRect(Math.min(box[0], box[2]), Math.min(box[1], box[3]), Math.abs(box[2] - box[0]), Math.abs(box[3] - box[1]));
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
      if (place && place[0] > 0 && place[1] > 0 && place[0] < camera.width && place[1] < camera.height) seen.push([i, place]);
    }
    if (seen.length > LABELS_MAX) return;
    for (const [i, place] of seen) this.write(labels(i), place[0] + 9, place[1] - 8, palette);
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
    context.moveTo(0, 14); context.lineTo(0, -14); context.lineTo(-5, -7); context.moveTo(0, -14); context.lineTo(5, -7);
    context.stroke();
    context.restore();
    this.write(`wind ${wind.speed_mps.toFixed(1)} m/s`, x - 42, y + 30, palette);
  }
}
