// The picture on a canvas without WebGL, pixel by pixel: where there is no GPU, this is several times as fast as WebGL
// that the processor only plays. What stands still is drawn once and kept; vehicles are put onto a copy of that.

/** Vehicles are drawn for so many headings, and so many places within a pixel each way. */
const HEADINGS = 96, PHASES = 4;
/** Each pixel of a vehicle is looked at so many times each way, for smooth edges. */
const LOOKS = 4;
/** Corners of a vehicle that flies to the right, in its size. */
const NOSE = 1, TAIL = -0.75, WING = 0.62;

export class PlainPainter {
  constructor(canvas) {
    this.name = "canvas";
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false, willReadFrequently: true });
    this.shapes = new Map();
    this.stamps = [];
    this.stampsOf = "";    // the size and the width of the picture that they are for
    this.flock = null;
    this.ground = null;    // pixels of what stands still
    this.groundOf = "";    // the view and the layers that they show
  }

  setBackground(css) {
    this.background = css;
    this.ground = null;
  }

  resize(width, height, ratio) {
    this.ratio = ratio;
    this.canvas.width = Math.max(1, Math.round(width * ratio));
    this.canvas.height = Math.max(1, Math.round(height * ratio));
    this.ground = null;
  }

  setFlock(flock) {
    this.flock = flock;
    if (!this.north || this.north.length < flock.n) {
      [this.north, this.east] = [new Float32Array(flock.capacity), new Float32Array(flock.capacity)];
    }
    for (let i = 0; i < flock.n; i++) {
      this.north[i] = Math.cos(flock.course[i]);
      this.east[i] = Math.sin(flock.course[i]);
    }
  }

  /** A layer of lines or triangles: four words a corner, x, y, z and colour. */
  setShapes(layer, kind, words) {
    if (!words.length && !this.shapes.get(layer)?.places.length) return;
    const places = words.slice();
    this.shapes.set(layer, { kind, places, colours: new Uint32Array(places.buffer) });
    this.ground = null;
  }

  draw(camera, layers, size, ahead) {
    const matrix = camera.matrix();
    const of = [...matrix, ...layers].join();
    if (!this.ground || of !== this.groundOf) this.drawGround(camera, layers, of);
    this.pixels.set(this.ground);
    if (this.flock) this.drawFlock(matrix, size * this.ratio, ahead);
    this.context.putImageData(this.image, 0, 0);
  }

  /** Draws what stands still, and keeps its pixels. */
  drawGround(camera, layers, of) {
    const { context, canvas } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = this.background;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.lineWidth = 1;
    for (const layer of layers) {
      const shapes = this.shapes.get(layer);
      if (shapes) this.drawShapes(camera, shapes);
    }
    this.image = context.getImageData(0, 0, canvas.width, canvas.height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.ground = this.pixels.slice();
    this.groundOf = of;
  }

  /** Draws a layer, all of one colour in one go. */
  drawShapes(camera, { kind, places, colours }) {
    const corners = kind === "lines" ? 2 : 3;
    const paths = new Map();
    for (let at = 0; at + 4 * corners <= places.length; at += 4 * corners) {
      const points = [];
      for (let corner = 0; corner < corners; corner++) {
        const from = at + 4 * corner;
        points.push(camera.project(places[from], places[from + 1], places[from + 2]));
      }
      if (points.some((point) => !point)) continue;
      const colour = colours[at + 3];
      if (!paths.has(colour)) paths.set(colour, new Path2D());
      const path = paths.get(colour);
      points.forEach((point, index) => index ? path.lineTo(...point) : path.moveTo(...point));
    }
    for (const [colour, path] of paths) {
      this.context.strokeStyle = this.context.fillStyle = cssColour(colour);
      kind === "lines" ? this.context.stroke(path) : this.context.fill(path);
    }
  }

  /** Puts a stamp for each vehicle; `matrix` is the camera's, column by column. */
  drawFlock(matrix, size, ahead) {
    const { flock, north, east, pixels } = this;
    const { width, height } = this.canvas;
    if (`${size} ${width}` !== this.stampsOf) [this.stamps, this.stampsOf] = [[], `${size} ${width}`];
    const [xx, xy, , xw, yx, yy, , yw, zx, zy, , zw, ox, oy, , ow] = matrix;
    const reach = Math.ceil(1.1 * size) + 1;
    for (let i = 0; i < flock.n; i++) {
      const on = flock.speed[i] * ahead;
      const x = flock.x[i] + north[i] * on, y = flock.y[i] + east[i] * on, z = flock.z[i];
      const w = ow + xw * x + yw * y + zw * z;
      if (!(w > 0.01)) continue; // behind the camera, or nowhere
      const right = (ox + xx * x + yx * y + zx * z) / w, up = (oy + xy * x + yy * y + zy * z) / w;
      const px = (right + 1) / 2 * width, py = (1 - up) / 2 * height;
      if (!(px > -reach && py > -reach && px < width + reach && py < height + reach)) continue;
      const w2 = w + xw * north[i] + yw * east[i];
      const dx = ((right * w + xx * north[i] + yx * east[i]) / w2 - right) * width;
      const dy = ((up * w + xy * north[i] + yy * east[i]) / w2 - up) * height;
      const turn = Math.round(Math.atan2(-dy, dx) / (2 * Math.PI) * HEADINGS + HEADINGS) % HEADINGS;
      const left = Math.floor(px), top = Math.floor(py);
      const phase = Math.floor((px - left) * PHASES) + PHASES * Math.floor((py - top) * PHASES);
      const stamp = this.stamps[turn * PHASES * PHASES + phase] ??= stampOf(size, turn, phase, width);
      if (left >= reach && top >= reach && left < width - reach && top < height - reach) {
        put(pixels, top * width + left, stamp, flock.colour[i]);
      } else {
        const isIn = (at, length) => at >= 0 && at < length;
        const seen = ([right, down]) => isIn(left + right, width) && isIn(top + down, height);
        put(pixels, top * width + left, stampOfPixels(stamp.pixels.filter(seen), width), flock.colour[i]);
      }
    }
  }
}

