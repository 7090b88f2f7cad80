// The actuation surface, and the path of the last seconds on it.

import { FRAME_TICKS, TICK_S } from "../runner.js";
import { Axes, legColour } from "./canvas.js";

const [COLUMNS, ROWS] = [90, 40];
const SHOWN = Math.round(2 / (FRAME_TICKS * TICK_S));
const SPEEDS = [-6, 6];

// Viridis, whose lightness grows with the value.
const MAP = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];

function shade(share) {
  const at = Math.max(0, Math.min(1, share)) * (MAP.length - 1);
  const low = Math.min(Math.floor(at), MAP.length - 2);
  return MAP[low].map((x, i) => x + (at - low) * (MAP[low + 1][i] - x));
}

export class Surface {
  constructor() {
    this.image = document.createElement("canvas");
    [this.image.width, this.image.height] = [COLUMNS, ROWS];
    this.pixels = new ImageData(COLUMNS, ROWS);
    this.most = 2;
    this.stale = true;
  }

  // Compute it anew at the next drawing: weights, numbers or body have changed.
  change() {
    this.stale = true;
  }

  paint(runner) {
    const { lane, controller } = runner;
    const alpha = lane.get("body.max_force_n");
    for (let row = 0; row < ROWS; row++) {
      const spring = ((ROWS - row - 0.5) / ROWS) * this.most;
      for (let column = 0; column < COLUMNS; column++) {
        const share = (column + 0.5) / COLUMNS;
        const force = controller.rhythm
          ? lane.surface(2 * Math.PI * share, spring)
          : lane.surface(0, spring, SPEEDS[0] + share * (SPEEDS[1] - SPEEDS[0]));
        this.pixels.data.set([...shade(force / alpha), 255], 4 * (row * COLUMNS + column));
      }
    }
    this.image.getContext("2d").putImageData(this.pixels, 0, 0);
    this.stale = false;
  }

  draw(canvas, runner, colours) {
    const felt = Math.min(SHOWN, runner.history.length);
    let most = 0;
    for (let back = 0; back < felt; back++)
      for (let leg = 0; leg < runner.body.limbs; leg++) most = Math.max(most, runner.history.ago(`spring_force_n.${leg}`, back));
    const weight = runner.lane.get("body.mass_kg") * runner.lane.get("body.gravity_m_per_s2");
    const step = 10 ** Math.floor(Math.log10(1.1 * weight));
    if (most > this.most || most < this.most - 2 * step) {
      this.most = step * Math.max(2, Math.ceil(most / step));
      this.stale = true;
    }
    if (this.stale) this.paint(runner);
    const c = canvas.begin();
    const rhythm = runner.controller.rhythm;
    const axes = new Axes(canvas, rhythm ? [0, 2 * Math.PI] : SPEEDS, [0, this.most]);
    c.imageSmoothingEnabled = true;
    c.drawImage(this.image, axes.margin.left, axes.margin.top, axes.inner.width, axes.inner.height);
    const xTicks = rhythm ? [[0, "0"], [Math.PI, "π"], [2 * Math.PI, "2π"]] : [[-6, "-6"], [0, "0"], [6, "6 m/s"]];
    axes.draw(c, colours, { xTicks, yTicks: [[0, "0"], [this.most, `${Number(this.most.toPrecision(3))} N`]] });
    c.save();
    c.beginPath();
    c.rect(axes.margin.left, 0, axes.inner.width, canvas.height);
    c.clip();
    for (let leg = 0; leg < runner.body.limbs; leg++) this.path(c, axes, runner, leg, felt, colours);
    c.restore();
  }

  path(c, axes, runner, leg, felt, colours) {
    const { history } = runner;
    // Where a leg without an oscillator is: at its hip's velocity, which of one leg is the body's.
    const along = runner.controller.rhythm ? `phase_rad.${leg}` : "velocity_m_per_s";
    const at = (back) => [
      axes.left(history.ago(along, back)),
      axes.top(history.ago(`spring_force_n.${leg}`, back)),
    ];
    for (const [width, colour] of [[4, "#ffffff"], [2, runner.body.limbs > 1 ? legColour(colours, leg) : "#000000"]]) {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      let before = null;
      for (let back = felt - 1; back >= 0; back--) {
        const [x, y] = at(back);
        // A phase that begins anew is no line across the picture.
        if (before !== null && Math.abs(x - before) < axes.inner.width / 2) c.lineTo(x, y);
        else c.moveTo(x, y);
        before = x;
      }
      c.stroke();
    }
    const [x, y] = at(0);
    c.beginPath();
    c.arc(x, y, 5, 0, 2 * Math.PI);
    c.fillStyle = legColour(colours, leg);
    c.fill();
    c.strokeStyle = "#ffffff";
    c.lineWidth = 2;
    c.stroke();
  }
}
