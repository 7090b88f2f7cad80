// The package's closed loop, compiled: a program, and lanes of numbers on which it works.

const WORD = 4;
const PAGE = 65536;

const MATHS = [
  "expf", "exp2f", "expm1f", "logf", "log1pf", "sinf", "cosf", "tanf", "asinf", "acosf", "atanf",
  "sinhf", "coshf", "tanhf", "asinhf", "acoshf", "atanhf", "erff", "cbrtf", "atan2f", "fmodf", "powf",
];

// Functions that WebAssembly has no instruction for, lent to the program.
function lent() {
  const own = { exp2f: (x) => 2 ** x, fmodf: (x, y) => x % y, erff: erf };
  return Object.fromEntries(MATHS.map((name) => [name, own[name] || Math[name.slice(0, -1)]]));
}

// Abramowitz and Stegun 7.1.26, to 1.5e-7.
function erf(x) {
  const t = 1 / (1 + 0.3275911 * Math.abs(x));
  const series = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
  return Math.sign(x) * (1 - series * Math.exp(-x * x));
}

// The bytes of a gzipped text in base64.
export async function unpacked(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export class Engine {
  // bytes: of the WebAssembly; layout: by name where in a lane a number begins, and how many there are.
  static async of(bytes, layout) {
    const { instance } = await WebAssembly.instantiate(bytes, { maths: lent() });
    return new Engine(instance.exports, layout);
  }

  constructor(program, layout) {
    this.program = program;
    this.layout = layout;
    this.words = Math.max(...Object.values(layout).map(([first, count]) => first + count));
    this.top = Math.ceil(program.__heap_base.value / 16) * 16;
    this.floats = new Float32Array(0);
  }

  // A new lane. Lanes are never given back: take as many as are needed, and use them again.
  lane() {
    const at = this.top;
    this.top += Math.ceil((this.words * WORD) / 16) * 16;
    const memory = this.program.memory;
    const missing = this.top - memory.buffer.byteLength;
    if (missing > 0) memory.grow(Math.ceil(missing / PAGE));
    this.floats = new Float32Array(memory.buffer);
    return new Lane(this, at);
  }
}

export class Lane {
  constructor(engine, at) {
    this.engine = engine;
    this.at = at;
    this.limbs = engine.layout.omega[1];
    this.set("tick_s", 0.001);
    this.set("moving", 1);
  }

  has(name) {
    return name in this.engine.layout;
  }

  // A number of the lane; of several limbs that of the one asked for.
  get(name, index = 0) {
    return this.engine.floats[this.at / WORD + this.engine.layout[name][0] + index];
  }

  // One number for all of an entry, or a list with one for each.
  set(name, value) {
    const [first, count] = this.engine.layout[name];
    const from = this.at / WORD + first;
    if (typeof value === "number") this.engine.floats.fill(value, from, from + count);
    else this.engine.floats.set(value, from);
  }

  release() {
    this.engine.program.release(this.at);
  }

  // A frame of so many control ticks; its channels can be read then.
  advance(ticks) {
    this.engine.program.advance(this.at, ticks);
  }

  // The force of the first leg at a point of the actuation surface [N].
  surface(phase, spring, velocity = 0) {
    return this.engine.program.surface(this.at, phase, spring, velocity);
  }
}
