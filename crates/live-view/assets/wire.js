// A frame of the flight, read in place: the layout is that of `src/wire.rs`.

export const FLAG = {
  armed: 1, follows: 2, ground: 4, out: 8, failsafe: 16, stale: 32, lost: 64,
  separation: 128, clearance: 256, left: 512,
};
const [STATUS, STEERING, FINE, HISTORY] = [1, 2, 4, 8];
const HEADER = 64;
const NONE = 65535;
const TURN = 2 * Math.PI;

/** One moment of the flight. Quantities are those of vehicle `i`, in metres, seconds and radians; NaN where unknown. */
export class Moment {
  constructor(buffer) {
    const head = new DataView(buffer, 0, HEADER);
    const bits = head.getUint8(1);
    this.bytes = buffer.byteLength;
    this.n = head.getUint32(4, true);
    this.time = head.getFloat64(8, true);
    this.rate = head.getFloat64(16, true);
    this.zero = [24, 32, 40].map((at) => head.getFloat64(at, true));
    this.unit = head.getFloat32(48, true);
    this.unitUp = head.getFloat32(52, true);
    this.roster = head.getUint32(60, true);
    this.isHistory = (bits & HISTORY) !== 0;
    this.hasStatus = (bits & STATUS) !== 0;
    this.hasSteering = (bits & STEERING) !== 0;
    this.isFine = (bits & FINE) !== 0;
    // The first column of each group, in columns of two bytes.
    const status = this.isFine ? 5 : 3;
    const steering = status + (this.hasStatus ? 3 : 0);
    const wide = steering + (this.hasSteering ? 6 : 0);
    [this.statusAt, this.steeringAt] = [status * this.n, steering * this.n];
    this.wide = new Uint16Array(buffer, HEADER, wide * this.n);
    this.narrow = new Uint8Array(buffer, HEADER + 2 * wide * this.n);
    this.ageAt = this.isFine ? 0 : 2 * this.n;
  }

  isPlaced(i) { return this.wide[i] !== NONE; }
  x(i) { return this.wide[i] === NONE ? NaN : this.zero[0] + this.wide[i] * this.unit; }
  y(i) { return this.wide[i] === NONE ? NaN : this.zero[1] + this.wide[this.n + i] * this.unit; }
  altitude(i) { return this.zero[2] + this.wide[2 * this.n + i] * this.unitUp; }
  course(i) {
    return this.isFine ? this.wide[3 * this.n + i] * TURN / 65536 : this.narrow[i] * TURN / 256;
  }
  speed(i) { return this.isFine ? this.wide[4 * this.n + i] / 100 : this.narrow[this.n + i] / 2; }

  // With a status:
  separation(i) { return this.status(0, i, (value) => value / 100); }
  clearance(i) { return this.status(1, i, (value) => (value - 32768) / 100); }
  flags(i) { return this.hasStatus ? this.wide[this.statusAt + 2 * this.n + i] : 0; }
  age(i) {
    const tenths = this.hasStatus ? this.narrow[this.ageAt + i] : 255;
    return tenths === 255 ? NaN : tenths / 10;
  }
  mode(i) { return this.hasStatus ? this.narrow[this.ageAt + this.n + i] : 255; }
  status(column, i, read) {
    const value = this.hasStatus ? this.wide[this.statusAt + column * this.n + i] : NONE;
    return value === NONE ? NaN : read(value);
  }

  // With what the controller chose:
  weight(term, i) { return this.steering(term, i, (value) => value / 1000); }
  speedAsked(i) { return this.steering(3, i, (value) => value / 100); }
  courseAsked(i) { return this.steering(4, i, (value) => value * TURN / 65535); }
  altitudeAsked(i) { return this.steering(5, i, (value) => value / 10 - 1000); }
  steering(column, i, read) {
    const value = this.hasSteering ? this.wide[this.steeringAt + column * this.n + i] : NONE;
    return value === NONE ? NaN : read(value);
  }
}

/** The moments of a recording: each with its length before it. */
export function momentsOf(buffer) {
  const view = new DataView(buffer);
  const moments = [];
  for (let at = 0; at + 4 <= buffer.byteLength;) {
    const length = view.getUint32(at, true);
    moments.push(new Moment(buffer.slice(at + 4, at + 4 + length)));
    at += 4 + length;
  }
  return moments;
}
