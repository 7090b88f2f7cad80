// CoT⁻¹ + ΔΩ over the settled part of an episode: `tegotae.measures.objectives.fitness`, for one lane.

import { cotInverse, isHop } from "../measures.js";
import { peak, spectrum } from "./spectrum.js";

const NAMES = [
  "time_s", "height_m", "ground_m", "apex_height_m", "climb_flight_m", "climb_m", "work_absolute_j", "failed",
];

// Roll out an episode and judge it. `lane` has weights, body, frequency and release in place.
export function episode(lane, timing, definitions) {
  const ticks = Math.round(timing.frame_s / timing.tick_s);
  const frames = Math.round(timing.duration_s / timing.frame_s);
  const record = Object.fromEntries(NAMES.map((name) => [name, new Float32Array(frames)]));
  lane.set("tick_s", timing.tick_s);
  lane.release();
  for (let at = 0; at < frames; at++) {
    lane.advance(ticks);
    for (const name of NAMES) record[name][at] = lane.get(`channel.${name}`);
    // A lane that has failed stands still; nothing more is to be seen of it.
    if (record.failed[at] > 0.5) return fallen(at / frames, definitions);
  }
  return judged(record, lane.get("omega"), lane.get("body.rest_length_m"), timing, definitions);
}

function fallen(survived, definitions) {
  return { fitness: definitions.failed_fitness + survived, cotInverse: 0, deltaOmega: 0, failed: true };
}

// Fitness and its parts of a record that did not fail.
export function judged(record, omega, rest, timing, definitions) {
  const first = Math.round(timing.settle_s / timing.frame_s);
  const frames = record.time_s.length;
  const hops = [];
  for (let i = first; i < frames; i++)
    if (isHop(record.apex_height_m[i], rest, record.ground_m[i], definitions)) hops.push(i);
  const whole = hops.length - 1;
  const [begin, end] = [hops[whole > 2 && whole % 2 === 1 ? 1 : 0], hops.at(-1)];
  const over = (total) => total[end] - total[begin];
  const goesOn = whole >= 0 && record.time_s[end] >= (1 - definitions.rest_share) * timing.duration_s;
  const cot = goesOn ? cotInverse(over(record.climb_flight_m), over(record.work_absolute_j)) : 0;
  const gap = definitions.follow_omega ? deltaOmega(record.height_m.subarray(first), omega, timing, definitions) : 0;
  const fitness = cot + gap + definitions.tie_break * Math.tanh(record.climb_m[frames - 1]);
  return { fitness, cotInverse: cot, deltaOmega: gap, failed: false };
}

// ΔΩ = -(ω - w_peak)² - (1 - A_peak)²; a body at rest has no peak.
function deltaOmega(height, omega, timing, definitions) {
  let [least, most] = [Infinity, -Infinity];
  for (const y of height) [least, most] = [Math.min(least, y), Math.max(most, y)];
  if (most - least < definitions.rest_range_m) return -(omega ** 2) - 1;
  const { stride } = definitions;
  const thinned = height.filter((_, i) => i % stride === 0);
  const { frequency, share } = peak(spectrum(thinned, stride * timing.frame_s), definitions.lobe_bins);
  return -((omega - frequency) ** 2) - (1 - share) ** 2;
}
