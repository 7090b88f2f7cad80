// PGPE with antithetic pairs, centred ranks and ClipUp: the update of
// `tegotae.training.algorithms.PGPE` (through evosax), which minimises; it is handed -fitness.

export class Search {
  // weights: where it begins; settings: those of the package's PGPE, by the same names.
  constructor(weights, settings) {
    this.settings = settings;
    this.mean = Float64Array.from(weights);
    this.std = new Float64Array(weights.length).fill(settings.std);
    this.velocity = new Float64Array(weights.length);
  }

  // Samples mean ± std·z, the pluses first. `normal` gives normal random numbers.
  ask(normal) {
    const half = this.settings.population / 2;
    const z = Array.from({ length: half }, () => Float64Array.from(this.mean, () => normal()));
    const sample = (sign) => (row) => this.mean.map((x, i) => x + sign * this.std[i] * row[i]);
    return [...z.map(sample(1)), ...z.map(sample(-1))];
  }

  // Move on, given the fitness of the samples of `ask`: the larger, the better.
  tell(samples, fitness) {
    const { population, std_lr, std_max_change, learning_rate, max_speed, momentum } = this.settings;
    const half = population / 2;
    const rank = centredRanks(fitness.map((x) => -x));
    const average = rank.reduce((a, b) => a + b, 0) / population;
    const slope = this.mean.map((mean, i) => {
      let sum = 0;
      for (let k = 0; k < half; k++) sum += (rank[k] - rank[k + half]) * (samples[k][i] - mean);
      return sum / population;
    });
    const wider = this.std.map((std, i) => {
      let sum = 0;
      for (let k = 0; k < half; k++) {
        const apart = samples[k][i] - this.mean[i];
        sum += ((rank[k] + rank[k + half] - 2 * average) * (apart * apart - std * std)) / std;
      }
      return sum / population;
    });
    // ClipUp: a step of one length, with momentum, no faster than the largest speed.
    const length = Math.hypot(...slope) + 1e-8;
    this.velocity = this.velocity.map((v, i) => momentum * v + slope[i] / length);
    const speed = Math.hypot(...this.velocity);
    const most = max_speed / learning_rate;
    if (speed > most) this.velocity = this.velocity.map((v) => (v * most) / speed);
    this.mean = this.mean.map((x, i) => x - learning_rate * this.velocity[i]);
    this.std = this.std.map((std, i) => {
      const change = Math.max(-std_max_change, Math.min(std_max_change, (-std_lr * wider[i]) / std));
      return std * (1 + change);
    });
  }
}

// Ranks in -½ ... ½; equals share theirs, and what is no number is the worst.
export function centredRanks(values) {
  const known = values.map((x) => (Number.isNaN(x) ? Infinity : x));
  const order = known.map((_, i) => i).sort((a, b) => known[a] - known[b] || a - b);
  const ranks = new Float64Array(known.length);
  for (let first = 0; first < order.length; ) {
    let last = first;
    while (last + 1 < order.length && known[order[last + 1]] === known[order[first]]) last++;
    for (let i = first; i <= last; i++) ranks[order[i]] = (first + last) / 2;
    first = last + 1;
  }
  return Array.from(ranks, (rank) => rank / (known.length - 1) - 0.5);
}
