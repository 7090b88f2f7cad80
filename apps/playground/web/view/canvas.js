// A canvas that is as sharp as the screen, and the colours of the page.

export class Canvas {
  constructor(element) {
    this.element = element;
    this.context = element.getContext("2d");
    [this.width, this.height] = [0, 0];
    new ResizeObserver(() => this.measure()).observe(element);
    this.measure();
  }

  measure() {
    const sharp = Math.min(window.devicePixelRatio || 1, 2);
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === this.width && clientHeight === this.height && sharp === this.sharp) return;
    [this.width, this.height, this.sharp] = [clientWidth, clientHeight, sharp];
    this.element.width = Math.round(clientWidth * sharp);
    this.element.height = Math.round(clientHeight * sharp);
  }

  // A cleared context in CSS pixels.
  begin() {
    this.context.setTransform(this.sharp, 0, 0, this.sharp, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    this.context.font = "12px system-ui, sans-serif";
    this.context.lineJoin = "round";
    return this.context;
  }
}

const NAMES = ["paper", "card", "ink", "soft", "line", "accent", "force", "ground", "shade"];

export function readColours() {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(`--${name}`).trim();
  const colours = Object.fromEntries(NAMES.map((name) => [name, colour(name)]));
  return { ...colours, legs: [0, 1, 2, 3].map((i) => colour(`leg-${i}`)) };
}

export function legColour(colours, leg) {
  return colours.legs[leg % colours.legs.length];
}

// The frame of a plot: from numbers to places, and labels at the ends of its axes.
export class Axes {
  constructor(canvas, x, y, margin = { left: 30, right: 12, top: 8, bottom: 18 }) {
    Object.assign(this, { x, y, margin });
    this.inner = { width: canvas.width - margin.left - margin.right, height: canvas.height - margin.top - margin.bottom };
  }

  left(value) {
    return this.margin.left + ((value - this.x[0]) / (this.x[1] - this.x[0])) * this.inner.width;
  }

  top(value) {
    return this.margin.top + (1 - (value - this.y[0]) / (this.y[1] - this.y[0])) * this.inner.height;
  }

  draw(c, colours, { xTicks, yTicks, xLabel = "", yLabel = "" }) {
    const bottom = this.margin.top + this.inner.height;
    c.strokeStyle = colours.line;
    c.lineWidth = 1;
    c.strokeRect(this.margin.left, this.margin.top, this.inner.width, this.inner.height);
    c.fillStyle = colours.soft;
    c.textBaseline = "top";
    for (const [value, text] of xTicks) {
      c.textAlign = "center";
      c.fillText(text, this.left(value), bottom + 3);
    }
    c.textAlign = "center";
    c.fillText(xLabel, this.margin.left + this.inner.width / 2, bottom + 3);
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const [value, text] of yTicks) c.fillText(text, this.margin.left - 4, this.top(value));
    if (!yLabel) return;
    c.textAlign = "left";
    c.textBaseline = "top";
    c.fillText(yLabel, this.margin.left + 4, this.margin.top + 3);
  }
}
