// Draws triangles and lines by a camera: with WebGL 2, or on a plain canvas where that is missing. Both have the same
// face: `resize`, `setFlock`, `setShapes`, `draw`.
//
// All vehicles are one buffer of three corners each: without a GPU that is ten times as fast as instancing.

const CORNER_WORDS = 7; // x, y, z, north and east of the course, speed, colour: four bytes each

const FLOCK_VERTEX = `#version 300 es
uniform mat4 camera; uniform vec2 pixel; uniform float ahead; uniform float size;
layout(location = 0) in vec3 place; layout(location = 1) in vec3 motion; layout(location = 2) in vec4 colour;
out vec4 shade;
void main() {
  vec4 here = camera * vec4(place + vec3(motion.xy * motion.z * ahead, 0.0), 1.0);
  vec4 there = here + motion.x * camera[0] + motion.y * camera[1];
  vec2 way = (there.xy / there.w - here.xy / here.w) / pixel;
  way = length(way) > 1e-6 ? normalize(way) : vec2(0.0, 1.0);
  int corner = gl_VertexID % 3;
  vec2 at = corner == 0 ? vec2(1.0, 0.0) : corner == 1 ? vec2(-0.75, 0.62) : vec2(-0.75, -0.62);
  at = size * (at.x * way + at.y * vec2(-way.y, way.x));
  // What is behind the camera is cut off by its depth alone: nothing hides anything else.
  gl_Position = vec4(here.xy + at * pixel * here.w, here.w - 0.1, here.w);
  shade = colour;
}`;
const SHAPE_VERTEX = `#version 300 es
uniform mat4 camera;
layout(location = 0) in vec3 place; layout(location = 2) in vec4 colour;
out vec4 shade;
void main() { gl_Position = camera * vec4(place, 1.0); gl_Position.z = gl_Position.w - 0.1; shade = colour; }`;
const FRAGMENT = `#version 300 es
precision mediump float; in vec4 shade; out vec4 painted;
void main() { painted = vec4(shade.rgb * shade.a, shade.a); }`;

/** The best painter that the browser has for a canvas. */
export function painterFor(canvas, plain = false) {
  const gl = plain ? null : canvas.getContext("webgl2", { antialias: hasGpu(), alpha: false });
  return gl ? new GlPainter(canvas, gl) : new PlainPainter(canvas);
}

let isGpu;
/** Whether WebGL is drawn by a GPU: without one, smooth edges cost a third of the frames. */
export function hasGpu() {
  isGpu ??= probeGpu();
  return isGpu;
}

function probeGpu() {
  const probe = document.createElement("canvas").getContext("webgl2");
  const info = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? probe.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|software/i.test(name);
}

class GlPainter {
  constructor(canvas, gl) {
    this.name = "WebGL 2";
    this.canvas = canvas;
    this.gl = gl;
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.begin());
    this.begin();
  }

  begin() {
    const gl = this.gl;
    this.flock = this.program(FLOCK_VERTEX, ["camera", "pixel", "ahead", "size"]);
    this.shape = this.program(SHAPE_VERTEX, ["camera"]);
    this.flockArray = this.array(4 * CORNER_WORDS, [[0, 3, gl.FLOAT, 0], [1, 3, gl.FLOAT, 12], [2, 4, gl.UNSIGNED_BYTE, 24]]);
    this.shapes = new Map();
    this.corners = 0;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** The colour behind everything, "#rrggbb": a picture that hides what is behind it is put on the page faster. */
  setBackground(css) {
    const hex = parseInt(css.slice(1), 16) || 0;
    this.gl.clearColor(...[16, 8, 0].map((shift) => ((hex >> shift) & 255) / 255), 1);
  }

  program(vertex, uniforms) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return { program, ...Object.fromEntries(uniforms.map((name) => [name, gl.getUniformLocation(program, name)])) };
  }

  array(stride, attributes) {
    const gl = this.gl;
    const [array, buffer] = [gl.createVertexArray(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    for (const [at, count, kind, offset] of attributes) {
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, count, kind, kind === gl.UNSIGNED_BYTE, stride, offset);
    }
    return { array, buffer };
  }

  resize(width, height, ratio) {
    this.ratio = ratio;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }

  setFlock(flock) {
    const words = flock.n * 3 * CORNER_WORDS;
    if (!this.floats || this.floats.length < words) {
      this.floats = new Float32Array(2 * words);
      this.colours = new Uint32Array(this.floats.buffer);
    }
    const { floats, colours } = this;
    let at = 0;
    for (let i = 0; i < flock.n; i++) {
      if (flock.x[i] !== flock.x[i]) continue; // nowhere
      const [north, east] = [Math.cos(flock.course[i]), Math.sin(flock.course[i])];
      for (let corner = 0; corner < 3; corner++) {
        floats[at] = flock.x[i]; floats[at + 1] = flock.y[i]; floats[at + 2] = flock.z[i];
        floats[at + 3] = north; floats[at + 4] = east; floats[at + 5] = flock.speed[i]; colours[at + 6] = flock.colour[i];
        at += CORNER_WORDS;
      }
    }
    this.corners = at / CORNER_WORDS;
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.flockArray.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, floats.subarray(0, at), gl.DYNAMIC_DRAW);
  }

  /** A layer of lines or triangles: four words a corner, x, y, z and colour. */
  setShapes(layer, kind, words) {
    const gl = this.gl;
    let known = this.shapes.get(layer);
    if (!known) {
      known = this.array(16, [[0, 3, gl.FLOAT, 0], [2, 4, gl.UNSIGNED_BYTE, 12]]);
      this.shapes.set(layer, known);
    }
    known.kind = kind === "lines" ? gl.LINES : gl.TRIANGLES;
    known.corners = words.length / 4;
    gl.bindBuffer(gl.ARRAY_BUFFER, known.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, words, gl.DYNAMIC_DRAW);
  }

  draw(camera, layers, size, ahead) {
    const gl = this.gl;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const matrix = camera.matrix();
    gl.useProgram(this.shape.program);
    gl.uniformMatrix4fv(this.shape.camera, false, matrix);
    for (const layer of layers) {
      const shapes = this.shapes.get(layer);
      if (!shapes || !shapes.corners) continue;
      gl.bindVertexArray(shapes.array);
      gl.drawArrays(shapes.kind, 0, shapes.corners);
    }
    if (!this.corners) return;
    gl.useProgram(this.flock.program);
    gl.uniformMatrix4fv(this.flock.camera, false, matrix);
    gl.uniform2f(this.flock.pixel, 2 / camera.width, 2 / camera.height);
    gl.uniform1f(this.flock.ahead, ahead);
    gl.uniform1f(this.flock.size, size);
    gl.bindVertexArray(this.flockArray.array);
    gl.drawArrays(gl.TRIANGLES, 0, this.corners);
  }
}