/** The pixels of a vehicle: steps right and down from its own, and how much of each is covered, 0 to 256. */
function stampOf(size, turn, phase, width) {
  const angle = 2 * Math.PI * turn / HEADINGS;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [x0, y0] = [(phase % PHASES + 0.5) / PHASES, (Math.floor(phase / PHASES) + 0.5) / PHASES];
  const reach = Math.ceil(1.1 * size) + 1;
  const pixels = [];
  for (let down = -reach; down <= reach; down++) {
    for (let right = -reach; right <= reach; right++) {
      let hits = 0;
      for (let look = 0; look < LOOKS * LOOKS; look++) {
        const dx = right + (look % LOOKS + 0.5) / LOOKS - x0, dy = down + (Math.floor(look / LOOKS) + 0.5) / LOOKS - y0;
        const along = (c * dx + s * dy) / size, across = Math.abs(c * dy - s * dx) / size;
        if (along >= TAIL && across <= WING * (NOSE - along) / (NOSE - TAIL)) hits++;
      }
      if (hits) pixels.push([right, down, 256 * hits / (LOOKS * LOOKS)]);
    }
  }
  return stampOfPixels(pixels, width);
}

/** Steps through the buffer of a picture: to pixels that are covered whole, and to those that are in part. */
function stampOfPixels(pixels, width) {
  const step = ([right, down]) => down * width + right;
  const [whole, edge] = [pixels.filter(([, , part]) => part === 256), pixels.filter(([, , part]) => part < 256)];
  const parts = Int32Array.from(edge, ([, , part]) => part);
  return { pixels, whole: Int32Array.from(whole, step), edge: Int32Array.from(edge, step), parts };
}

/** Puts a stamp into pixels. */
function put(pixels, at, { whole, edge, parts }, colour) {
  const opacity = (colour >>> 24) + 1;
  if (opacity === 256) for (let k = 0; k < whole.length; k++) pixels[at + whole[k]] = colour;
  else for (let k = 0; k < whole.length; k++) blend(pixels, at + whole[k], colour, opacity);
  for (let k = 0; k < edge.length; k++) blend(pixels, at + edge[k], colour, (parts[k] * opacity) >> 8);
}

/** Blends a colour into a pixel, `part` of 256: red with blue, and green, in one multiplication each. */
function blend(pixels, at, colour, part) {
  const under = pixels[at], both = under & 0xff00ff, green = under & 0x00ff00;
  const mixed = (both + (Math.imul((colour & 0xff00ff) - both, part) >>> 8)) & 0xff00ff;
  pixels[at] = 0xff000000 | mixed | ((green + (Math.imul((colour & 0x00ff00) - green, part) >> 8)) & 0x00ff00);
}

function cssColour(word) {
  return `rgb(${word & 255} ${(word >> 8) & 255} ${(word >> 16) & 255} / ${((word >>> 24) / 255).toFixed(3)})`;
}
