// Which moment is shown: the present of a live flight, or any moment of what is remembered of it, or of a recording.

/** So many bytes of a live flight are remembered. */
const REMEMBERED_BYTES = 64 * 1024 * 1024;
/** Remembered moments of a live flight are this far apart, s. */
const STEP_S = 0.25;
/** A picture is moved on from its moment for so long at most, s of the wall clock. */
const AHEAD_S = 0.4;

export class Player {
  constructor() {
    this.moments = [];      // in order of time, with a status each
    this.bytes = 0;
    this.newest = null;     // the present of a live flight; need not have a status
    this.status = null;     // the newest with a status
    this.isLive = true;     // whether the newest is shown
    this.isRecording = false;
    this.isPlaying = true;
    this.speed = 1;
    this.duration = 0;      // of a recording, as far as it is known, s
    this.now = 0;           // flight time shown, s
    this.arrived = 0;       // when the newest came, ms of the page's clock
    this.version = 0;       // counts pictures that differ
  }

  get start() { return this.moments.length ? this.moments[0].time : 0; }
  get end() {
    const last = this.moments.length ? this.moments[this.moments.length - 1].time : 0;
    return this.newest ? Math.max(last, this.newest.time) : last;
  }

  /** The end of all that there will be: of a recording that is still being read it is known before. */
  get last() { return Math.max(this.end, this.duration); }

  /** Begins a recording, with the moments that are there. */
  record(moments) {
    this.moments = moments;
    this.isRecording = true;
    this.isLive = false;
    this.now = this.start;
    this.version++;
  }

  /** Takes more moments of a recording, which come after all others. */
  append(moments) {
    for (const moment of moments) this.moments.push(moment);
    this.now = Math.max(this.now, this.start);
    this.version++;
  }

  /** Takes a moment of a live flight. */
  take(moment, arrived) {
    if (this.newest && moment.time < this.newest.time - 0.001) this.forget(moment.time);
    const last = this.moments[this.moments.length - 1];
    if (moment.hasStatus) {
      this.status = moment;
      if (!last || moment.time - last.time >= STEP_S) {
        this.moments.push(moment);
        this.bytes += moment.bytes;
        while (this.bytes > REMEMBERED_BYTES) this.bytes -= this.moments.shift().bytes;
      }
    }
    if (moment.isHistory) return;
    this.newest = moment;
    this.arrived = arrived;
    if (this.isLive) {
      this.now = moment.time;
      this.version++;
    }
  }

  /** Time went back: another flight, of which nothing is remembered after this. */
  forget(time) {
    this.moments = this.moments.filter((moment) => moment.time <= time);
    this.bytes = this.moments.reduce((sum, moment) => sum + moment.bytes, 0);
  }

  /** Moves the shown time on by so many seconds of the wall clock. */
  advance(seconds) {
    if (this.isLive || !this.isPlaying || !this.moments.length) return;
    const end = this.end;
    if (this.now >= end) {
      if (!this.isRecording) this.goLive();
      else if (end >= this.duration - 1e-3) this.isPlaying = false;
      this.version++;
      return;
    }
    this.now = Math.min(end, this.now + seconds * this.speed);
    this.version++;
  }

  goLive() {
    if (this.isRecording) { this.seek(this.end); return; }
    this.isLive = true;
    this.isPlaying = true;
    if (this.newest) this.now = this.newest.time;
    this.version++;
  }

  seek(time) {
    this.isLive = false;
    this.now = Math.min(this.end, Math.max(this.start, time));
    this.version++;
  }

  toggle() {
    if (this.isLive) { this.isLive = false; this.isPlaying = false; }
    else {
      this.isPlaying = !this.isPlaying;
      if (this.isPlaying && this.isRecording && this.now >= this.end) this.now = this.start;
    }
    this.version++;
  }

  /** To the next moment, or the one before. */
  step(by) {
    this.isPlaying = false;
    const index = this.indexAt(this.now);
    const exact = this.moments[index] && Math.abs(this.moments[index].time - this.now) < 1e-6;
    const to = by > 0 ? index + 1 : exact ? index - 1 : index;
    if (this.moments[to]) this.seek(this.moments[to].time);
  }

  /** The last remembered moment that is not after a time. */
  indexAt(time) {
    let low = 0, high = this.moments.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.moments[middle].time <= time) low = middle; else high = middle - 1;
    }
    return low;
  }

  /** The moment whose status is shown. */
  shownStatus() {
    return this.isLive ? this.status : this.moments[this.indexAt(this.now)] ?? null;
  }

  /** Writes where everybody is into `flock`: x, y, z, course, speed; gives how many there are. */
  fill(flock) {
    const index = this.indexAt(this.now);
    const a = this.isLive ? this.newest : this.moments[index];
    if (!a) return 0;
    flock.reserve(a.n);
    const b = this.isLive ? a : this.moments[index + 1] ?? a;
    const part = b.time > a.time ? Math.min(1, (this.now - a.time) / (b.time - a.time)) : 0;
    for (let i = 0; i < a.n; i++) {
      flock.x[i] = a.x(i); flock.y[i] = a.y(i); flock.z[i] = a.altitude(i);
      flock.course[i] = a.course(i); flock.speed[i] = a.speed(i);
    }
    if (part > 0) {
      for (let i = 0; i < Math.min(a.n, b.n); i++) {
        if (!a.isPlaced(i) || !b.isPlaced(i)) continue;
        flock.x[i] += part * (b.x(i) - flock.x[i]);
        flock.y[i] += part * (b.y(i) - flock.y[i]);
        flock.z[i] += part * (b.altitude(i) - flock.z[i]);
        const turn = ((b.course(i) - flock.course[i] + 3 * Math.PI) % (2 * Math.PI)) - Math.PI;
        flock.course[i] += part * turn;
        flock.speed[i] += part * (b.speed(i) - flock.speed[i]);
      }
    }
    flock.n = a.n;
    return a.n;
  }

  /** Flight seconds by which the newest moment is to be moved on, at the page's clock. */
  ahead(clock) {
    if (!this.isLive || !this.newest) return 0;
    return Math.min(AHEAD_S, Math.max(0, (clock - this.arrived) / 1000)) * this.newest.rate;
  }

  /** What is remembered of one vehicle, one value of `read(moment)` for each moment up to the shown time. */
  series(reads, from = -Infinity) {
    const until = this.isLive ? Infinity : this.now;
    const columns = [[], ...reads.map(() => [])];
    const stride = Math.max(1, Math.ceil(this.moments.length / 2000));
    for (let at = 0; at < this.moments.length; at += stride) {
      const moment = this.moments[at];
      if (moment.time < from || (moment.time > until && !this.isRecording)) continue;
      columns[0].push(moment.time);
      reads.forEach((read, index) => {
        const value = read(moment);
        columns[index + 1].push(Number.isFinite(value) ? value : null);
      });
    }
    return columns;
  }
}

/** Where everybody is at the shown time. */
export class Flock {
  constructor() { this.n = 0; this.capacity = 0; this.reserve(1); }
  reserve(n) {
    if (n <= this.capacity) return;
    this.capacity = Math.max(16, 2 * n);
    for (const name of ["x", "y", "z", "course", "speed"]) this[name] = new Float32Array(this.capacity);
    this.colour = new Uint32Array(this.capacity);
  }
}
