"""Measure the learning time of the playground's learner: `python
research/benchmarks/playground_learning.py`, with Node.

For each start of the page it runs the page's own worker on the paper's hopper at 8 rad/s, until the
best mean is within 2 % of the best gait known. A row a start: _static/playground_learning.csv.
"""

import base64
import csv
import gzip
import json
import subprocess
import tempfile
from importlib import resources
from pathlib import Path
from typing import Any

from apps.playground import Page, standard
from research.reproduction.optimum import largest_cot_inverse
from tegotae.parts.bodies import Hopper

NEAR = 0.98
OUT = Path(__file__).parents[2] / "docs" / "_static" / "playground_learning.csv"
SCRIPT = """
import fs from "fs";
const { learn } = await import(process.argv[2]);
const task = JSON.parse(fs.readFileSync(0));
task.wasm = Buffer.from(task.wasm, "base64");
const begun = performance.now();
await learn(task, ({ generation, best }) => {
  const there = best.fitness >= task.enough;
  if (!there && generation < task.generations - 1) return;
  const seconds = (performance.now() - begun) / 1000;
  console.log(JSON.stringify([there, generation + 1, best.fitness, seconds]));
  process.exit(0);
});
"""


def main() -> None:
    """Learn from every start, and write the table."""
    page: Any = Page(standard()).document()
    art = next(
        controller for controller in page["controllers"] if controller["label"].startswith("ART:")
    )
    engine = page["engines"][art["engines"]["hopper"]]
    hopper = next(controller for controller in page["bodies"] if controller["name"] == "hopper")
    best = largest_cot_inverse(Hopper(), 8.0)
    fields = {f"body.{name}": value for name, value in hopper["numbers"].items()}
    fields |= {"omega": 8.0, "ground_m": 0.0, "release.height_m": 1.2}
    fields |= {"release.velocity_m_per_s": 0.0, "release.phase_rad": 0.0}
    learning = page["learning"]
    rows = []
    for start, weights in enumerate(art["starts"]):
        task = {
            "wasm": base64.b64encode(gzip.decompress(base64.b64decode(engine["wasm"]))).decode(),
            "layout": engine["layout"],
            "given": fields,
            "weights": weights,
            "settings": learning["settings"],
            "timing": learning["timing"],
            "definitions": {**page["definitions"], "follow_omega": True},
            "seed": start,
            "generations": learning["generations"],
            "enough": NEAR * best,
        }
        solved, generations, fitness, seconds = learned(task)
        rows.append([start, solved, generations, f"{fitness:.4f}", f"{seconds:.1f}"])
        print(rows[-1], flush=True)
    with OUT.open("w", newline="") as file:
        csv.writer(file).writerows([["start", "near", "generations", "fitness", "seconds"], *rows])


def learned(task: dict) -> list:
    """Return the columns of learning: success, its time, the quality and the speed."""
    worker = Path(str(resources.files("apps.playground"))) / "web" / "learn" / "worker.js"
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "learn.mjs"
        script.write_text(SCRIPT)
        command = ["node", "--no-warnings", str(script), worker.as_uri()]
        text = json.dumps(task)
        process = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
    return json.loads(process.stdout)


if __name__ == "__main__":
    main()
