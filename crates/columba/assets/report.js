"use strict";
// The replay. Lengths arrive in mm, angles in 0.1 mrad, times in ms: `x[tick * vehicles + vehicle]`.
(() => {
  const stage = document.getElementById("stage");
  if (!stage) return;
  const flight = JSON.parse(document.getElementById("flight").textContent);
  const { vehicles, t, x, y, altitude, speed, course, separation, clearance, obstacles, safe } = flight;
  const [play, scrub, clock, rate, follow, tip, readout] =
    ["play", "scrub", "clock", "rate", "follow", "tip", "readout"].map((id) => document.getElementById(id));
  const context = stage.getContext("2d");
  const start = t[0], end = t[t.length - 1];
  const TRAIL_MS = 10000;      // how far back the bright part of a path goes
  const PAIRS_UP_TO = 300;     // vehicles: beyond that, testing all pairs in every frame is too slow

  let now = start;             // ms
  let playing = false;
  let pointer = null;          // px in the canvas
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

  /** Every vehicle at `now`, between two ticks on the straight line from one to the other. */
  function flockAt(ms) {
    const tick = tickAt(ms), next = Math.min(tick + 1, t.length - 1);
    const part = next > tick ? (ms - t[tick]) / (t[next] - t[tick]) : 0;
    const flock = [];
    for (let vehicle = 0; vehicle < vehicles; vehicle++) {
      const a = tick * vehicles + vehicle, b = next * vehicles + vehicle;
      const mix = (values) => values[a] + part * (values[b] - values[a]);
      const turn = ((course[b] - course[a] + 94248) % 62832 + 62832) % 62832 - 31416;
      flock.push({ x: mix(x) / 1e3, y: mix(y) / 1e3, altitude: mix(altitude) / 1e3, speed: mix(speed) / 1e3,
        course: (course[a] + part * turn) / 1e4 });
    }
    return { tick, next: part > 0 ? next : tick, flock };
  }

  // ---- From metres to px ----

  const bounds = (() => {
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    const add = (px, py, radius) => {
      left = Math.min(left, px - radius); right = Math.max(right, px + radius);
      low = Math.min(low, py - radius); high = Math.max(high, py + radius);
    };
    for (const [ox, oy, radius] of obstacles) add(ox / 1e3, oy / 1e3, radius / 1e3);
    for (let index = 0; index < x.length; index++) add(x[index] / 1e3, y[index] / 1e3, 0);
    if (!(left <= right)) [left, right, low, high] = [-10, 10, -10, 10];
    const margin = 0.04 * Math.max(right - left, high - low) + 2;
    return { left: left - margin, right: right + margin, low: low - margin, high: high + margin };
  })();

  /** The camera: the whole field, or the flock and what is around it. The y axis points up, as in the figures. */
  function camera(flock, width, height) {
    let { left, right, low, high } = bounds;
    if (follow.checked && flock.length) {
      const xs = flock.map((one) => one.x), ys = flock.map((one) => one.y);
      const around = Math.max(25, 0.35 * (Math.max(...xs) - Math.min(...xs)));
      [left, right] = [Math.min(...xs) - around, Math.max(...xs) + around];
      [low, high] = [Math.min(...ys) - around, Math.max(...ys) + around];
    }
    const scale = Math.min(width / (right - left), height / (high - low));
    const [middleX, middleY] = [(left + right) / 2, (low + high) / 2];
    return { scale, px: (mx) => width / 2 + (mx - middleX) * scale, py: (my) => height / 2 - (my - middleY) * scale };
  }

  // ---- Drawing ----

  let palette = {};
  function readPalette() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(`--${name}`).trim();
    palette = { series: [] };
    for (const name of ["page", "ink", "soft", "faint", "disc", "disc-edge", "alarm"]) palette[name] = colour(name);
    for (let index = 1; index <= 8; index++) palette.series.push(colour(`s${index}`));
  }
  const colourOf = (vehicle) => palette.series[vehicle % palette.series.length];

  /** The canvas in device pixels, as high as the field asks for within what a screen can show. */
  function fit() {
    const width = stage.parentElement.clientWidth;
    const asked = width * (bounds.high - bounds.low) / (bounds.right - bounds.left);
    const height = Math.round(Math.max(Math.min(asked, 0.7 * innerHeight), 220));
    const ratio = devicePixelRatio || 1;
    stage.style.height = `${height}px`;
    stage.width = Math.round(width * ratio);
    stage.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    request();
  }

  function strokePath(vehicle, from, to, head, view) {
    context.beginPath();
    for (let tick = from; tick <= to; tick++) {
      const index = tick * vehicles + vehicle;
      context.lineTo(view.px(x[index] / 1e3), view.py(y[index] / 1e3));
    }
    if (head) context.lineTo(view.px(head.x), view.py(head.y));
    context.stroke();
  }

  function drawGrid(width, height, view) {
    const step = [5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000].find((metres) => metres * view.scale >= 60) || 100000;
    const mx = (px) => (px - view.px(0)) / view.scale, my = (py) => (view.py(0) - py) / view.scale;
    context.lineWidth = 1;
    context.strokeStyle = palette.faint;
    context.fillStyle = palette.soft;
    context.font = "12px system-ui, sans-serif";
    const minus = (value) => String(value).replace("-", "\u2212");
    for (let metres = Math.ceil(mx(0) / step) * step; metres <= mx(width); metres += step) {
      context.beginPath(); context.moveTo(view.px(metres), 0); context.lineTo(view.px(metres), height); context.stroke();
      const label = minus(metres), x = view.px(metres) + 4;
      if (x + context.measureText(label).width < width - 2) context.fillText(label, x, height - 6);
    }
    for (let metres = Math.ceil(my(height) / step) * step; metres <= my(0); metres += step) {
      context.beginPath(); context.moveTo(0, view.py(metres)); context.lineTo(width, view.py(metres)); context.stroke();
      if (view.py(metres) < height - 24 && view.py(metres) > 16) context.fillText(`${minus(metres)} m`, 4, view.py(metres) - 4);
    }
  }

  function drawUav(one, vehicle, view, picked) {
    const size = (vehicles > 60 ? 6 : 9) * (picked ? 1.35 : 1);
    context.save();
    context.translate(view.px(one.x), view.py(one.y));
    context.rotate(-one.course);
    context.beginPath();
    context.moveTo(size, 0); context.lineTo(-0.7 * size, 0.62 * size); context.lineTo(-0.7 * size, -0.62 * size);
    context.closePath();
    context.fillStyle = colourOf(vehicle);
    context.fill();
    context.lineWidth = picked ? 2 : 1;
    context.strokeStyle = picked ? palette.ink : palette.page;
    context.stroke();
    context.restore();
  }

  function drawLostSeparations(flock, view) {
    if (vehicles > PAIRS_UP_TO) return;
    context.strokeStyle = palette.alarm;
    context.lineWidth = 2;
    for (let one = 0; one < flock.length; one++) {
      for (let other = one + 1; other < flock.length; other++) {
        const [a, b] = [flock[one], flock[other]];
        if (Math.hypot(a.x - b.x, a.y - b.y) >= safe / 1e3) continue;
        context.beginPath(); context.moveTo(view.px(a.x), view.py(a.y)); context.lineTo(view.px(b.x), view.py(b.y)); context.stroke();
      }
    }
  }

  function draw() {
    const width = stage.clientWidth, height = stage.clientHeight;
    const { tick, next, flock } = flockAt(now);
    const view = camera(flock, width, height);
    context.clearRect(0, 0, width, height);
    drawGrid(width, height, view);
    context.fillStyle = palette.disc;
    context.strokeStyle = palette["disc-edge"];
    for (const [ox, oy, radius] of obstacles) {
      context.beginPath();
      context.arc(view.px(ox / 1e3), view.py(oy / 1e3), radius / 1e3 * view.scale, 0, 2 * Math.PI);
      context.fill(); context.stroke();
    }
    const recent = tickAt(Math.max(start, now - TRAIL_MS));
    for (let vehicle = 0; vehicle < vehicles; vehicle++) {
      context.strokeStyle = colourOf(vehicle);
      context.lineWidth = 1;
      context.globalAlpha = vehicles > 30 ? 0.12 : 0.3;
      strokePath(vehicle, 0, t.length - 1, null, view);
      context.lineWidth = vehicles > 30 ? 1.2 : 2.2;
      context.globalAlpha = 1;
      strokePath(vehicle, recent, tick, flock[vehicle], view);
    }
    drawLostSeparations(flock, view);
    const picked = nearest(flock, view);
    flock.forEach((one, vehicle) => { if (vehicle !== picked) drawUav(one, vehicle, view, false); });
    if (picked !== null) drawUav(flock[picked], picked, view, true);
    describe(flock, picked, view, width);
    report(next);
  }

  /** The vehicle under the pointer, or near it. */
  function nearest(flock, view) {
    if (!pointer) return null;
    let [best, least] = [null, 28];
    flock.forEach((one, vehicle) => {
      const distance = Math.hypot(view.px(one.x) - pointer.x, view.py(one.y) - pointer.y);
      if (distance < least) [best, least] = [vehicle, distance];
    });
    return best;
  }

  // ---- Words ----

  const fixed = (value, digits) => value.toFixed(digits).replace(/^-(?=0\.?0*$)/, "").replace("-", "\u2212");

  function describe(flock, picked, view, width) {
    tip.hidden = picked === null;
    if (picked === null) return;
    const one = flock[picked];
    const degrees = (one.course * 180 / Math.PI % 360 + 360) % 360;
    tip.textContent = `UAV ${picked + 1}\n${fixed(one.speed, 2)} m/s\n${fixed(one.altitude, 1)} m up\ncourse ${fixed(degrees, 0)}\u00b0`;
    const [px, py] = [view.px(one.x), view.py(one.y)];
    tip.style.left = `${Math.max(0, px + 14 + tip.offsetWidth > width ? px - 14 - tip.offsetWidth : px + 14)}px`;
    tip.style.top = `${Math.max(0, py - tip.offsetHeight - 8)}px`;
  }

  function report(tick) {
    clock.textContent = `${fixed(now / 1e3, 1)} s`;
    scrub.value = String(Math.round(now));
    scrub.setAttribute("aria-valuetext", clock.textContent);
    const words = [];
    if (separation[tick] !== null) words.push(`Smallest separation ${fixed(separation[tick] / 1e3, 1)} m`);
    if (clearance[tick] !== null) words.push(`smallest clearance ${fixed(clearance[tick] / 1e3, 1)} m`);
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

  play.addEventListener("click", () => setPlaying(!playing));
  scrub.addEventListener("input", () => seek(Number(scrub.value)));
  follow.addEventListener("change", request);
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
    };
    // Home and End move the page unless the replay has the focus.
    const focused = event.target === stage || event.target === scrub;
    if (busy || !(event.key in actions) || (event.key.length > 1 && !event.key.startsWith("Arrow") && !focused)) return;
    event.preventDefault();
    actions[event.key]();
  });
  const point = (event) => {
    const box = stage.getBoundingClientRect();
    pointer = { x: event.clientX - box.left, y: event.clientY - box.top };
    request();
  };
  stage.addEventListener("pointermove", point);
  stage.addEventListener("pointerdown", point);
  stage.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse") { pointer = null; request(); } });

  scrub.min = String(start);
  scrub.max = String(end);
  readPalette();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readPalette(); request(); });
  new ResizeObserver(fit).observe(stage.parentElement);
  fit();
})();
