// Every oscillator's phase on a circle.

import { legColour } from "./canvas.js";

export function drawCircle(canvas, runner, colours) {
  const c = canvas.begin();
  const [x, y] = [canvas.width / 2, canvas.height / 2];
  const radius = Math.min(x - 30, y - 18);
  // The belief of the vanilla law: there is load where sin φ < 0. Canvases count angles downwards.
  c.fillStyle = colours.shade;
  c.beginPath();
  c.arc(x, y, radius, 0, Math.PI);
  c.fill();
  c.strokeStyle = colours.soft;
  c.lineWidth = 1.2;
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.stroke();
  c.fillStyle = colours.soft;
  c.textBaseline = "middle";
  c.textAlign = "left";
  c.fillText("0", x + radius + 13, y);
  c.textAlign = "right";
  c.fillText("π", x - radius - 13, y);
  if (!runner.controller.rhythm) {
    c.textAlign = "center";
    c.fillText("no oscillator", x, y);
    return;
  }
  for (let leg = 0; leg < runner.body.limbs; leg++) {
    const phase = runner.lane.get("channel.phase_rad", leg);
    const bears = runner.lane.get("channel.spring_force_n", leg) > 0;
    const [px, py] = [x + radius * Math.cos(phase), y - radius * Math.sin(phase)];
    c.strokeStyle = legColour(colours, leg);
    c.lineWidth = 3;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(px, py);
    c.globalAlpha = 0.35;
    c.stroke();
    c.globalAlpha = 1;
    c.beginPath();
    c.arc(px, py, 7, 0, 2 * Math.PI);
    c.fillStyle = bears ? legColour(colours, leg) : colours.card;
    c.fill();
    c.stroke();
  }
}
