// The page: what it is told, what it shows beside the picture, its buttons and keys. It asks nobody for anything: a
// live flight comes by `live.js`, and a recording may stand in the page itself.

import { momentsOf } from "./wire.js";
import { Player } from "./player.js";
import { Stage, severity } from "./stage.js";
import { Table, stateOf } from "./table.js";
import { Charts } from "./charts.js";
import { Choices } from "./choice.js";
import { Operator } from "./operator.js";
import { Selected } from "./selected.js";

const element = (id) => document.getElementById(id);
const parameters = new URLSearchParams(location.search);
const EVENTS_SHOWN = 500;

export const player = new Player();
const stage = new Stage(element("stage"), player, ["canvas", "webgl"].find((name) => parameters.has(name)));
const table = new Table(element("table"), element("count"), element("filter"), stage);
const charts = new Charts(element("charts"), player, (time) => player.seek(time));
const choices = new Choices(element("choice"), player);
let sayTo = () => false;
let lookTo = () => {};
const operator = new Operator(
  {
    all: element("orders"), one: element("orders-one"), note: element("order-note"),
    dialog: element("ask"), answer: element("answer"),
  },
  (words) => sayTo(words));
const selected = new Selected(
  {
    hint: element("selected-hint"), name: element("selected-name"), facts: element("selected-facts"),
    several: element("selected-several"), events: element("selected-events"),
  },
  stage, fillEvents);
let roster = { version: 0, numbers: [], systems: [], kinds: [], modes: [] };
let scene = { circles: [], outlines: [], verbs: [] };
let events = [];
let may = false;
let connection = "connects";

/** Where the operator's words go; gives whether they are on their way. */
export function setSay(say) {
  sayTo = say;
}

/** Whom the program is told that this page looks at: the number of a vehicle, or null. */
export function setLook(look) {
  lookTo = look;
}

// ---- What the program sends ----

/** Takes a message of the program. */
export function hear(message) {
  if (message.scene) setScene(message.scene);
  if (message.roster) setRoster(message.roster);
  if (message.told) { events.push(...message.told); drawEvents(); }
  if (message.choices) { choices.take(message.choices); stage.isStale = true; }
  if (message.recording) setRecording(message.recording);
  if (message.summary) setSummary(message.summary);
  if (message.may) { may = true; operator.offer(scene.takes_words ? scene.verbs : [], may); }
  if (message.answer) operator.answered(message.answer);
}

function setScene(next) {
  scene = next;
  document.title = `${scene.title || "flight"} \u2013 Columba`;
  element("title").textContent = scene.title || "Columba";
  element("title").title = scene.source;
  stage.setScene(scene);
  operator.offer(scene.takes_words ? scene.verbs : [], may);
}

function setRoster(next) {
  roster = table.roster = next;
  stage.numbers = roster.numbers;
  player.version++;
}

function setSummary({ phase, least }) {
  element("phase").textContent = phase;
  const isTooNear = (value) => scene.separation_m > 0 && value < scene.separation_m;
  setLeast("least-separation", "separation", least.separation, least, isTooNear);
  setLeast("least-clearance", "clearance", least.clearance, least, (value) => value < 0);
}

function setLeast(id, what, least, { is_of_flight: isOfFlight }, isBad) {
  const button = element(id);
  const words = ({ value_m: value, vehicles, at_s: time }) => {
    const metres = value.toFixed(2).replace("-", "\u2212");
    const whose = `${vehicles.length > 1 ? "vehicles" : "vehicle"} ${vehicles.join(" and ")}`;
    return `least ${what} ${metres} m: ${whose}, at ${time.toFixed(1)} s`;
  };
  button.textContent = least ? words(least) : "";
  button.classList.toggle("bad", Boolean(least) && isBad(least.value_m));
  const ofFlight = scene.distances_rest_on || "measured by the flight at every step";
  const basis = isOfFlight ? ofFlight : "of the moments that this page was sent";
  button.title = `The least ${what} so far: ${basis}. Click to go there.`;
  button.onclick = () => goTo(least.vehicles, least.at_s);
}

/** Selects vehicles by their numbers, and goes to a time that is remembered. */
function goTo(numbers, time) {
  if (player.moments.length && time !== undefined && time < player.end - 0.5) {
    player.seek(time);
    player.isPlaying = false;
  }
  player.fill(stage.flock);
  const indices = numbers.map((number) => roster.numbers.indexOf(number)).filter((index) => index >= 0);
  stage.select(indices);
  stage.lookAt(indices);
}

/** How the flight is there: live, recorded, or gone. */
export function setConnection(text, isBad) {
  connection = text;
  showConnection();
  element("connection").classList.toggle("bad", isBad);
}

