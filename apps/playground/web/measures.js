// What is measured of a gait as it goes: hops, what they cost, and how legs keep time.

// Definitions of the package, which Python puts into the page: see `tegotae.measures.hopping`.
export function isHop(apex, rest, ground, definitions) {
  return apex >= (1 + definitions.hop_clearance) * rest + ground;
}

// Climbed height over work [m/J]; zero where nothing was climbed or no work was done.
export function cotInverse(climb, work) {
  return climb > 0 && work > 1e-6 ? climb / work : 0;
}

const KEPT = 40;

// The last hops of a lane, told frame by frame.
export class Hops {
  constructor(definitions) {
    this.definitions = definitions;
    this.list = [];
  }

  clear() {
    this.list.length = 0;
  }

  // A lane at the end of a frame: at an apex nothing is climbed and no work is done, so that totals
  // at the end of its frame are those at the apex.
  hear(lane) {
    this.now = lane.get("channel.time_s");
    const height = lane.get("channel.apex_height_m");
    const ground = lane.get("channel.ground_m");
    if (!isHop(height, lane.get("body.rest_length_m"), ground, this.definitions)) return;
    this.list.push({
      time: lane.get("channel.apex_time_s"),
      height: height - ground,
      climb: lane.get("channel.climb_flight_m"),
      work: lane.get("channel.work_absolute_j"),
    });
    if (this.list.length > KEPT) this.list.shift();
  }

  // CoT⁻¹ over the last whole hops, an even number of them: a gait may alternate between two. Zero
  // for a gait that is over.
  cost(most = 8) {
    if (this.rests(this.now)) return 0;
    const whole = Math.min(this.list.length - 1, most);
    const count = whole > 2 ? whole - (whole % 2) : whole;
    if (count < 1) return 0;
    const [begin, end] = [this.list.at(-1 - count), this.list.at(-1)];
    return cotInverse(end.climb - begin.climb, end.work - begin.work);
  }

  // Angular frequency of hops [rad/s] over the same; 0 without two.
  rate(most = 8) {
    const count = Math.min(this.list.length - 1, most);
    if (count < 1) return 0;
    return (2 * Math.PI * count) / (this.list.at(-1).time - this.list.at(-1 - count).time);
  }

  // A gait is over when nothing was climbed for a while.
  rests(time, patience = 3) {
    return time - (this.list.at(-1)?.time ?? 0) > patience;
  }
}

// An angle in (-π, π].
export function turned(angle) {
  const whole = 2 * Math.PI;
  const rest = ((angle % whole) + whole) % whole;
  return rest > Math.PI ? rest - whole : rest;
}
