"""The playground's engine, run in Node or in a browser, and the package's own run beside it."""

import base64
import gzip
import json
import shutil
import subprocess
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from apps import playground
from apps.playground import engine_cache, standard
from apps.playground.program import Program
from tegotae import Rollout, Scenario, Timing
from tegotae.parts.bodies import Body, Hopper
from tegotae.parts.controller import Controller
from tegotae.simulation.recorder import needing
from tegotae.simulation.schedules import Step

WEB = Path(str(resources.files(playground) / "web"))
NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs Node: apt-get install nodejs")

FRAME_S = 0.02
CHANNELS = (
    *("height_m", "phase_rad", "spring_force_n", "actuator_force_n", "apex_height_m"),
    *("climb_flight_m", "work_absolute_j", "energy_j", "failed"),
)

PLAYED = """
function played(lane, task) {
  for (const [name, value] of Object.entries(task.given)) lane.set(name, value);
  lane.release();
  const record = Object.fromEntries(task.channels.map((name) => [name, []]));
  for (let frame = 0; frame < task.frames; frame++) {
    for (const [at, name, value] of task.happens) if (at === frame) lane.set(name, value);
    lane.advance(task.ticks);
    for (const name of task.channels) {
      const count = lane.engine.layout["channel." + name][1];
      record[name].push(Array.from({ length: count }, (_, i) => lane.get("channel." + name, i)));
    }
  }
  return record;
}
"""
"""Play of a lane by Node and a browser: numbers that are not finite come back as null."""


@dataclass(frozen=True)
class Case:
    """A run: what drives what, from what release, and what happens on the way."""

    controller: Controller
    weights: Any
    body: Body
    scenario: Scenario
    happens: tuple[tuple[float, str, Any], ...] = ()
    """Times [s], names of a lane's entries, values."""
    duration_s: float = 10.0
    given: dict[str, Any] = field(default_factory=dict)

    @property
    def engine(self) -> engine_cache.CompiledEngine:
        return engine_cache.cached_engine(self.controller, self.body)

    def task(self) -> dict[str, Any]:
        """Data for a page."""
        program, scenario = Program(self.controller, self.body), self.scenario
        phases = np.broadcast_to(np.asarray(scenario.phase_rad).reshape(-1), (program.limbs,))
        inputs = {
            "weights": np.asarray(self.weights, "float32").tolist(),
            "omega": float(scenario.omega),
            "ground_m": 0.0,
            **{f"body.{name}": value for name, value in program.numbers.items()},
            **{f"release.{name}": 0.0 for name in program.pose_names},
            "release.height_m": scenario.height_m,
            "release.velocity_m_per_s": scenario.velocity_m_per_s,
            "release.phase_rad": phases.tolist(),
            **{f"release.{name}": value for name, value in dict(scenario.initial_pose).items()},
            **self.given,
        }
        return {
            "given": inputs,
            "frames": round(self.duration_s / FRAME_S),
            "ticks": round(FRAME_S / 0.001),
            "happens": [[round(t / FRAME_S), name, value] for t, name, value in self.happens],
            "channels": CHANNELS,
        }

    def by_the_package(self, controller: Controller | None = None) -> dict[str, np.ndarray]:
        """The same run by `Rollout.run`, channels [frames, limbs]."""
        timing = Timing(duration_s=self.duration_s, frame_s=FRAME_S)
        rollout = Rollout(controller=controller or self.controller, timing=timing, summary=whole)
        path = rollout.run(np.asarray(self.weights), self.scenario, self.body)
        return {n: np.asarray(x).reshape(timing.n_frames, -1) for n, x in path.channels.items()}


@needing(*CHANNELS)
def whole(trajectory: Any, scenario: Any, body: Any, timing: Any) -> Any:
    """The trajectory as it is, of a few channels."""
    return trajectory


def in_node(script: str, data: Any, folder: Path) -> Any:
    """Evaluate a module's last expression `result` in Node: it may use `data` and `web`."""
    (folder / "data.json").write_text(json.dumps(data))
    (folder / "run.mjs").write_text(
        'import fs from "fs";\n'
        f'const data = JSON.parse(fs.readFileSync("{folder / "data.json"}"));\n'
        f'const web = (name) => import("{WEB.as_uri()}/" + name);\n'
        f"{script}\nconsole.log(JSON.stringify(result));\n"
    )
    (folder / "package.json").write_text('{"type": "module"}')
    assert NODE is not None
    process = subprocess.run(
        [NODE, "--no-warnings", str(folder / "run.mjs")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    return json.loads(process.stdout)


def wasm_of(engine: engine_cache.CompiledEngine) -> dict[str, Any]:
    """An engine as a script takes it: its bytes in base64."""
    return {
        "wasm": base64.b64encode(gzip.decompress(engine.wasm)).decode(),
        "layout": engine.layout,
    }


def played_in_node(case: Case, folder: Path) -> dict[str, np.ndarray]:
    """A run of the page's engine in Node, channels [frames, limbs]."""
    script = PLAYED + (
        'const { Engine } = await web("engine.js");\n'
        'const bytes = Buffer.from(data.engine.wasm, "base64");\n'
        "const engine = await Engine.of(bytes, data.engine.layout);\n"
        "const result = played(engine.lane(), data.task);"
    )
    return arrays(in_node(script, {"engine": wasm_of(case.engine), "task": case.task()}, folder))


def arrays(record: dict[str, Any]) -> dict[str, np.ndarray]:
    """A record of a script as arrays."""
    return {name: np.array(rows, float) for name, rows in record.items()}


def assert_same(result: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    """The same run, but for the last digits of float32, which differ between processors."""
    for name, size in (("height_m", 1e-4), ("energy_j", 1e-3), ("climb_flight_m", 1e-3)):
        np.testing.assert_allclose(result[name], expected[name], atol=size, err_msg=name)
    for name in ("work_absolute_j", "spring_force_n"):
        np.testing.assert_allclose(result[name], expected[name], rtol=1e-3, atol=1e-3, err_msg=name)
    difference = np.angle(np.exp(1j * (result["phase_rad"] - expected["phase_rad"])))
    assert np.abs(difference).max() < 1e-3
    assert (result["failed"] == expected["failed"]).all()
    together = ~np.isnan(result["apex_height_m"]) & ~np.isnan(expected["apex_height_m"])
    # An apex at the very end of a frame may be found in the next one.
    assert (np.isnan(result["apex_height_m"]) ^ np.isnan(expected["apex_height_m"])).sum() <= 2
    gap = np.abs(result["apex_height_m"] - expected["apex_height_m"])[together]
    assert gap.size == 0 or gap.max() < 1e-4


def all_that_can_happen() -> Case:
    """A learned controller; frequency, mass, stiffness and gravity change, and the ground drops."""
    saved = next(entry.saved for entry in standard() if entry.saved.name == "ART-rF-tphif-w8")
    changes = {
        "omega": Step(7.0, from_s=2.0),
        "mass_kg": Step(0.11, from_s=3.0),
        "stiffness_n_per_m": Step(6.0, from_s=4.0),
        "gravity_m_per_s2": Step(9.0, from_s=5.0),
    }
    happens = [
        (change.from_s, name if name == "omega" else f"body.{name}", change.value)
        for name, change in changes.items()
    ]
    scenario = Scenario(omega=8.0, changes=changes, drop_m=0.1, drop_time_s=6.0)
    return Case(
        saved.controller,
        saved.weights,
        Hopper(),
        scenario,
        (*happens, (6.0, "ground_m", -0.1)),
        9.0,
    )
