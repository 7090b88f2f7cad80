// Learning in the page: a worker evolves weights, the curve rises, and the best are tried at once.

import { Canvas } from "./view/canvas.js";
import { drawCurve } from "./view/plots.js";

const TOLD_MS = 1000;

export class Learner {
  // data: the page's; engineBytes: gives the WebAssembly of an engine; shown: called with the
  // controller that learns, whenever its weights are better.
  constructor(data, engineBytes, shown) {
    Object.assign(this, { data, engineBytes, shown });
    this.curve = [];
    this.canvas = new Canvas(document.getElementById("curve"));
    this.button = document.getElementById("learn");
    this.chooser = document.getElementById("learner");
    this.status = document.getElementById("learned");
    this.runs = 0;
    this.toldAt = 0;
    this.learned = null;
    const able = data.controllers.filter((each) => each.starts.length > 0);
    this.chooser.replaceChildren(...able.map((each) => new Option(each.label.split(":")[0], String(data.controllers.indexOf(each)))));
    const usual = able.find((each) => each.label.startsWith("ART")) ?? able[0];
    if (usual) this.chooser.value = String(data.controllers.indexOf(usual));
    this.button.disabled = able.length === 0;
    const { settings, timing } = data.learning;
    document.getElementById("episodes").textContent = `${settings.population + 1} episodes of ${timing.duration_s} s`;
  }

  // The controller that would be learned, and the one leg on which.
  get like() {
    return this.data.controllers[Number(this.chooser.value)];
  }

  get leg() {
    return this.data.bodies.find((body) => body.limbs === 1 && body.name in this.like.engines);
  }

  get going() {
    return Boolean(this.worker);
  }

  // The controller that is learned from now on: random weights, and the engine of the chosen one.
  async start(world) {
    const { like } = this;
    const body = world.body.name;
    const seed = this.runs++;
    const weights = like.starts[seed % like.starts.length];
    this.curve.length = 0;
    this.body = world.body;
    this.omega = world.omega ?? like.omega;
    this.given = given(world, this.omega);
    this.learned = { ...like, label: `learned here: ${like.label.split(":")[0]}`, omega: this.omega, weights: [...weights] };
    const { wasm, layout } = await this.engineBytes(like.engines[body]);
    const source = document.getElementById("worker").textContent;
    this.url ??= URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    this.worker = new Worker(this.url);
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => this.fail(event.message ?? "it could not be started");
    const { settings, timing, generations } = this.data.learning;
    const definitions = { ...this.data.definitions, follow_omega: like.rhythm };
    this.worker.postMessage({ wasm, layout, given: this.given, weights, settings, timing, definitions, seed, generations });
    this.says("Learning: the first generation …");
    this.button.textContent = "Stop";
    this.button.setAttribute("aria-pressed", "true");
    return this.learned;
  }

  hear(told) {
    if (told.done) return this.stop("Done");
    this.curve.push(told);
    if (told.best.generation === told.generation) {
      this.learned.weights = told.best.weights;
      this.shown(this.learned);
    }
    if (performance.now() - this.toldAt > TOLD_MS) this.says(this.summary("Learning"));
  }

  summary(word) {
    if (this.curve.length === 0) return `${word}.`;
    const { generation, best } = this.curve.at(-1);
    return `${word}: generation ${generation + 1}, best fitness ${best.fitness.toFixed(2)}, CoT⁻¹ ${best.cotInverse.toFixed(2)} m/J.`;
  }

  stop(word = "Stopped") {
    this.worker?.terminate();
    this.worker = null;
    this.says(this.summary(word));
    this.button.textContent = "Learn";
    this.button.setAttribute("aria-pressed", "false");
  }

  fail(message) {
    this.stop();
    this.says(`The worker stopped: ${message}`);
  }

  says(text) {
    this.status.textContent = text;
    this.toldAt = performance.now();
  }

  draw(colours) {
    drawCurve(this.canvas, this.curve, this.optimum(), colours);
  }

  // The best CoT⁻¹ known at this frequency, for the one body of which it is known.
  optimum() {
    const { optimum, of_body: known } = this.data.learning;
    if (!this.learned || !known || !Object.entries(known).every(([name, x]) => this.given[`body.${name}`] === x)) return null;
    const at = optimum.omega.findIndex((omega) => omega >= this.omega);
    if (at <= 0) return null;
    const [x0, x1] = optimum.omega.slice(at - 1, at + 1);
    const [y0, y1] = optimum.cot_inverse.slice(at - 1, at + 1);
    return y0 + ((y1 - y0) * (this.omega - x0)) / (x1 - x0);
  }
}

// What a lane of an episode is given beside its weights.
export function given(world, omega) {
  const numbers = Object.entries(world.numbers).map(([name, value]) => [`body.${name}`, value]);
  return {
    ...Object.fromEntries(numbers),
    omega: omega ?? 0,
    ground_m: 0,
    "release.height_m": world.height,
    "release.velocity_m_per_s": 0,
    "release.phase_rad": 0,
  };
}
