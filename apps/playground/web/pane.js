// One side of the page: a controller that can be chosen, its body, and what is seen of it.

import { Runner } from "./runner.js";
import { drawBody, wanted } from "./view/body.js";
import { Canvas } from "./view/canvas.js";
import { drawCircle } from "./view/circle.js";
import { drawApexMap, drawForces, drawLags } from "./view/plots.js";
import { Surface } from "./view/surface.js";

const NUMBERS_MS = 250;

export class Pane {
  // engines: gives the engine of a name; onChoice: called when another controller is chosen.
  constructor(template, label, engines, definitions, onChoice) {
    this.element = template.content.firstElementChild.cloneNode(true);
    this.element.setAttribute("aria-label", label);
    this.find = (name) => this.element.querySelector(`.${name}`);
    this.chooser = this.find("controller");
    this.chooser.addEventListener("change", () => onChoice(this));
    this.engines = engines;
    this.definitions = definitions;
    this.runners = new Map();
    this.surface = new Surface();
    this.label = label;
    this.toldAt = -Infinity;
  }

  // When it is part of the page, its canvases have a size.
  begin() {
    const canvas = (name) => new Canvas(this.find(name));
    const names = ["body", "circle", "map", "surface", "forces"];
    this.canvases = Object.fromEntries(names.map((name) => [name, canvas(name)]));
  }

  offer(controllers, body) {
    const offered = controllers.map((each, i) => [each, i]).filter(([each]) => body.name in each.engines);
    const before = this.chooser.value;
    this.chooser.replaceChildren(...offered.map(([each, i]) => new Option(each.label, String(i))));
    const values = offered.map(([, i]) => String(i));
    this.chooser.value = values.includes(before) ? before : values[0];
  }

  // Put a controller on the body. Lanes are used again: their memory is never given back.
  async take(controller, body, world) {
    const name = controller.engines[body.name];
    if (!this.runners.has(name)) {
      const engine = await this.engines(name);
      this.runners.set(name, new Runner(engine, body, controller, this.definitions));
    }
    this.runner = this.runners.get(name);
    this.runner.body = body;
    this.runner.steer(controller);
    this.find("body").setAttribute("aria-label", `${this.label}: ${body.name} driven by ${controller.label}`);
    this.find("map-name").textContent = body.limbs > 1 ? `Lags behind ${body.legs[0]}, in turns` : "Apex map";
    this.find("surface-name").textContent = `Force over ${controller.rhythm ? "φ" : "ẏ"} and F_k (yellow: full); path of the last 2 s`;
    this.find("map").setAttribute("aria-label", body.limbs > 1 ? "Lags of the legs over time" : "Apex heights, each over the one before");
    this.release(world);
  }

  release(world) {
    this.runner.release(world);
    this.camera = { ground: 0, seen: wanted(this.runner) };
    this.toldAt = -Infinity;
    this.surface.change();
  }

  meet(world) {
    this.runner.meet(world);
    this.surface.change();
  }

  draw(colours, now) {
    const { runner, canvases } = this;
    this.camera.ground += 0.15 * (runner.pose.ground - this.camera.ground);
    this.camera.seen += 0.05 * (wanted(runner) - this.camera.seen);
    drawBody(canvases.body, runner, colours, this.camera);
    drawCircle(canvases.circle, runner, colours);
    (runner.body.limbs > 1 ? drawLags : drawApexMap)(canvases.map, runner, colours);
    this.surface.draw(canvases.surface, runner, colours);
    drawForces(canvases.forces, runner, colours);
    if (now - this.toldAt > NUMBERS_MS) this.tell(now);
  }

  // What a listener is told of the motion.
  described() {
    const { runner } = this;
    const { hops } = runner;
    const who = `${this.label}: ${this.chooser.selectedOptions[0].label}, ${runner.time.toFixed(0)} seconds after the release`;
    if (runner.failed) return `${who}, has fallen.`;
    if (hops.list.length < 2 || hops.rests(runner.time)) return `${who}, does not hop.`;
    return `${who}, hops at ${hops.rate().toFixed(1)} radians per second to ${hops.list.at(-1).height.toFixed(2)} metres, with ${hops.cost().toFixed(2)} metres per joule.`;
  }

  tell(now) {
    const { runner } = this;
    const { hops } = runner;
    const known = (x, digits) => (hops.list.length > 1 ? x.toFixed(digits) : "–");
    const shown = {
      cost: known(hops.cost(), 2),
      rate: known(hops.rate(), 1),
      apex: known(hops.list.at(-1)?.height, 2),
      time: runner.time.toFixed(1),
    };
    for (const [name, text] of Object.entries(shown)) this.find(name).textContent = text;
    const fallen = this.find("fallen");
    if (fallen.hidden === runner.failed) {
      fallen.hidden = !runner.failed;
      fallen.textContent = runner.failed ? "Fallen: a hip is on the ground. Release it again." : "";
    }
    this.toldAt = now;
  }
}