/** A live flight whose picture stands at a time that is past says so. */
function showConnection() {
  const isBehind = !player.isLive && !player.isRecording && player.newest;
  const text = isBehind ? `${connection}, but the past is shown` : connection;
  if (element("connection").textContent !== text) element("connection").textContent = text;
}

/** All is told anew: the program sends its events, or its recording, from the first. */
export function begin() {
  events = [];
  choices.forget();
  if (player.isRecording) player.record([]);
}

/** Takes what is known of a recording, of which a part may not have been read yet. */
function setRecording({ scene: known, roster: whose, told, least, choices: chosen, read = 1, duration_s: duration }) {
  setScene(known);
  setRoster(whose);
  events = told;
  choices.take(chosen ?? []);
  drawEvents();
  setSummary({ phase: "", least });
  player.duration = duration ?? 0;
  if (!player.isRecording) player.record([]);
  if (read === 1) stage.isFitted = false;
  setConnection(read < 1 ? `recording: ${Math.floor(100 * read)} % is read` : "recording", false);
}

/** Plays more moments of a recording. */
export function playOn(moments) {
  player.append(moments);
}

// ---- What the page shows beside the picture ----

function drawEvents() {
  fillEvents(element("events"), events.slice(-EVENTS_SHOWN).reverse());
  drawSelected();
}

function fillEvents(list, some) {
  list.replaceChildren(...some.map((event) => {
    const item = document.createElement("li");
    item.className = event.weight;
    const time = document.createElement("time");
    time.textContent = `${event.at_s.toFixed(1)} s`;
    const text = document.createElement("span");
    const who = document.createElement("b");
    const names = event.vehicles.join(" and ");
    who.textContent = names && `${event.vehicles.length > 1 ? "vehicles" : "vehicle"} ${names}: `;
    text.append(who, event.text);
    item.append(time, text);
    item.tabIndex = 0;
    item.onclick = () => goTo(event.vehicles, event.at_s);
    item.onkeydown = ({ key }) => { if (key === "Enter") item.onclick(); };
    return item;
  }));
}

/** Vehicles that ask for a look now, the worst first. */
function alarmsNow() {
  const moment = player.shownStatus();
  const found = [];
  for (let i = 0; moment && i < moment.n; i++) {
    const level = severity(moment.flags(i));
    if (level) found.push([level, i, moment.flags(i)]);
  }
  return found.sort((a, b) => b[0] - a[0] || a[1] - b[1]);
}

const modeOf = (i) => roster.modes[player.shownStatus()?.mode(i)] ?? "an unknown mode";

function drawAlarms() {
  const alarms = alarmsNow();
  const count = element("alarm-count");
  count.textContent = alarms.length || "";
  count.classList.toggle("bad", alarms.length > 0);
  const wordsOf = (i, flags) => `vehicle ${roster.numbers[i] ?? i + 1}: ${stateOf(flags)}, in ${modeOf(i)}`;
  const words = alarms.slice(0, 50).map(([level, i, flags]) => [level, i, wordsOf(i, flags)]);
  const text = words.map(([, , word]) => word).join("\n") + alarms.length;
  if (text === drawAlarms.text) return;
  drawAlarms.text = text;
  const note = document.createElement("p");
  note.className = "note";
  note.textContent = alarms.length ? (alarms.length > 50 ? `and ${alarms.length - 50} more` : "") : "No alarm now.";
  element("now").replaceChildren(...words.map(([level, i, word]) => {
    const button = document.createElement("button");
    button.type = "button";
    button.className = `level-${level}`;
    button.textContent = word;
    button.onclick = () => { stage.select([i]); stage.lookAt([i]); };
    return button;
  }), note);
}

let nextAlarm = 0;
function goToNextAlarm() {
  const alarms = alarmsNow();
  if (!alarms.length) return;
  const [, i] = alarms[nextAlarm++ % alarms.length];
  stage.select([i]);
  stage.lookAt([i]);
}

function drawSelected() {
  charts.show(stage.selected.size === 1 ? [...stage.selected][0] : null);
  choices.draw();
  selected.draw(roster, events);
}

stage.ways = () => choices.ways();
choices.onPoint = () => { stage.isStale = true; };

stage.onSelect = () => {
  const chosen = [...stage.selected];
  element("follow").setAttribute("aria-pressed", stage.follows);
  if (chosen.length && stage.onSelect.last !== chosen.join()) {
    if (!element("alarms").hidden || !element("selected").hidden || chosen.length > 1) openTab("selected");
    operator.select(chosen.map((i) => roster.numbers[i] ?? i + 1));
  }
  if (!chosen.length) operator.select([]);
  const looksAt = chosen.length === 1 ? roster.numbers[chosen[0]] ?? null : null;
  if (looksAt !== choices.number) lookTo(looksAt);
  choices.select(looksAt);
  stage.onSelect.last = chosen.join();
  drawSelected();
  table.drawRows();
};

