// A tour in three steps: what to look at, what to try, and what to try next.

const STEPS = [
  {
    title: "See a gait",
    text: "The leg hops under the controller whose name is above it. The clock hand is the oscillator's phase φ; the orange arrow is the actuator's force. The coloured surface is the whole controller: the force at every phase and load. The line on it is the gait.",
    at: ".pane",
  },
  {
    title: "Disturb it",
    text: "Press Drop the ground, or d. Controllers that stand side by side meet the same drop. Watch how many hops each needs until its line on the surface closes again. Then freeze the oscillator: feedback cannot act any more.",
    at: "#drop",
  },
  {
    title: "Let it learn",
    text: "Press Learn, or l. It begins with random weights and tries 33 controllers a generation. The curve is the fitness of their mean; the best so far drives the body while the search goes on.",
    at: "#learn",
  },
];

export class Tour {
  // root: the card; say: tells those who listen.
  constructor(root, say) {
    this.root = root;
    this.say = say;
    this.find = (name) => root.querySelector(`.${name}`);
    this.find("next").addEventListener("click", () => (this.step < STEPS.length - 1 ? this.show(this.step + 1) : this.end()));
    this.find("back").addEventListener("click", () => this.show(this.step - 1));
    this.find("close").addEventListener("click", () => this.end());
    root.addEventListener("keydown", (event) => event.key === "Escape" && this.end());
  }

  // From the first step; `opener` gets the focus back at the end.
  begin(opener) {
    this.opener = opener;
    this.show(0);
  }

  show(step) {
    this.leave();
    this.step = step;
    const { title, text, at } = STEPS[step];
    this.root.hidden = false;
    this.find("title").textContent = `${step + 1} of ${STEPS.length}: ${title}`;
    this.find("text").textContent = text;
    this.find("back").hidden = step === 0;
    this.find("next").textContent = step === STEPS.length - 1 ? "Done" : "Next";
    this.target = document.querySelector(at);
    this.target.classList.add("toured");
    this.target.scrollIntoView({ block: at === ".pane" ? "start" : "center" });
    this.find("title").focus({ preventScroll: true });
  }

  leave() {
    this.target?.classList.remove("toured");
  }

  end() {
    this.leave();
    this.root.hidden = true;
    this.say("The tour has ended.");
    this.opener?.focus({ preventScroll: true });
  }
}
