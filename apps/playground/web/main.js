// The page: controls that change the world, two panes that show it, and time that goes on.

import { legBoxes, numberSliders } from "./controls.js";
import { Engine, unpacked } from "./engine.js";
import { Learner } from "./learner.js";
import { doneOf, linked, numbersOf } from "./link.js";
import { Pane } from "./pane.js";
import { TICK_S } from "./runner.js";
import { Tour } from "./tour.js";
import { readColours } from "./view/canvas.js";
import { World } from "./world.js";

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
const PUSH_M_PER_S = 0.5;
const LONGEST_STEP_S = 0.05;
const TRIAL_S = 4;

// Engines by name, unpacked once.
const bytes = new Map();
const engines = new Map();
async function engineBytes(name) {
  const { wasm, layout } = data.engines[name];
  if (!bytes.has(name)) bytes.set(name, unpacked(wasm));
  return { wasm: await bytes.get(name), layout };
}
function engine(name) {
  if (!engines.has(name)) engines.set(name, engineBytes(name).then((each) => Engine.of(each.wasm, each.layout)));
  return engines.get(name);
}

const lessMotion = matchMedia("(prefers-reduced-motion: reduce)");
const narrow = matchMedia("(max-width: 52rem)");
const state = { playing: !lessMotion.matches, two: !narrow.matches, left: 0, last: null, busy: 0 };
const world = new World(data.bodies[0]);
const panes = ["Left", "Right"].map((label) => new Pane(byId("pane"), label, engine, data.definitions, chosen));
panes.forEach((pane) => byId("panes").append(pane.element));
panes.forEach((pane) => pane.begin());
const learner = new Learner(data, engineBytes, tried);
let colours = readColours();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (colours = readColours()));

const shown = () => (state.two ? panes : panes.slice(0, 1)).filter((pane) => pane.runner);
const controllers = () => (learner.learned ? [...data.controllers, learner.learned] : data.controllers);
const changed = () => shown().forEach((pane) => pane.meet(world));

async function chosen(pane) {
  state.busy++;
  await pane.take(controllers()[Number(pane.chooser.value)], world.body, world);
  state.busy--;
  offerSigma();
}

// A line for those who listen to the page.
function say(text) {
  byId("said").textContent = text;
}

const tour = new Tour(byId("tour"), say);

// The numbers of what is seen, in a sentence a side.
function describe() {
  say(shown().map((pane) => pane.described()).join(" "));
}

function release() {
  say("Released.");
  world.mend();
  showWorld();
  shown().forEach((pane) => pane.release(world));
}

function push(speed) {
  say(speed < 0 ? "Pushed down." : "Pushed up.");
  shown().forEach((pane) => pane.runner.push(speed));
}

function drop() {
  world.ground -= Number(byId("drop-by").value);
  say(`The ground is at ${world.ground.toFixed(1)} m.`);
  changed();
}

function freeze(frozen) {
  world.frozen = frozen;
  say(frozen ? "The oscillator is frozen." : "The oscillator moves.");
  byId("frozen").checked = frozen;
  changed();
}

function play(playing) {
  state.playing = playing;
  state.last = null;
  byId("play").textContent = playing ? "Pause" : "Play";
}

async function takeBody(name) {
  if (learner.going && name !== learner.body.name) learner.stop();
  world.takeBody(data.bodies.find((body) => body.name === name));
  byId("bodies").querySelector(`[value="${CSS.escape(name)}"]`).checked = true;
  showWorld();
  panes.forEach((pane) => pane.offer(controllers(), world.body));
  if (panes[1].chooser.value === panes[0].chooser.value && panes[1].chooser.options.length > 1) {
    const values = [...panes[1].chooser.options].map((each) => each.value);
    panes[1].chooser.value = values.find((value) => value !== panes[0].chooser.value);
  }
  await Promise.all(panes.map(chosen));
}

// What the controls show of the world.
function showWorld() {
  byId("frozen").checked = world.frozen;
  byId("numbers").replaceChildren(...numberSliders(world, data.controllers[0].omega, changed));
  const several = world.body.limbs > 1;
  byId("legs").hidden = byId("phases-row").hidden = !several;
  byId("push-note").textContent = several ? `by ${PUSH_M_PER_S} m/s, on ${world.body.legs[0]}` : `by ${PUSH_M_PER_S} m/s`;
  if (several) byId("legs").replaceChildren(byId("legs").firstElementChild, ...legBoxes(world, changed));
  offerSigma();
}

// σ can be changed where it is one number and no network.
function offerSigma() {
  const able = shown().some((pane) => pane.runner.controller.sigma !== null);
  byId("number-sigma").disabled = !able;
}

async function compare(two) {
  state.two = two;
  byId("compare").checked = two;
  panes[1].element.hidden = !two;
  if (panes[1].runner && two) await chosen(panes[1]);
}

