"use strict";
// The replay. Lengths arrive in mm, angles in 0.1 mrad, times in ms, weights in thousandths: `x[tick * vehicles + vehicle]`.
(() => {
  const element = (id) => document.getElementById(id);
  const [stage, side] = [element("stage"), element("side")];
  if (!stage) return;
  const flight = JSON.parse(element("flight").textContent);
  const { vehicles, t, x, y, altitude, speed, course, weights, separation, clearance, obstacles, safe } = flight;
  const [play, scrub, clock, rate, follow, northUp, colour, tip, readout] =
    ["play", "scrub", "clock", "rate", "follow", "north-up", "colour", "tip", "readout"].map(element);
  const [map, strip] = [stage.getContext("2d"), side.getContext("2d")];
  const start = t[0], end = t[t.length - 1];
  const TRAIL_MS = 10000;      // how far back the bright part of a path goes
  const PAIRS_UP_TO = 300;     // vehicles: beyond that, testing all pairs in every frame is too slow
  const COLOURS_UP_TO = 16;    // vehicles: beyond that, a colour for each tells nobody anything
  const SIDE_PX = 96;          // height of the strip of altitudes
  const ZOOM_MAX = 200;
  const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]]; // viridis

  let now = start;             // ms
  let playing = false;
  let pointer = null;          // px in the map
  let picked = null;           // a vehicle that was clicked
  let zoom = 1;                // 1: what the camera shows by itself
  let shift = { h: 0, v: 0 };  // m, from the camera's own centre
  let drag = null;
  let frameRequested = false;
  let lastFrame = null;

  // ---- The flight at any time ----

  /** The last tick that is not after `ms`. */
  function tickAt(ms) {
    let low = 0, high = t.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (t[middle] <= ms) low = middle; else high = middle - 1;
    }
    return low;
  }

  /** Every vehicle at `now`, between two ticks on the straight line from one to the other. Weights are those of the tick. */
  function flockAt(ms) {
    const tick = tickAt(ms), next = Math.min(tick + 1, t.length - 1);
    const part = next > tick ? (ms - t[tick]) / (t[next] - t[tick]) : 0;
    const flock = [];
    for (let vehicle = 0; vehicle < vehicles; vehicle++) {
      const a = tick * vehicles + vehicle, b = next * vehicles + vehicle;
      const mix = (values) => values[a] + part * (values[b] - values[a]);
      const turn = ((course[b] - course[a] + 94248) % 62832 + 62832) % 62832 - 31416;
      flock.push({ x: mix(x) / 1e3, y: mix(y) / 1e3, altitude: mix(altitude) / 1e3, speed: mix(speed) / 1e3,
        course: (course[a] + part * turn) / 1e4, weights: weights.map((term) => term[a] / 1e3) });
    }
    return { tick, next: part > 0 ? next : tick, flock };
  }

  /** Least and greatest of some values, at least `span` apart. */
  function range(values, unit, span) {
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) { low = Math.min(low, value / unit); high = Math.max(high, value / unit); }
    if (!(low <= high)) [low, high] = [0, 0];
    const missing = Math.max(0, span - (high - low));
    return { low: low - missing / 2, high: high + missing / 2 };
  }
  const ranges = {
    altitude: range([...altitude, flight.expected_altitude], 1e3, 10),
    speed: range(speed, 1e3, 1),
    weight: { low: 0, high: Math.max(...weights.map((term) => range(term, 1e3, 0).high), 1) },
  };

  // ---- From metres to px ----
  // `h` is the direction to the right, `v` the one upwards. A map, never its mirror image: north to the right and east
  // downwards, or north upwards and east to the right.

  const h = (one) => northUp.checked ? one.y : one.x;
  const v = (one) => northUp.checked ? one.x : -one.y;

  function bounds() {
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    const add = (one, radius) => {
      left = Math.min(left, h(one) - radius); right = Math.max(right, h(one) + radius);
      low = Math.min(low, v(one) - radius); high = Math.max(high, v(one) + radius);
    };
    for (const [ox, oy, radius] of obstacles) add({ x: ox / 1e3, y: oy / 1e3 }, radius / 1e3);
    for (let index = 0; index < x.length; index++) add({ x: x[index] / 1e3, y: y[index] / 1e3 }, 0);
    if (!(left <= right)) [left, right, low, high] = [-10, 10, -10, 10];
    const margin = 0.04 * Math.max(right - left, high - low) + 2;
    return { left: left - margin, right: right + margin, low: low - margin, high: high + margin };
  }
  let field = bounds();

  /** The camera: the whole field, or the flock and what is around it; then zoomed and moved by hand. */
  function camera(flock, width, height) {
    let { left, right, low, high } = field;
    if (follow.checked && flock.length) {
      const hs = flock.map(h), vs = flock.map(v);
      const around = Math.max(25, 0.35 * (Math.max(...hs) - Math.min(...hs)));
      [left, right] = [Math.min(...hs) - around, Math.max(...hs) + around];
      [low, high] = [Math.min(...vs) - around, Math.max(...vs) + around];
    }
    const scale = zoom * Math.min(width / (right - left), height / (high - low));
    const [middleH, middleV] = [(left + right) / 2 + shift.h, (low + high) / 2 + shift.v];
    return {
      scale, middleH, middleV,
      px: (one) => width / 2 + (h(one) - middleH) * scale,
      py: (one) => height / 2 - (v(one) - middleV) * scale,
    };
  }

  /** Zooms about a point in px of the map, which stays where it is. */
  function zoomBy(factor, at) {
    const [width, height] = [stage.clientWidth, stage.clientHeight];
    const before = camera(flockAt(now).flock, width, height);
    const to = Math.min(ZOOM_MAX, Math.max(1, zoom * factor));
    const [offsetH, offsetV] = at ? [at.x - width / 2, height / 2 - at.y] : [0, 0];
    const gain = (1 - zoom / to) / before.scale;
    shift = { h: shift.h + offsetH * gain, v: shift.v + offsetV * gain };
    zoom = to;
    if (zoom === 1) shift = { h: 0, v: 0 };
    stage.style.touchAction = zoom > 1 ? "none" : "";
    request();
  }

  // ---- Colours ----

  let palette = {};
  function readPalette() {
    const style = getComputedStyle(document.documentElement);
    const named = (name) => style.getPropertyValue(`--${name}`).trim();
    palette = { series: [] };
    for (const name of ["page", "ink", "soft", "faint", "disc", "disc-edge", "alarm"]) palette[name] = named(name);
    for (let index = 1; index <= 8; index++) palette.series.push(named(`s${index}`));
  }
  const ownColour = (vehicle) => palette.series[vehicle % palette.series.length];

  /** What the colours show: the values' range and unit, or none where they tell UAVs apart. */
  function shown() {
    if (colour.value === "uav") return null;
    if (colour.value === "altitude") return { ...ranges.altitude, unit: " m", of: (one) => one.altitude };
    if (colour.value === "speed") return { ...ranges.speed, unit: " m/s", of: (one) => one.speed };
    return { ...ranges.weight, unit: "", of: (one) => one.weights[Number(colour.value)] };
  }

  function ramp(share) {
    const place = Math.min(1, Math.max(0, share)) * (RAMP.length - 1);
    const index = Math.min(RAMP.length - 2, Math.floor(place));
    const mixed = RAMP[index].map((from, part) => Math.round(from + (place - index) * (RAMP[index + 1][part] - from)));
    return `rgb(${mixed.join(" ")})`;
  }

  function colourOf(one, vehicle, scale) {
    return scale ? ramp((scale.of(one) - scale.low) / (scale.high - scale.low)) : ownColour(vehicle);
  }

  function showScale() {
    const scale = shown();
    element("scale").hidden = !scale;
    if (!scale) return;
    element("scale-low").textContent = `${fixed(scale.low, 1)}${scale.unit}`;
    element("scale-high").textContent = `${fixed(scale.high, 1)}${scale.unit}`;
  }

  // ---- Drawing ----

  /** The canvases in device pixels; the map as high as the field asks for within what a screen can show. */
  function fit() {
    const width = stage.parentElement.clientWidth;
    const asked = width * (field.high - field.low) / (field.right - field.left);
    const height = Math.round(Math.max(Math.min(asked, 0.7 * innerHeight), 220));
    const ratio = devicePixelRatio || 1;
    for (const [canvas, context, px] of [[stage, map, height], [side, strip, SIDE_PX]]) {
      canvas.style.height = `${px}px`;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(px * ratio);
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    request();
  }

  function strokePath(vehicle, from, to, head, view) {
    map.beginPath();
    for (let tick = from; tick <= to; tick++) {
      const index = tick * vehicles + vehicle;
      const one = { x: x[index] / 1e3, y: y[index] / 1e3 };
      map.lineTo(view.px(one), view.py(one));
    }
    if (head) map.lineTo(view.px(head), view.py(head));
    map.stroke();
  }

  const minus = (value) => String(value).replace("-", "\u2212");
  const round = (step, value) => Number((Math.round(value / step) * step).toFixed(6));

  /** The lines of the grid, or, above everything else, their labels. */
  function drawGrid(width, height, view, labels) {
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000].find((metres) => metres * view.scale >= 60) || 100000;
    map.lineWidth = labels ? 3 : 1;
    map.strokeStyle = labels ? palette.page : palette.faint;
    map.fillStyle = palette.soft;
    map.font = "12px system-ui, sans-serif";
    const line = (...points) => { map.beginPath(); for (const point of points) map.lineTo(...point); map.stroke(); };
    const write = (text, px, py) => { map.strokeText(text, px, py); map.fillText(text, px, py); };
    const [left, top] = [view.middleH - width / 2 / view.scale, view.middleV + height / 2 / view.scale];
    for (let metres = Math.ceil(left / step) * step; (metres - left) * view.scale <= width; metres += step) {
      const at = (metres - left) * view.scale;
      if (!labels) { line([at, 0], [at, height]); continue; }
      const label = minus(round(step, metres));
      if (at + 4 + map.measureText(label).width < width - 90) write(label, at + 4, height - 6);
    }
    for (let metres = Math.floor(top / step) * step; (top - metres) * view.scale <= height; metres -= step) {
      const at = (top - metres) * view.scale;
      if (!labels) { line([0, at], [width, at]); continue; }
      const value = round(step, northUp.checked ? metres : -metres);
      if (at < height - 24 && at > 30) write(minus(value), 4, at - 4);
    }
    if (!labels) return;
    const [across, along] = northUp.checked ? ["east (m)", "north (m)"] : ["north (m)", "east (m)"];
    write(across, width - 4 - map.measureText(across).width, height - 6);
    write(along, 4, 13);
  }

  /** An arrow to the north. */
  function drawCompass(width) {
    map.save();
    map.translate(width - 22, 24);
    map.fillStyle = map.strokeStyle = palette.ink;
    map.font = "600 12px system-ui, sans-serif";
    map.textAlign = "center";
    map.textBaseline = "middle";
    const [ahead, aside] = northUp.checked ? [[0, -1], [1, 0]] : [[1, 0], [0, 1]];
    const to = (along, across) => [along * ahead[0] + across * aside[0], along * ahead[1] + across * aside[1]];
    map.beginPath(); map.moveTo(...to(-10, 0)); map.lineTo(...to(4, 0)); map.lineWidth = 1.6; map.stroke();
    map.beginPath(); map.moveTo(...to(12, 0)); map.lineTo(...to(3, 4.5)); map.lineTo(...to(3, -4.5)); map.closePath(); map.fill();
    map.fillText("N", ...(northUp.checked ? [-11, 0] : [-18, 0]));
    map.restore();
  }

  function drawUav(one, fill, view, marked) {
    const size = (vehicles > 60 ? 6 : 9) * (marked ? 1.35 : 1);
    const [north, east] = [Math.cos(one.course), Math.sin(one.course)];
    map.save();
    map.translate(view.px(one), view.py(one));
    map.rotate(northUp.checked ? Math.atan2(-north, east) : Math.atan2(east, north));
    map.beginPath();
    map.moveTo(size, 0); map.lineTo(-0.7 * size, 0.62 * size); map.lineTo(-0.7 * size, -0.62 * size);
    map.closePath();
    map.fillStyle = fill;
    map.fill();
    map.lineWidth = marked ? 2 : 1;
    map.strokeStyle = marked ? palette.ink : palette.page;
    map.stroke();
    map.restore();
  }

  function drawLostSeparations(flock, view) {
    if (vehicles > PAIRS_UP_TO) return;
    map.strokeStyle = palette.alarm;
    map.lineWidth = 2;
    for (let one = 0; one < flock.length; one++) {
      for (let other = one + 1; other < flock.length; other++) {
        const [a, b] = [flock[one], flock[other]];
        if (Math.hypot(a.x - b.x, a.y - b.y) >= safe / 1e3) continue;
        map.beginPath(); map.moveTo(view.px(a), view.py(a)); map.lineTo(view.px(b), view.py(b)); map.stroke();
      }
    }
  }

  function circles(view, paint) {
    for (const [ox, oy, radius] of obstacles) {
      const centre = { x: ox / 1e3, y: oy / 1e3 };
      map.beginPath();
      map.arc(view.px(centre), view.py(centre), radius / 1e3 * view.scale, 0, 2 * Math.PI);
      paint();
    }
  }

  /** The flock from the side: altitude over what is to the right in the map. */
  function drawSide(flock, width, view, scale, marked) {
    const { low, high } = ranges.altitude;
    const py = (metres) => 14 + (SIDE_PX - 28) * (high - metres) / (high - low);
    strip.clearRect(0, 0, width, SIDE_PX);
    strip.font = "12px system-ui, sans-serif";
    const levels = [low, (low + high) / 2, high];
    for (const level of levels) {
      strip.strokeStyle = palette.faint;
      strip.lineWidth = 1;
      strip.beginPath(); strip.moveTo(0, py(level)); strip.lineTo(width, py(level)); strip.stroke();
      strip.fillStyle = palette.soft;
      const label = `${fixed(level, 1)} m up`;
      strip.fillText(label, width - 4 - strip.measureText(label).width, py(level) - 3);
    }
    const marker = (one, vehicle, radius) => {
      strip.beginPath();
      strip.arc(view.px(one), py(one.altitude), radius, 0, 2 * Math.PI);
      strip.fillStyle = colourOf(one, vehicle, scale);
      strip.fill();
      strip.lineWidth = vehicle === marked ? 2 : 0.8;
      strip.strokeStyle = vehicle === marked ? palette.ink : palette.page;
      strip.stroke();
    };
    flock.forEach((one, vehicle) => { if (vehicle !== marked) marker(one, vehicle, vehicles > 60 ? 3 : 4.5); });
    if (marked !== null) marker(flock[marked], marked, 6);
  }

  function draw() {
    const width = stage.clientWidth, height = stage.clientHeight;
    const { tick, next, flock } = flockAt(now);
    const view = camera(flock, width, height);
    const scale = shown();
    map.clearRect(0, 0, width, height);
    drawGrid(width, height, view, false);
    map.fillStyle = palette.disc;
    circles(view, () => map.fill());
    const marked = nearest(flock, view) ?? picked;
    const recent = tickAt(Math.max(start, now - TRAIL_MS));
    for (let vehicle = 0; vehicle < vehicles; vehicle++) {
      map.strokeStyle = scale && vehicle !== marked ? palette.soft : ownColour(vehicle);
      map.lineWidth = 1;
      map.globalAlpha = vehicles > COLOURS_UP_TO ? 0.12 : 0.3;
      strokePath(vehicle, 0, t.length - 1, null, view);
      map.lineWidth = vehicle === marked ? 2.6 : vehicles > COLOURS_UP_TO ? 1.2 : 2.2;
      map.globalAlpha = scale && vehicle !== marked ? 0.45 : 1;
      strokePath(vehicle, recent, tick, flock[vehicle], view);
    }
    map.globalAlpha = 1;
    drawLostSeparations(flock, view);
    flock.forEach((one, vehicle) => { if (vehicle !== marked) drawUav(one, colourOf(one, vehicle, scale), view, false); });
    // Above the UAVs, so that none of them hides where a circle ends.
    map.strokeStyle = palette["disc-edge"];
    map.lineWidth = 1.2;
    circles(view, () => map.stroke());
    if (marked !== null) drawUav(flock[marked], colourOf(flock[marked], marked, scale), view, true);
    drawGrid(width, height, view, true);
    drawCompass(width);
    drawSide(flock, width, view, scale, marked);
    describe(flock, marked, view, width);
    report(next, flock);
  }

  /** The vehicle under the pointer, or near it. */
  function nearest(flock, view) {
    if (!pointer || drag?.moved) return null;
    let [best, least] = [null, 28];
    flock.forEach((one, vehicle) => {
      const distance = Math.hypot(view.px(one) - pointer.x, view.py(one) - pointer.y);
      if (distance < least) [best, least] = [vehicle, distance];
    });
    return best;
  }

  // ---- Words ----

  const fixed = (value, digits) => value.toFixed(digits).replace(/^-(?=0\.?0*$)/, "").replace("-", "\u2212");

  function describe(flock, marked, view, width) {
    tip.hidden = marked === null;
    if (marked === null) return;
    const one = flock[marked];
    const degrees = (one.course * 180 / Math.PI % 360 + 360) % 360;
    const [formation, obstacle, velocity] = one.weights.map((weight) => fixed(weight, 2));
    tip.textContent = `UAV ${marked + 1}\n${fixed(one.speed, 2)} m/s, course ${fixed(degrees, 0)}\u00b0\n${fixed(one.altitude, 1)} m up\n`
      + `weights: formation ${formation}\n  obstacle ${obstacle}, velocity ${velocity}`;
    const [px, py] = [view.px(one), view.py(one)];
    tip.style.left = `${Math.max(0, px + 14 + tip.offsetWidth > width ? px - 14 - tip.offsetWidth : px + 14)}px`;
    tip.style.top = `${Math.max(0, py - tip.offsetHeight - 8)}px`;
  }

  function median(values) {
    const sorted = [...values].sort((a, b) => a - b), middle = sorted.length >> 1;
    return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
  }

  function report(tick, flock) {
    clock.textContent = `${fixed(now / 1e3, 1)} s`;
    scrub.value = String(Math.round(now));
    scrub.setAttribute("aria-valuetext", clock.textContent);
    const words = [];
    if (separation[tick] !== null) words.push(`smallest separation ${fixed(separation[tick] / 1e3, 1)} m`);
    if (clearance[tick] !== null) words.push(`smallest clearance ${fixed(clearance[tick] / 1e3, 1)} m`);
    if (flock.length) {
      const [formation, obstacle, velocity] = [0, 1, 2].map((term) => fixed(median(flock.map((one) => one.weights[term])), 2));
      words.push(`median weights: formation ${formation}, obstacle ${obstacle}, neighbour velocity ${velocity}`);
    }
    const text = words.join(", ");
    readout.textContent = text.charAt(0).toUpperCase() + text.slice(1);
    readout.className = separation[tick] !== null && separation[tick] < safe || clearance[tick] !== null && clearance[tick] < 0
      ? "readout bad" : "readout";
  }

  // ---- Time ----

  function request() {
    if (frameRequested) return;
    frameRequested = true;
    requestAnimationFrame((timestamp) => {
      frameRequested = false;
      if (playing) {
        if (lastFrame !== null) now = Math.min(end, now + (timestamp - lastFrame) * Number(rate.value));
        lastFrame = timestamp;
        if (now >= end) setPlaying(false);
      }
      draw();
      if (playing) request();
    });
  }

  function setPlaying(on) {
    if (on && now >= end) now = start;
    playing = on;
    lastFrame = null;
    play.textContent = on ? "Pause" : "Play";
    play.setAttribute("aria-pressed", String(on));
    request();
  }

  function seek(ms) {
    now = Math.min(end, Math.max(start, ms));
    request();
  }

  function stepTicks(count) {
    setPlaying(false);
    const tick = tickAt(now);
    // Between two ticks, a step back goes to the one just passed.
    const target = count < 0 && t[tick] < now ? tick + count + 1 : tick + count;
    seek(t[Math.min(t.length - 1, Math.max(0, target))]);
  }

  function inView() {
    const { top, bottom } = stage.getBoundingClientRect();
    return bottom > 0 && top < innerHeight;
  }

  // ---- Controls ----

  play.addEventListener("click", () => setPlaying(!playing));
  scrub.addEventListener("input", () => seek(Number(scrub.value)));
  follow.addEventListener("change", () => zoomBy(0));
  northUp.addEventListener("change", () => { field = bounds(); zoomBy(0); fit(); });
  colour.addEventListener("change", () => { showScale(); request(); });
  element("zoom-in").addEventListener("click", () => zoomBy(1.5));
  element("zoom-out").addEventListener("click", () => zoomBy(1 / 1.5));
  element("fit").addEventListener("click", () => { follow.checked = false; zoomBy(0); });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !inView()) return;
    // A button, a box or a list does with its keys what it always does.
    const busy = event.target.closest("button, select, a, input:not([type=range])");
    const ticks = event.shiftKey ? 10 : 1;
    const actions = {
      " ": () => setPlaying(!playing),
      ArrowLeft: () => stepTicks(-ticks),
      ArrowRight: () => stepTicks(ticks),
      Home: () => seek(start),
      End: () => seek(end),
      "+": () => zoomBy(1.5),
      "-": () => zoomBy(1 / 1.5),
      "0": () => zoomBy(0),
    };
    // Home and End move the page unless the replay has the focus.
    const focused = event.target === stage || event.target === scrub;
    if (busy || !(event.key in actions) || (event.key.length > 1 && !event.key.startsWith("Arrow") && !focused)) return;
    event.preventDefault();
    actions[event.key]();
  });

  const place = (event) => {
    const box = stage.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  stage.addEventListener("wheel", (event) => {
    // Without Ctrl the wheel moves the page. Pinching a touchpad arrives as Ctrl and the wheel.
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoomBy(Math.exp(-event.deltaY / 200), place(event));
  }, { passive: false });
  stage.addEventListener("pointerdown", (event) => {
    pointer = place(event);
    // A finger moves the page while the whole field is shown.
    if (event.button === 0 && (event.pointerType === "mouse" || zoom > 1)) {
      drag = { from: pointer, shift: { ...shift }, moved: false };
      stage.setPointerCapture(event.pointerId);
    }
    request();
  });
  stage.addEventListener("pointermove", (event) => {
    pointer = place(event);
    if (drag) {
      const [right, down] = [pointer.x - drag.from.x, pointer.y - drag.from.y];
      drag.moved ||= Math.hypot(right, down) > 4;
      if (drag.moved) {
        const { scale } = camera(flockAt(now).flock, stage.clientWidth, stage.clientHeight);
        shift = { h: drag.shift.h - right / scale, v: drag.shift.v + down / scale };
      }
    }
    request();
  });
  stage.addEventListener("pointerup", (event) => {
    if (!drag?.moved) {
      pointer = place(event);
      const { flock } = flockAt(now);
      picked = nearest(flock, camera(flock, stage.clientWidth, stage.clientHeight));
    }
    drag = null;
    request();
  });
  stage.addEventListener("pointercancel", () => { drag = null; });
  stage.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse") { pointer = null; request(); } });

  scrub.min = String(start);
  scrub.max = String(end);
  if (vehicles > COLOURS_UP_TO) colour.value = "speed";
  readPalette();
  showScale();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readPalette(); request(); });
  new ResizeObserver(fit).observe(stage.parentElement);
  fit();
})();
