// The learner: it evolves weights on the engine, and tells of every generation.

import { Engine } from "../engine.js";
import { episode } from "./fitness.js";
import { Search } from "./pgpe.js";
import { Random } from "./random.js";

// task: wasm, layout, given (what a lane is given, by name), weights, settings, timing, definitions,
// seed, generations. `tell` is called with every generation.
export async function learn(task, tell) {
  const engine = await Engine.of(task.wasm, task.layout);
  const lane = engine.lane();
  for (const [name, value] of Object.entries(task.given)) lane.set(name, value);
  const search = new Search(task.weights, task.settings);
  const random = new Random(task.seed);
  const judge = (weights) => {
    lane.set("weights", Float32Array.from(weights));
    return episode(lane, task.timing, task.definitions);
  };
  let best = { fitness: -Infinity };
  for (let generation = 0; generation < task.generations; generation++) {
    const samples = search.ask(() => random.normal());
    const own = judge(search.mean);
    const outcomes = samples.map(judge);
    if (own.fitness > best.fitness)
      best = { fitness: own.fitness, cotInverse: own.cotInverse, weights: Array.from(search.mean), generation };
    const failed = outcomes.filter((each) => each.failed).length / outcomes.length;
    tell({ generation, fitness: own.fitness, cotInverse: own.cotInverse, failed, best });
    search.tell(samples, outcomes.map((each) => each.fitness));
  }
}

if (typeof WorkerGlobalScope !== "undefined")
  self.onmessage = ({ data }) => learn(data, (told) => self.postMessage(told)).then(() => self.postMessage({ done: true }));
