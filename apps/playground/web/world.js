// What happens to both sides alike: the body's numbers, what was done to it, how it is released.

const CLEARANCE = 0.2; // of the leg

export class World {
  constructor(body, seed = 1) {
    this.seed = seed;
    this.takeBody(body);
  }

  takeBody(body) {
    this.body = body;
    this.usual();
    this.mend();
  }

  // Numbers as they were; each controller at its own frequency.
  usual() {
    this.numbers = { ...this.body.numbers };
    this.omega = null;
    this.sigma = 1;
  }

  // Everything in place for a release.
  mend() {
    this.ground = 0;
    this.frozen = false;
    this.present = new Array(this.body.limbs).fill(1);
  }

  get height() {
    return (1 + CLEARANCE) * this.numbers.rest_length_m;
  }

  // Phases at the release: 0 for the first leg; those of others tell nothing of what will come.
  get phases() {
    return this.body.hips.map((_, leg) => (leg === 0 ? 0 : (leg * this.seed * 2.399963) % (2 * Math.PI)));
  }
}