function openTab(name) {
  for (const tab of document.querySelectorAll("[role=tab]")) {
    const isOpen = tab.getAttribute("aria-controls") === name;
    tab.setAttribute("aria-selected", isOpen);
    element(tab.getAttribute("aria-controls")).hidden = !isOpen;
  }
  slowly();
}
for (const tab of document.querySelectorAll("[role=tab]")) {
  tab.addEventListener("click", () => openTab(tab.getAttribute("aria-controls")));
}

// ---- Buttons and keys ----

const press = (id, does) => element(id).addEventListener("click", does);
const toggle3d = () => {
  stage.set3d(!stage.camera.is3d);
  element("view-3d").setAttribute("aria-pressed", stage.camera.is3d);
  stage.fit();
};
const toggleFollow = () => {
  stage.follows = !stage.follows;
  stage.isTouched = true;
  element("follow").setAttribute("aria-pressed", stage.follows);
  stage.isStale = true;
};
const zoom = (factor) => { stage.camera.zoom(factor); stage.touched(); };
const fit = () => { stage.follows = false; stage.fit(); element("follow").setAttribute("aria-pressed", false); };
press("view-3d", toggle3d);
press("fit", fit);
press("follow", toggleFollow);
press("north", () => stage.northUp());
press("zoom-in", () => zoom(1.4));
press("zoom-out", () => zoom(1 / 1.4));
press("play", () => player.toggle());
press("back", () => player.step(-1));
press("forth", () => player.step(1));
press("live", () => player.goLive());
element("colour-by").addEventListener("change", ({ target }) => {
  stage.colourBy = target.value;
  stage.isStale = true;
});
element("speed").addEventListener("change", ({ target }) => { player.speed = Number(target.value); });
element("scrub").addEventListener("input", ({ target }) => {
  player.seek(player.start + (player.last - player.start) * Number(target.value) / 1000);
});

const KEYS = {
  " ": () => player.toggle(), ",": () => player.step(-1), ".": () => player.step(1), l: () => player.goLive(),
  "3": toggle3d, "2": () => { if (stage.camera.is3d) toggle3d(); }, "0": fit, f: toggleFollow, n: () => stage.northUp(),
  "+": () => zoom(1.4), "=": () => zoom(1.4), "-": () => zoom(1 / 1.4), a: goToNextAlarm,
  "/": () => { openTab("vehicles"); element("filter").focus(); }, Escape: () => stage.select([]),
  ArrowLeft: () => pan(60, 0), ArrowRight: () => pan(-60, 0), ArrowUp: () => pan(0, 60), ArrowDown: () => pan(0, -60),
  q: () => { stage.camera.turn(0.15, 0); stage.isTurned = true; stage.touched(); },
  e: () => { stage.camera.turn(-0.15, 0); stage.isTurned = true; stage.touched(); },
};
const pan = (dx, dy) => { stage.camera.pan(dx, dy); stage.touched(); };
addEventListener("keydown", (event) => {
  const isTyping = event.target.closest("input, select, dialog") && event.key !== "Escape";
  if (isTyping || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === " " && event.target.closest("button")) return;
  const does = KEYS[event.key] ?? KEYS[event.key.toLowerCase()];
  if (!does) return;
  event.preventDefault();
  does();
});

// ---- Clockwork ----

let before = performance.now();
let slow = 0;
function each(clock) {
  player.advance((clock - before) / 1000);
  before = clock;
  stage.draw(clock);
  if (clock - slow > 250) slowly(clock);
  requestAnimationFrame(each);
}

/** What needs no hurry: words and numbers. */
function slowly(clock = performance.now()) {
  slow = clock;
  const isRunning = player.isLive || player.isPlaying;
  element("play").textContent = isRunning ? "Pause" : "Play";
  element("live").hidden = player.isLive || player.isRecording;
  const span = player.last - player.start;
  if (document.activeElement !== element("scrub") || isRunning) {
    element("scrub").value = span > 0 ? 1000 * (player.now - player.start) / span : 1000;
  }
  showConnection();
  element("clock").textContent = `${player.now.toFixed(1)} s`;
  if (!element("vehicles").hidden) table.draw();
  drawAlarms();
  if (!element("selected").hidden) {
    drawSelected();
    charts.draw();
  }
}

// For tests, and for the curious.
window.columba = { player, stage, table, choices, get events() { return events; }, get roster() { return roster; } };

const inline = element("recording");
if (inline) {
  const letters = atob(element("recording-frames").textContent.trim());
  setRecording(JSON.parse(inline.textContent));
  playOn(momentsOf(Uint8Array.from(letters, (letter) => letter.charCodeAt(0)).buffer));
  player.isPlaying = false;
}
requestAnimationFrame(each);
