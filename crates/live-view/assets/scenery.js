// What stands still in the picture: the grid of the ground, circles, fences, missions and other lines.

import { Shapes, wordOfCss } from "./shapes.js";
import { gridStep } from "./overlay.js";

const CIRCLE_CORNERS = 48;
/** Circles are cylinders without an end; so much of them is drawn above the flock, m. */
const CYLINDER_ABOVE_M = 30;

/** Makes the layers of circles, fences, missions and other lines. */
export function makeScenery(painter, palette, { circles, outlines, altitude_m: altitude }) {
  const floor = 0, top = (altitude ?? 50) + CYLINDER_ABOVE_M;
  const discs = new Shapes(1024), edges = new Shapes(1024), walls = new Shapes(1024);
  const [fill, edge, wall] = [0.25, 0.9, 0.12].map((opacity) => wordOfCss(palette.circle, opacity));
  for (const { x_m, y_m, radius_m } of circles) {
    const rim = (k) => {
      const angle = 2 * Math.PI * k / CIRCLE_CORNERS;
      return [x_m + radius_m * Math.cos(angle), y_m + radius_m * Math.sin(angle)];
    };
    for (let k = 0; k < CIRCLE_CORNERS; k++) {
      const [a, b] = [rim(k), rim(k + 1)];
      discs.corner(x_m, y_m, floor, fill); discs.corner(...a, floor, fill); discs.corner(...b, floor, fill);
      edges.corner(...a, floor, edge); edges.corner(...b, floor, edge);
      edges.corner(...a, top, edge); edges.corner(...b, top, edge);
      walls.corner(...a, floor, wall); walls.corner(...b, floor, wall); walls.corner(...b, top, wall);
      walls.corner(...a, floor, wall); walls.corner(...b, top, wall); walls.corner(...a, top, wall);
    }
  }
  const lines = new Shapes(256), posts = new Shapes(256);
  const line = (shapes, a, b, colour) => { shapes.corner(...a, colour); shapes.corner(...b, colour); };
  for (const { kind, points_m: points, is_closed: closed } of outlines) {
    const name = { fence: "fence", "keep-out": "fault" }[kind] ?? "accent";
    const [colour, faint] = [0.9, 0.35].map((opacity) => wordOfCss(palette[name], opacity));
    const isArea = name !== "accent";
    const raised = ([x, y, z]) => [x, y, isArea ? top : z];
    for (let k = 0; k + 1 < points.length + (closed ? 1 : 0); k++) {
      const [a, b] = [points[k], points[(k + 1) % points.length]];
      line(lines, a, b, colour);
      if (isArea) line(posts, raised(a), raised(b), faint);
    }
    // From the side a fence is as high as circles are, and a way stands above the ground.
    for (const [x, y, z] of points) line(posts, [x, y, 0], raised([x, y, z]), faint);
  }
  painter.setShapes("posts", "lines", posts.used);
  painter.setShapes("discs", "triangles", discs.used);
  painter.setShapes("edges", "lines", edges.used);
  painter.setShapes("walls", "triangles", walls.used);
  painter.setShapes("outlines", "lines", lines.used);
}

/** The lines of the grid, made anew when the camera has moved by a line. */
export class Grid {
  make(painter, palette, camera) {
    const step = gridStep(camera.scale) * (camera.is3d ? 2 : 1);
    const centre = [0, 1].map((k) => Math.round(camera.centre[k] / step));
    const key = [step, camera.is3d, ...centre, camera.width, camera.height, palette.line].join();
    if (key === this.key) return;
    this.key = key;
    const lines = (camera.is3d ? 2.2 : 0.75) * Math.hypot(camera.width, camera.height) / camera.scale / step;
    const reach = step * Math.ceil(lines);
    const [north, east] = centre.map((line) => line * step);
    const colour = wordOfCss(palette.line, 1);
    const grid = new Shapes(400);
    // In 3-D a line in pieces: a piece that ends behind the camera is not drawn, but the rest of the line is.
    const piece = camera.is3d ? step : 2 * reach;
    for (let offset = -reach; offset <= reach; offset += step) {
      for (let from = -reach; from < reach; from += piece) {
        for (const along of [from, from + piece]) grid.corner(north + along, east + offset, 0, colour);
        for (const along of [from, from + piece]) grid.corner(north + offset, east + along, 0, colour);
      }
    }
    painter.setShapes("grid", "lines", grid.used);
  }
}