/** The same on a canvas without WebGL: slower, and all there. */
class PlainPainter {
  constructor(canvas) {
    this.name = "canvas";
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.shapes = new Map();
  }

  resize(width, height, ratio) {
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.ratio = ratio;
  }

  setBackground() {}
  setFlock(flock) { this.flock = flock; }
  setShapes(layer, kind, words) {
    this.shapes.set(layer, { kind, places: new Float32Array(words.buffer, words.byteOffset, words.length), colours: new Uint32Array(words.buffer, words.byteOffset, words.length) });
  }

  draw(camera, layers, size, ahead) {
    const context = this.context;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    context.lineWidth = 1;
    for (const layer of layers) {
      const shapes = this.shapes.get(layer);
      if (shapes) this.drawShapes(camera, shapes);
    }
    const flock = this.flock;
    for (let i = 0; flock && i < flock.n; i++) {
      if (flock.x[i] !== flock.x[i]) continue;
      const [c, s] = [Math.cos(flock.course[i]), Math.sin(flock.course[i])];
      const [x, y] = [flock.x[i] + c * flock.speed[i] * ahead, flock.y[i] + s * flock.speed[i] * ahead];
      const here = camera.project(x, y, flock.z[i]), there = camera.project(x + c, y + s, flock.z[i]);
      if (!here || !there) continue;
      const [dx, dy] = [there[0] - here[0], there[1] - here[1]];
      const length = Math.hypot(dx, dy) || 1;
      const [ux, uy] = [size * dx / length, size * dy / length];
      context.fillStyle = cssColour(flock.colour[i]);
      context.beginPath();
      context.moveTo(here[0] + ux, here[1] + uy);
      context.lineTo(here[0] - 0.75 * ux - 0.62 * uy, here[1] - 0.75 * uy + 0.62 * ux);
      context.lineTo(here[0] - 0.75 * ux + 0.62 * uy, here[1] - 0.75 * uy - 0.62 * ux);
      context.fill();
    }
  }

  drawShapes(camera, { kind, places, colours }) {
    const context = this.context;
    const corners = kind === "lines" ? 2 : 3;
    let colour = -1;
    const end = () => { if (colour !== -1) kind === "lines" ? context.stroke() : context.fill(); };
    for (let at = 0; at + 4 * corners <= places.length; at += 4 * corners) {
      if (colours[at + 3] !== colour) {
        end();
        colour = colours[at + 3];
        context.strokeStyle = context.fillStyle = cssColour(colour);
        context.beginPath();
      }
      const points = [];
      for (let corner = 0; corner < corners; corner++) {
        const from = at + 4 * corner;
        points.push(camera.project(places[from], places[from + 1], places[from + 2]));
      }
      if (points.some((point) => !point)) continue;
      points.forEach((point, index) => index ? context.lineTo(...point) : context.moveTo(...point));
    }
    end();
  }
}

function cssColour(word) {
  return `rgb(${word & 255} ${(word >> 8) & 255} ${(word >> 16) & 255} / ${((word >>> 24) / 255).toFixed(3)})`;
}

/** Red, green, blue and opacity as one word, as the buffers have it. */
export function colourWord(red, green, blue, opacity = 1) {
  return (red | (green << 8) | (blue << 16) | (Math.round(255 * opacity) << 24)) >>> 0;
}

/** A colour of the style sheet, "#rrggbb", as a word. */
export function wordOfCss(text, opacity = 1) {
  const hex = parseInt(text.trim().slice(1), 16) || 0;
  return colourWord(hex >> 16, (hex >> 8) & 255, hex & 255, opacity);
}

/** Gathers corners of lines or triangles. */
export class Shapes {
  constructor(corners) {
    this.words = new Float32Array(4 * corners);
    this.colours = new Uint32Array(this.words.buffer);
    this.at = 0;
  }
  corner(x, y, z, colour) {
    if (this.at + 4 > this.words.length) {
      const more = new Float32Array(2 * this.words.length + 64);
      more.set(this.words);
      this.words = more;
      this.colours = new Uint32Array(more.buffer);
    }
    this.words[this.at] = x; this.words[this.at + 1] = y; this.words[this.at + 2] = z;
    this.colours[this.at + 3] = colour;
    this.at += 4;
  }
  get used() { return this.words.subarray(0, this.at); }
}
