// One controller on one body: a lane, what happens to it, and what is remembered of it.

import { History } from "./history.js";
import { Hops } from "./measures.js";

export const TICK_S = 0.001;
export const FRAME_TICKS = 5;
const REMEMBERED_S = 5;
const OF_BODY = ["time_s", "height_m", "velocity_m_per_s"];

export class Runner {
  constructor(engine, body, controller, definitions) {
    this.lane = engine.lane();
    this.body = body;
    this.hops = new Hops(definitions);
    const ofLimbs = ["phase_rad", "spring_force_n", "actuator_force_n", "feedback_rad_per_s"];
    const names = [...OF_BODY];
    for (const name of ofLimbs) for (let i = 0; i < body.limbs; i++) names.push(`${name}.${i}`);
    this.ofLimbs = ofLimbs;
    this.history = new History(names, Math.round(REMEMBERED_S / (FRAME_TICKS * TICK_S)));
    this.values = Object.fromEntries(names.map((name) => [name, 0]));
    this.steer(controller);
  }

  // Another controller of the same structure: its weights are data.
  steer(controller) {
    this.controller = controller;
    this.weights = Float32Array.from(controller.weights);
  }

  // Put the world's numbers in place. They count from the next tick on.
  meet(world) {
    const { lane } = this;
    const weights = Float32Array.from(this.weights);
    if (this.controller.sigma !== null) weights[this.controller.sigma] *= world.sigma;
    lane.set("weights", weights);
    lane.set("omega", world.omega ?? this.controller.omega ?? 0);
    lane.set("moving", world.frozen ? 0 : 1);
    lane.set("ground_m", world.ground);
    lane.set("tick_s", TICK_S);
    for (const [name, value] of Object.entries(world.numbers)) lane.set(`body.${name}`, value);
    if (lane.has("body.present")) lane.set("body.present", world.present);
  }

  release(world) {
    this.meet(world);
    for (const name of this.body.pose_names) this.lane.set(`release.${name}`, 0);
    this.lane.set("release.height_m", world.height);
    this.lane.set("release.velocity_m_per_s", 0);
    this.lane.set("release.phase_rad", world.phases.slice(0, this.body.limbs));
    this.lane.release();
    this.history.clear();
    this.hops.clear();
    this.remember();
  }

  advance(ticks) {
    for (let left = ticks; left > 0; left -= FRAME_TICKS) {
      this.lane.advance(Math.min(left, FRAME_TICKS));
      this.hops.hear(this.lane);
      this.remember();
    }
  }

  remember() {
    const { lane, values } = this;
    for (const name of OF_BODY) values[name] = lane.get(`channel.${name}`);
    for (const name of this.ofLimbs)
      for (let i = 0; i < this.body.limbs; i++) values[`${name}.${i}`] = lane.get(`channel.${name}`, i);
    this.history.add(values);
  }

  // An impulse that changes the body's velocity by so much [m/s]; under a frame it acts on the
  // first hip, and so turns the frame, too.
  push(speed) {
    const state = "state.lane.moment.body.";
    if (this.body.turns.length === 0) {
      this.lane.set(`${state}velocity`, this.lane.get(`${state}velocity`) + speed);
      return;
    }
    const rates = [this.lane.get(`${state}rate`, 0) + speed];
    this.body.turns.forEach((turn, i) => {
      const ratio = this.lane.get(`body.${turn.ratio}`);
      const kick = (speed * turn.arms_m[0]) / (ratio * turn.reach_m ** 2);
      rates.push(this.lane.get(`${state}rate`, i + 1) + kick);
    });
    this.lane.set(`${state}rate`, rates);
  }

  get time() {
    return this.lane.get("channel.time_s");
  }

  get failed() {
    return this.lane.get("channel.failed") > 0.5;
  }

  // Heights of the hips over the ground at rest, and how the frame stands.
  get pose() {
    const angles = this.body.turns.map((turn) => this.lane.get(`channel.${turn.name}_rad`));
    const height = this.lane.get("channel.height_m");
    const hips = this.body.hips.map((_, leg) =>
      this.body.turns.reduce((y, turn, i) => y + turn.arms_m[leg] * angles[i], height));
    return { height, angles, hips, ground: this.lane.get("channel.ground_m") };
  }
}
