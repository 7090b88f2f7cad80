"""Does a torso on two legs stand? Random bodies, and how long each stays up.

    python -m research.gaits.biped

Writes `docs/_static/gaits/biped.csv`: for each place of the legs and each shift of the ellipse the
bodies tried, how many stood to the end, and when half and the last of the others had fallen. Half a
minute on two cores. Lengths and times are in the leg's length l0 and √(l0/g).
"""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from tegotae import Rollout, Scenario, Timing
from tegotae._support.files import write_atomically
from tegotae.parts.bodies import Walker
from tegotae.parts.terms import EllipticFoot
from tegotae.simulation.recorder import needing
from tegotae.systems.vanilla import walking

OUT = Path(__file__).resolve().parents[2] / "docs" / "_static" / "gaits" / "biped.csv"
BODIES = 4000
TIMING = Timing(duration_s=40.0, tick_s=0.01, frame_s=0.1)
PLACES = {
    "side by side": ((0.0, 0.0), (0.44, -0.44)),
    "one behind the other": ((0.85, -0.85), (0.0, 0.0)),
    "on a diagonal": ((0.5, -0.5), (0.3, -0.3)),
}


@needing("failed")
def time_up(trajectory, scenario, body, timing):
    """Return the time for which each body stood [s]."""
    return jnp.where(trajectory.failed, 0.0, timing.frame_s).sum(axis=0)


def stands(places: tuple[tuple[float, ...], ...], shift_rad: float) -> np.ndarray:
    """Return the standing times of random bodies with these hips, [BODIES]."""
    random = np.random.default_rng(0)
    inertia = random.uniform(0.2, 3.0, BODIES)
    changes = {
        "com_z_m": random.uniform(-0.7, 0.0, BODIES),
        "com_x_m": random.uniform(-0.1, 0.1, BODIES),
        **{f"inertia_{axis}_kg_m2": inertia for axis in "xyz"},
    }
    foot = EllipticFoot(stride_m=0.15, lift_m=0.08, press_m=0.03, shift_rad=shift_rad)
    legged = walking("two legs", Walker(hips_x_m=places[0], hips_y_m=places[1]), foot, 1.25, 2.0)
    scenario = Scenario(
        omega=random.uniform(0.8, 5.0, BODIES),
        height_m=1.0 + changes["com_z_m"],
        phase_rad=random.uniform(0.0, 2.0 * math.pi, (2, BODIES)),
        initial_pose={"roll_rad": 0.01},
        changes=changes,
    )
    rollout = Rollout(controller=legged.controller, timing=TIMING, summary=time_up)
    return rollout.run(random.uniform(0.0, 3.0, (BODIES, 1)), scenario, legged.body)


def main() -> None:
    """Run the whole study."""
    stream = io.StringIO()
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(("legs", "shift_rad", "bodies", "stand", "half_fallen_s", "last_falls_s"))
    for name, places in PLACES.items():
        for shift in (0.0, 0.4):
            up = stands(places, shift)
            falls = up[up < TIMING.duration_s - 0.5 * TIMING.frame_s]
            row = (len(up) - len(falls), f"{np.median(up):.1f}", f"{falls.max(initial=0.0):.1f}")
            table.writerow((name, shift, len(up), *row))
    write_atomically(OUT, stream.getvalue())
    print(stream.getvalue())


if __name__ == "__main__":
    main()