async function learn() {
  if (learner.going) return learner.stop();
  if (world.body.name !== learner.leg.name) await takeBody(learner.leg.name);
  const pane = state.two ? panes[1] : panes[0];
  await learner.start(world);
  panes.forEach((each) => each.offer(controllers(), world.body));
  pane.chooser.value = String(data.controllers.length);
  await chosen(pane);
}

// A link to the page as it is, without what was learned on it.
function link() {
  const labels = panes.map((pane) => (data.controllers[Number(pane.chooser.value)] ?? data.controllers[0]).label);
  history.replaceState(null, "", `#${linked(world, labels, state.two, byId("speed").value)}`);
  const copied = navigator.clipboard?.writeText(location.href) ?? Promise.reject();
  const show = (text) => {
    say(text);
    byId("link-note").textContent = text;
  };
  copied.then(() => show("Link copied."), () => show("The link is in the address bar."));
}

// The page of a link: what it names and this page has.
async function openLink(words) {
  const body = data.bodies.find((each) => each.name === words.get("body"));
  if (body) await takeBody(body.name);
  for (const [i, side] of ["left", "right"].entries()) {
    const at = String(data.controllers.findIndex((each) => each.label === words.get(side)));
    if ([...panes[i].chooser.options].some((each) => each.value === at)) panes[i].chooser.value = at;
  }
  if ([...byId("speed").options].some((each) => each.value === words.get("speed"))) byId("speed").value = words.get("speed");
  if (words.has("two")) state.two = words.get("two") === "1";
  numbersOf(words, world);
  await Promise.all(panes.map(chosen));
  doneOf(words, world);
  showWorld();
  panes.forEach((pane) => pane.release(world));
}

// Better weights: where they are shown they count at once, and a gait that is over begins anew.
function tried(controller) {
  for (const pane of shown()) {
    if (pane.chooser.value !== String(data.controllers.length)) continue;
    const { runner } = pane;
    runner.steer(controller);
    pane.meet(world);
    if (runner.failed || (runner.time > TRIAL_S && runner.hops.rests(runner.time))) pane.release(world);
  }
}

// Simulated time: what is left of a tick counts for the next time.
function advance(seconds) {
  const due = state.left + seconds / TICK_S;
  const ticks = Math.floor(due);
  state.left = due - ticks;
  for (const pane of shown()) pane.runner.advance(ticks);
}

function draw(now) {
  for (const pane of shown()) pane.draw(colours, now);
  learner.draw(colours);
}

function frame(now) {
  const since = state.last === null ? 0 : (now - state.last) / 1000;
  state.last = now;
  if (state.playing && !state.busy) advance(Math.min(since, LONGEST_STEP_S) * Number(byId("speed").value));
  if (!state.busy) draw(now);
  requestAnimationFrame(frame);
}

const clicks = {
  play: () => play(!state.playing),
  release,
  drop,
  "push-down": () => push(-PUSH_M_PER_S),
  "push-up": () => push(PUSH_M_PER_S),
  phases: () => {
    world.seed++;
    release();
  },
  usual: () => {
    world.usual();
    showWorld();
    changed();
  },
  learn,
  link,
  describe,
  "tour-start": () => tour.begin(byId("tour-start")),
};
for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener("click", act);
byId("frozen").addEventListener("change", (event) => freeze(event.target.checked));
byId("compare").addEventListener("change", (event) => compare(event.target.checked));

// Keys, where they mean nothing else.
const keys = { " ": clicks.play, r: release, d: drop, p: clicks["push-down"], f: () => freeze(!world.frozen), l: learn, s: describe };
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.repeat || !(event.key in keys)) return;
  const { tagName, type } = event.target;
  if (tagName === "SELECT" || (event.key === " " && (tagName === "BUTTON" || tagName === "SUMMARY" || (tagName === "INPUT" && type !== "range")))) return;
  event.preventDefault();
  keys[event.key]();
});

byId("bodies").append(...data.bodies.map((body) => {
  const label = document.createElement("label");
  const radio = Object.assign(document.createElement("input"), { type: "radio", name: "body", value: body.name });
  radio.addEventListener("change", () => takeBody(body.name));
  label.append(radio, body.name);
  return label;
}));
try {
  const first = data.bodies.find((body) => body.name in data.controllers[0].engines);
  await takeBody(first.name);
  if (location.hash.length > 1) await openLink(new URLSearchParams(location.hash.slice(1)));
  await compare(state.two);
  play(state.playing);
  requestAnimationFrame(frame);
} catch (error) {
  byId("trouble").hidden = false;
  byId("trouble").textContent = `This browser cannot run the page, which needs WebAssembly and DecompressionStream: ${error.message}`;
  throw error;
}

// For the console, and for tests: `playground.advance(60)` is a minute at once.
window.playground = { world, panes, learner, state, engines, advance, draw: () => draw(performance.now()), takeBody };
