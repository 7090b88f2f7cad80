// Forces over time, the apex map, the lags of legs, and the curve of learning.

import { turned } from "../measures.js";
import { FRAME_TICKS, TICK_S } from "../runner.js";
import { Axes, legColour } from "./canvas.js";

const FRAME_S = FRAME_TICKS * TICK_S;
const SHOWN_S = 4;

// Spring force (filled) and actuator force (line) of every leg, a row each.
export function drawForces(canvas, runner, colours) {
  const c = canvas.begin();
  const { history, body } = runner;
  const count = Math.min(history.length, Math.round(SHOWN_S / FRAME_S));
  const rows = body.limbs;
  let most = runner.lane.get("body.max_force_n");
  for (let leg = 0; leg < rows; leg++)
    for (let back = 0; back < count; back++) most = Math.max(most, history.ago(`spring_force_n.${leg}`, back));
  const margin = { left: 30, right: 8, top: 6, bottom: 4 };
  const height = (canvas.height - margin.top - margin.bottom) / rows;
  for (let leg = 0; leg < rows; leg++) {
    const base = margin.top + (leg + 1) * height - 2;
    const left = (back) => canvas.width - margin.right - (back * FRAME_S * (canvas.width - margin.left - margin.right)) / SHOWN_S;
    const top = (force) => base - (force / most) * (height - 5);
    const path = (name) => {
      for (let back = count - 1; back >= 0; back--) c.lineTo(left(back), top(history.ago(`${name}.${leg}`, back)));
    };
    c.fillStyle = legColour(colours, leg);
    c.globalAlpha = 0.45;
    c.beginPath();
    c.moveTo(left(count - 1), base);
    path("spring_force_n");
    c.lineTo(left(0), base);
    c.fill();
    c.globalAlpha = 1;
    c.strokeStyle = colours.force;
    c.lineWidth = 1.6;
    c.beginPath();
    path("actuator_force_n");
    c.stroke();
    c.strokeStyle = colours.line;
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(margin.left, base);
    c.lineTo(canvas.width - margin.right, base);
    c.stroke();
    c.fillStyle = colours.soft;
    c.textAlign = "right";
    c.textBaseline = "middle";
    c.fillText(body.legs[leg] || "0", margin.left - 4, rows > 1 ? base - height / 2 : base - 3);
    if (rows === 1) c.fillText(most.toFixed(1).replace(".0", ""), margin.left - 4, top(most) + 6);
  }
}

// The height of each apex over that of the one before.
export function drawApexMap(canvas, runner, colours) {
  const c = canvas.begin();
  const hops = runner.hops.list.slice(-20);
  const rest = runner.lane.get("body.rest_length_m");
  const most = Math.max(1.6 * rest, ...hops.map((hop) => Math.ceil(hop.height * 5) / 5));
  const axes = new Axes(canvas, [rest, most], [rest, most], { left: 30, right: 14, top: 8, bottom: 18 });
  const ends = [[rest, `${rest}`], [most, most.toFixed(1)]];
  axes.draw(c, colours, { xTicks: ends, yTicks: ends, xLabel: "apex n [m]", yLabel: "apex n + 1 [m]" });
  c.strokeStyle = colours.soft;
  c.setLineDash([4, 4]);
  c.beginPath();
  c.moveTo(axes.left(rest), axes.top(rest));
  c.lineTo(axes.left(most), axes.top(most));
  c.stroke();
  c.setLineDash([]);
  c.fillStyle = colours.accent;
  for (let i = 1; i < hops.length; i++) {
    const last = i === hops.length - 1;
    c.globalAlpha = last ? 1 : 0.15 + (0.45 * i) / hops.length;
    c.beginPath();
    c.arc(axes.left(hops[i - 1].height), axes.top(hops[i].height), last ? 6 : 4, 0, 2 * Math.PI);
    c.fill();
  }
  c.globalAlpha = 1;
}

const LAGS = [-0.25, 0.75]; // so that neither legs in phase nor legs in antiphase are at an edge

// How far each leg is behind the first over the last seconds, in turns.
export function drawLags(canvas, runner, colours) {
  const c = canvas.begin();
  const { history, body } = runner;
  const axes = new Axes(canvas, [-SHOWN_S, 0], LAGS);
  c.strokeStyle = colours.line;
  for (const lag of [0, 0.5]) {
    c.beginPath();
    c.moveTo(axes.left(-SHOWN_S), axes.top(lag));
    c.lineTo(axes.left(0), axes.top(lag));
    c.stroke();
  }
  axes.draw(c, colours, { xTicks: [[-SHOWN_S, ""], [0, ""]], yTicks: [[0, "0"], [0.5, "½"]], xLabel: `last ${SHOWN_S} s` });
  const count = Math.min(history.length, Math.round(SHOWN_S / FRAME_S));
  for (let leg = 1; leg < body.limbs; leg++) {
    c.fillStyle = legColour(colours, leg);
    for (let back = count - 1; back >= 0; back -= 4) {
      const apart = history.ago("phase_rad.0", back) - history.ago(`phase_rad.${leg}`, back);
      const lag = 0.25 + turned(apart - Math.PI / 2) / (2 * Math.PI);
      c.fillRect(axes.left(-back * FRAME_S) - 1.5, axes.top(lag) - 1.5, 3, 3);
    }
  }
}

const LOWEST = -1;

// Fitness of the distribution's mean by generation, its best so far, and what is known to be possible.
export function drawCurve(canvas, curve, optimum, colours) {
  const c = canvas.begin();
  const generations = Math.max(20, curve.length);
  const most = Math.max(0.6, (optimum ?? 0) * 1.15, ...curve.map((each) => each.fitness * 1.1));
  const axes = new Axes(canvas, [0, generations], [LOWEST, most], { left: 34, right: 8, top: 8, bottom: 20 });
  const yTicks = [[LOWEST, `≤ ${LOWEST}`], [0, "0"], [Math.floor(2 * most) / 2, String(Math.floor(2 * most) / 2)]];
  axes.draw(c, colours, { xTicks: [[0, "0"], [generations, `${generations}`]], yTicks, xLabel: "generation", yLabel: curve.length || optimum ? "" : "fitness" });
  if (optimum) {
    c.strokeStyle = colours.soft;
    c.setLineDash([5, 4]);
    c.beginPath();
    c.moveTo(axes.left(0), axes.top(optimum));
    c.lineTo(axes.left(generations), axes.top(optimum));
    c.stroke();
    c.setLineDash([]);
    c.fillStyle = colours.soft;
    c.textAlign = "left";
    c.textBaseline = "bottom";
    c.fillText(`best gait known at this ω: ${optimum.toFixed(2)} m/J`, axes.left(0) + 5, axes.top(optimum) - 3);
  }
  const top = (fitness) => axes.top(Math.max(LOWEST, fitness));
  c.fillStyle = colours.soft;
  curve.forEach(({ generation, fitness }) => c.fillRect(axes.left(generation) - 1.5, top(fitness) - 1.5, 3, 3));
  c.strokeStyle = colours.accent;
  c.lineWidth = 2;
  c.beginPath();
  curve.forEach(({ generation, best }) => c.lineTo(axes.left(generation), top(best.fitness)));
  c.stroke();
}
