// Hands on the picture: mouse and touch move, turn and zoom it, and select vehicles. Keys are in `page.js`.

export class Hands {
  constructor(stage, over) {
    this.box = null;  // what is being drawn to select: two corners, px
    const pointers = new Map();
    let moved = 0, began = null;
    const place = (event) => {
      const box = stage.element.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    over.addEventListener("pointerdown", (event) => {
      over.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, place(event));
      if (pointers.size === 1) {
        moved = 0;
        began = place(event);
        this.box = event.shiftKey ? [...began, ...began] : null;
      } else {
        this.box = null;
        moved = 99;
      }
    });
    over.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const now = place(event);
      const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
      moved += Math.abs(dx) + Math.abs(dy);
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
        const spread = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]);
        const angle = (a) => Math.atan2(a[1] - other[1], a[0] - other[0]);
        stage.camera.zoom(spread(now) / Math.max(1, spread(before)), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
        if (stage.camera.is3d) stage.camera.turn(angle(before) - angle(now), 0);
        stage.camera.pan(dx / 2, dy / 2);
        stage.touched();
      } else if (this.box) {
        [this.box[2], this.box[3]] = now;
        stage.isStale = true;
      } else if (moved > 4) {
        if (stage.camera.is3d && (event.buttons & 2 || event.ctrlKey || event.altKey)) {
          stage.camera.turn(-dx * 0.006, dy * 0.005);
          stage.isTurned = true;
        } else {
          stage.camera.pan(dx, dy);
          stage.follows = false;
          stage.onSelect();
        }
        stage.touched();
      }
      pointers.set(event.pointerId, now);
    });
    const end = (event) => {
      if (!pointers.delete(event.pointerId) || pointers.size) return;
      const now = place(event);
      if (this.box) {
        const inside = stage.inBox(this.box);
        this.box = null;
        stage.select(inside);
      } else if (moved <= 4 && event.type === "pointerup") {
        const nearest = stage.nearest(now);
        const more = event.ctrlKey || event.metaKey;
        stage.select(nearest === null ? [] : more ? [...stage.selected, nearest] : [nearest]);
      }
    };
    over.addEventListener("pointerup", end);
    over.addEventListener("pointercancel", end);
    over.addEventListener("contextmenu", (event) => event.preventDefault());
    over.addEventListener("wheel", (event) => {
      event.preventDefault();
      stage.camera.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...place(event));
      stage.touched();
    }, { passive: false });
  }
}
