// The state of the page as a link: body, controllers, numbers, legs that are cut, and the release.

import { within } from "./controls.js";

// What stands behind the # of a link. labels: of the controllers on the left and on the right.
export function linked(world, labels, two, speed) {
  const words = new URLSearchParams({ body: world.body.name, left: labels[0], right: labels[1] });
  words.set("two", two ? "1" : "0");
  words.set("speed", String(speed));
  if (world.omega !== null) words.set("omega", String(world.omega));
  if (world.sigma !== 1) words.set("sigma", String(world.sigma));
  for (const [name, value] of Object.entries(world.numbers)) {
    if (value !== world.body.numbers[name]) words.set(name, String(value));
  }
  const cut = (world.body.legs ?? []).filter((_, i) => world.present[i] < 0.5);
  if (cut.length) words.set("cut", cut.join(","));
  if (world.frozen) words.set("frozen", "1");
  if (world.seed !== 1) words.set("seed", String(world.seed));
  return words.toString();
}

// Numbers of a link, put into a world of its body; those out of a slider's range are moved into it.
export function numbersOf(link, world) {
  const number = (name) => (link.has(name) && Number.isFinite(Number(link.get(name))) ? within(name, Number(link.get(name))) : null);
  world.omega = number("omega");
  world.sigma = number("sigma") ?? 1;
  for (const name of Object.keys(world.numbers)) world.numbers[name] = number(name) ?? world.numbers[name];
  const seed = Number(link.get("seed") ?? 1);
  world.seed = Number.isInteger(seed) && seed > 0 && seed < 1e6 ? seed : 1;
}

// What was done to the body of a link; one leg has to stay.
export function doneOf(link, world) {
  const cut = (link.get("cut") ?? "").split(",");
  const present = (world.body.legs ?? []).map((leg) => (cut.includes(leg) ? 0 : 1));
  if (present.some((x) => x > 0.5)) world.present = present;
  world.frozen = link.get("frozen") === "1";
}
