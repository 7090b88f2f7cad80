// The body on its legs, seen from the side; a plate from a little above.

import { legColour } from "./canvas.js";

const ACROSS = [0.5, 0.24]; // where what is a metre to the left is drawn: back and up
const COILS = 7;

// How much is to be seen for the last hops not to leave the picture [m].
export function wanted(runner) {
  const rest = runner.lane.get("body.rest_length_m");
  const usual = (runner.body.limbs > 1 ? 2.45 : 2.15) * rest;
  return Math.max(usual, ...runner.hops.list.slice(-4).map((hop) => hop.height + 0.45 * rest));
}

// camera: the height at the bottom of the picture, and how much of it is seen [m].
export function drawBody(canvas, runner, colours, camera) {
  const c = canvas.begin();
  const { pose, body, lane } = runner;
  const deep = body.hips.some(([, z]) => z !== 0);
  const rest = lane.get("body.rest_length_m");
  const span = Math.max(...body.hips.map(([x, z]) => Math.abs(x) + Math.abs(z) * ACROSS[0]), 0.5 * rest);
  const scale = Math.min(canvas.height / camera.seen, canvas.width / (2 * span + 1.2 * rest));
  const place = (x, z, y) => [
    canvas.width / 2 + (x - z * ACROSS[0]) * scale,
    canvas.height - 26 - (y - camera.ground + z * ACROSS[1]) * scale,
  ];
  drawGround(c, canvas, place, pose.ground, deep ? 0.6 * rest : 0, colours);
  drawRule(c, canvas, place, pose.ground, rest, colours);
  if (body.limbs === 1) drawTrail(c, runner, place, colours);
  const order = body.hips.map((_, i) => i).sort((a, b) => body.hips[b][1] - body.hips[a][1]);
  for (const leg of order) if (isThere(lane, leg)) drawLeg(c, leg, runner, rest, place, scale, colours);
  drawFrame(c, body, pose, place, rest * scale, colours);
}

function isThere(lane, leg) {
  return !lane.has("body.present") || lane.get("body.present", leg) > 0.5;
}

function drawGround(c, canvas, place, ground, depth, colours) {
  const [, near] = place(0, -depth, ground);
  const [, far] = place(0, depth, ground);
  c.fillStyle = colours.ground;
  c.globalAlpha = 0.35;
  c.fillRect(0, far, canvas.width, canvas.height - far);
  c.globalAlpha = 1;
  c.strokeStyle = colours.soft;
  c.lineWidth = 1.5;
  c.beginPath();
  c.moveTo(0, depth ? near : far);
  c.lineTo(canvas.width, depth ? near : far);
  c.stroke();
}

function drawRule(c, canvas, place, ground, rest, colours) {
  c.fillStyle = colours.soft;
  c.strokeStyle = colours.line;
  c.lineWidth = 1;
  c.textAlign = "left";
  c.textBaseline = "bottom";
  for (const height of [0.5, 1, 1.5, 2].map((share) => share * rest)) {
    const [, y] = place(0, 0, ground + height);
    c.beginPath();
    c.moveTo(0, y);
    c.lineTo(canvas.width, y);
    c.stroke();
    c.fillText(`${Number(height.toPrecision(3))} m`, 2, y - 1);
  }
}

function drawLeg(c, leg, runner, rest, place, scale, colours) {
  const [x, z] = runner.body.hips[leg];
  const hip = runner.pose.hips[leg];
  const foot = Math.max(runner.pose.ground, hip - rest);
  const [left, top] = place(x, z, hip);
  const [, bottom] = place(x, z, foot);
  const width = 0.055 * rest * scale;
  c.strokeStyle = legColour(colours, leg);
  c.lineWidth = 2.5;
  c.beginPath();
  c.moveTo(left, top);
  const from = top + 0.12 * (bottom - top);
  const to = bottom - 0.1 * (bottom - top);
  c.lineTo(left, from);
  for (let i = 0; i < 2 * COILS; i++) {
    c.lineTo(left + (i % 2 ? width : -width), from + ((i + 0.5) / (2 * COILS)) * (to - from));
  }
  c.lineTo(left, to);
  c.lineTo(left, bottom);
  c.stroke();
  c.beginPath();
  c.arc(left, bottom, 4, 0, 2 * Math.PI);
  c.fillStyle = legColour(colours, leg);
  c.fill();
  const push = runner.lane.get("channel.actuator_force_n", leg) / runner.lane.get("body.max_force_n");
  drawForce(c, left + 2.2 * width, bottom, 0.6 * rest * scale * push, colours);
}

// Where the mass was, as if the ground ran to the left: half a leg in a second.
function drawTrail(c, runner, place, colours) {
  const { history } = runner;
  const rest = runner.lane.get("body.rest_length_m");
  c.strokeStyle = colours.soft;
  c.globalAlpha = 0.45;
  c.lineWidth = 1.5;
  c.beginPath();
  for (let back = 0; back < history.length; back += 2) {
    const since = runner.time - history.ago("time_s", back);
    c.lineTo(...place(-0.5 * rest * since, 0, history.ago("height_m", back)));
  }
  c.stroke();
  c.globalAlpha = 1;
}

// The actuator's force as an arrow upwards from the foot, so high [px].
function drawForce(c, x, bottom, height, colours) {
  if (height < 1) return;
  const top = bottom - height;
  c.strokeStyle = c.fillStyle = colours.force;
  c.lineWidth = 3;
  c.beginPath();
  c.moveTo(x, bottom);
  c.lineTo(x, top + 5);
  c.stroke();
  c.beginPath();
  c.moveTo(x - 5, top + 6);
  c.lineTo(x, top - 2);
  c.lineTo(x + 5, top + 6);
  c.fill();
}

function drawFrame(c, body, pose, place, scale, colours) {
  c.fillStyle = colours.ink;
  c.strokeStyle = colours.ink;
  if (body.turns.length === 0) {
    const [x, y] = place(0, 0, pose.height);
    c.beginPath();
    c.arc(x, y, 0.11 * scale, 0, 2 * Math.PI);
    c.fill();
    return;
  }
  const corners = outline(body.hips).map((leg) => place(...body.hips[leg], pose.hips[leg]));
  c.lineWidth = body.turns.length > 1 ? 3 : 0.1 * scale;
  c.lineCap = "round";
  c.beginPath();
  corners.forEach(([x, y], i) => (i ? c.lineTo(x, y) : c.moveTo(x, y)));
  if (corners.length > 2) {
    c.closePath();
    c.globalAlpha = 0.28;
    c.fill();
    c.globalAlpha = 1;
  }
  c.stroke();
  c.lineCap = "butt";
  c.textAlign = "center";
  c.textBaseline = "bottom";
  body.hips.forEach((hip, leg) => {
    const [x, y] = place(...hip, pose.hips[leg]);
    c.fillStyle = colours.ink;
    c.fillText(body.legs[leg], x, y - 8);
  });
}

// The hips in the order in which a line goes round them.
function outline(hips) {
  const order = hips.map((_, i) => i);
  if (hips.every(([, z]) => z === 0)) return order;
  return order.sort((a, b) => Math.atan2(hips[a][1], hips[a][0]) - Math.atan2(hips[b][1], hips[b][0]));
}
