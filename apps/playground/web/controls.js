// Sliders for numbers, and boxes for legs.

const PLAIN = {
  mass_kg: ["mass a leg [kg]", 0.05, 0.25, 0.005],
  stiffness_n_per_m: ["stiffness k [N/m]", 2, 15, 0.25],
  leg_friction_n: ["dry friction of the leg [N]", 0, 0.5, 0.01],
  gravity_m_per_s2: ["gravity g [m/s²]", 1.6, 15, 0.1],
  inertia_ratio: ["inertia ratio j", 0.3, 2.5, 0.05],
  pitch_inertia_ratio: ["pitch inertia j_p", 0.3, 2.5, 0.05],
  roll_inertia_ratio: ["roll inertia j_r", 0.3, 2.5, 0.05],
  twist_inertia_ratio: ["twist inertia j_t", 0.3, 2.5, 0.05],
};

const OMEGA = ["frequency ω [rad/s]", 2, 14, 0.1];
const SIGMA = ["gain σ, times its own", 0, 4, 0.05];

// A number within the range of its slider; of one without a slider, null.
export function within(name, value) {
  const about = { omega: OMEGA, sigma: SIGMA, ...PLAIN }[name];
  return about ? Math.min(Math.max(value, about[1]), about[2]) : null;
}

// One labelled slider; `show` says what the number is in words.
export function slider(name, [label, least, most, step], value, show, changed) {
  const row = document.createElement("div");
  row.className = "number";
  const text = document.createElement("label");
  text.textContent = label;
  const input = document.createElement("input");
  Object.assign(input, { type: "range", id: `number-${name}`, min: String(Math.min(least, value)), max: String(Math.max(most, value)), step: String(step) });
  input.value = String(value);
  text.htmlFor = input.id;
  const output = document.createElement("output");
  output.htmlFor.add(input.id);
  const say = (x) => {
    output.textContent = show(x);
    input.setAttribute("aria-valuetext", show(x));
  };
  say(value);
  input.addEventListener("input", () => {
    changed(Number(input.value));
    say(Number(input.value));
  });
  row.append(text, input, output);
  return row;
}

// The sliders of a world; `changed` is called when one was moved.
export function numberSliders(world, usual, changed) {
  const round = (x) => String(Number(x.toPrecision(3)));
  const rows = [
    slider("omega", OMEGA, world.omega ?? usual ?? 8, (x) => (world.omega === null ? "own" : round(x)), (x) => {
      world.omega = x;
      changed();
    }),
    slider("sigma", SIGMA, world.sigma, round, (x) => {
      world.sigma = x;
      changed();
    }),
  ];
  for (const [name, about] of Object.entries(PLAIN)) {
    if (!(name in world.numbers)) continue;
    rows.push(slider(name, about, world.numbers[name], round, (x) => {
      world.numbers[name] = x;
      changed();
    }));
  }
  return rows;
}

// A box for each leg that can be lost; one has to stay.
export function legBoxes(world, changed) {
  return world.body.legs.map((leg, i) => {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.id = `leg-${leg}`;
    box.checked = world.present[i] > 0.5;
    box.addEventListener("change", () => {
      world.present[i] = box.checked ? 1 : 0;
      if (world.present.some((x) => x > 0.5)) return changed();
      world.present[i] = 1;
      box.checked = true;
    });
    label.append(box, leg);
    return label;
  });
}
