// The picture by WebGL 2. All vehicles are one buffer of three corners each: much faster than instancing.

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

export class GlPainter {
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
    const attributes = [[0, 3, gl.FLOAT, 0], [1, 3, gl.FLOAT, 12], [2, 4, gl.UNSIGNED_BYTE, 24]];
    this.flockArray = this.array(4 * CORNER_WORDS, attributes);
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
        floats[at + 3] = north; floats[at + 4] = east; floats[at + 5] = flock.speed[i];
        colours[at + 6] = flock.colour[i];
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
