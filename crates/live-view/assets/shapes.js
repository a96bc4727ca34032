// Corners and colours, as painters take them.

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
