// The last seconds of some numbers: rings of fixed size, so that memory does not grow.

export class History {
  constructor(names, size) {
    this.size = size;
    this.rings = Object.fromEntries(names.map((name) => [name, new Float32Array(size)]));
    this.clear();
  }

  clear() {
    this.length = 0;
    this.next = 0;
  }

  add(values) {
    for (const name in this.rings) this.rings[name][this.next] = values[name];
    this.next = (this.next + 1) % this.size;
    this.length = Math.min(this.length + 1, this.size);
  }

  // The value so many entries ago; 0 is the last one.
  ago(name, back) {
    return this.rings[name][(this.next - 1 - back + 2 * this.size) % this.size];
  }
}
