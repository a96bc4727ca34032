// From metres to pixels. x is north, y is east, z is up; the picture from above and the one from the side are one
// camera: from above it looks straight down, and has no perspective.

const FIELD_OF_VIEW = 0.7; // rad
const SCALE_MIN = 0.002, SCALE_MAX = 200; // px per m

export class Camera {
  constructor() {
    this.centre = [0, 0, 0];
    this.scale = 2;          // px per m, at the centre
    this.heading = 0;        // the course that points up in the picture, rad
    this.tilt = Math.PI / 2; // how steeply it looks down, rad
    this.is3d = false;
    this.width = this.height = 1;
    this.update();
  }

  update() {
    const tilt = this.is3d ? this.tilt : Math.PI / 2;
    const [c, s] = [Math.cos(this.heading), Math.sin(this.heading)];
    const [ct, st] = [Math.cos(tilt), Math.sin(tilt)];
    this.right = [-s, c, 0];
    this.up = [st * c, st * s, ct];
    this.forward = [ct * c, ct * s, -st];
    this.distance = this.is3d ? this.height / (2 * this.scale * Math.tan(FIELD_OF_VIEW / 2)) : Infinity;
  }

  /** Column by column, for shaders: clip x, y, 0, w. */
  matrix() {
    const rows = [
      [this.right, 2 * this.scale / this.width, 0],
      [this.up, 2 * this.scale / this.height, 0],
      [[0, 0, 0], 0, 0],
      [this.forward, this.is3d ? 1 / this.distance : 0, 1],
    ];
    const out = new Float32Array(16);
    rows.forEach(([axis, factor, constant], row) => {
      let offset = constant;
      for (let k = 0; k < 3; k++) {
        out[4 * k + row] = axis[k] * factor;
        offset -= axis[k] * factor * this.centre[k];
      }
      out[12 + row] = offset;
    });
    return out;
  }

  /** Whether a place in the picture is within its edges. */
  shows([x, y]) {
    return x > 0 && y > 0 && x < this.width && y < this.height;
  }

  /** Pixels of a place, or null where it is behind the camera. */
  project(x, y, z) {
    const [dx, dy, dz] = [x - this.centre[0], y - this.centre[1], z - this.centre[2]];
    const along = (axis) => axis[0] * dx + axis[1] * dy + axis[2] * dz;
    const w = this.is3d ? 1 + along(this.forward) / this.distance : 1;
    if (w <= 0.01) return null;
    const factor = this.scale / w;
    return [this.width / 2 + along(this.right) * factor, this.height / 2 - along(this.up) * factor];
  }

  /** The place at the height of the centre that is seen at a pixel, or null above the horizon. */
  ground(px, py) {
    const [h, v] = [(px - this.width / 2) / this.scale, (this.height / 2 - py) / this.scale];
    if (!this.is3d) return [0, 1].map((k) => this.centre[k] + h * this.right[k] + v * this.up[k]);
    const ray = [0, 1, 2].map((k) => this.distance * this.forward[k] + h * this.right[k] + v * this.up[k]);
    const eyeHeight = -this.distance * this.forward[2];
    if (ray[2] >= -1e-6 * this.distance) return null;
    const reach = eyeHeight / -ray[2];
    if (reach > 50) return null;
    return [0, 1].map((k) => this.centre[k] - this.distance * this.forward[k] + reach * ray[k]);
  }

  pan(dx, dy) {
    const squash = this.is3d ? Math.max(0.2, Math.sin(this.tilt)) : 1;
    for (let k = 0; k < 2; k++) {
      const ahead = k === 0 ? Math.cos(this.heading) : Math.sin(this.heading);
      this.centre[k] -= (dx * this.right[k] - dy * ahead / squash) / this.scale;
    }
    this.update();
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const before = this.ground(px, py);
    this.scale = Math.min(SCALE_MAX, Math.max(SCALE_MIN, this.scale * factor));
    this.update();
    const after = this.ground(px, py);
    if (before && after) for (let k = 0; k < 2; k++) this.centre[k] += before[k] - after[k];
    this.update();
  }

  turn(heading, tilt) {
    this.heading += heading;
    this.tilt = Math.min(Math.PI / 2, Math.max(0.12, this.tilt + tilt));
    this.update();
  }

  /** Shows a box of the ground, [north, south, east, west] in m, as large as it fits. */
  fit([north, south, east, west], z) {
    this.centre = [(north + south) / 2, (east + west) / 2, z];
    const [c, s] = [Math.abs(Math.cos(this.heading)), Math.abs(Math.sin(this.heading))];
    const [tall, wide] = [north - south, east - west];
    const [up, across] = [c * tall + s * wide, s * tall + c * wide];
    const margin = this.is3d ? 1.35 : 1.12;
    this.scale = Math.min(this.width / Math.max(10, across * margin), this.height / Math.max(10, up * margin));
    this.scale = Math.min(20, Math.max(SCALE_MIN, this.scale));
    this.update();
  }
}
