// Which painter draws the picture. All have the same face: `name`, `setBackground`, `resize`, `setFlock`, `setShapes`,
// `draw`.

import { GlPainter } from "./gl-painter.js";
import { PlainPainter } from "./plain-painter.js";

/**
 * The best painter for a canvas: WebGL 2 by a GPU, and else pixels. `wanted`, "webgl" or "canvas", wins where the
 * browser has it.
 */
export function painterFor(canvas, wanted = hasGpu() ? "webgl" : "canvas") {
  const kind = { antialias: hasGpu(), alpha: false, depth: false };
  const gl = wanted === "canvas" ? null : canvas.getContext("webgl2", kind);
  return gl ? new GlPainter(canvas, gl) : new PlainPainter(canvas);
}

let isGpu;
/** Whether WebGL is drawn by a GPU. */
export function hasGpu() {
  isGpu ??= probeGpu();
  return isGpu;
}

function probeGpu() {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe) return false;
  const info = probe.getExtension("WEBGL_debug_renderer_info");
  const name = info ? probe.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|software/i.test(name);
}
