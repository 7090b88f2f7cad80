"""A body of your own: a leg of rubber, which stiffens as it is compressed."""

from pathlib import Path

import numpy as np

from tegotae import Hopper, Rollout, Scenario, Timing, check
from tegotae.figures.style import COLOURS, new_figure, save_figure, styled
from tegotae.systems.recipe import recipe
from tegotae.systems.registry import imported

FILE = Path(__file__).parents[1] / "docs" / "extending" / "examples" / "rubber_hopper.py"
RubberHopper = imported(str(FILE)).RubberHopper
check(RubberHopper())

# The same controller on both bodies.
rollout = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=10.0))
bodies = {"linear spring": Hopper(), "rubber": RubberHopper()}
paths = {name: rollout.run([3.0], Scenario(omega=8.0), body) for name, body in bodies.items()}

with styled():
    figure = new_figure(5.0, 2.6)
    over_time, spring = figure.subplots(1, 2, width_ratios=(2.0, 1.0))
    for (name, path), colour, line in zip(paths.items(), COLOURS, ("-", "--"), strict=False):
        over_time.plot(path.time_s, path.height_m[:, 0], line, color=colour)
        height, force = path.height_m[:, 0], path.spring_force_n[:, 0]
        order = np.argsort(height)
        spring.plot(height[order], force[order], line, color=colour, label=name)
    over_time.set(xlabel="time [s]", ylabel="height [m]", xlim=(5.0, 10.0))
    spring.set(xlabel="height [m]", ylabel="spring force [N]")
    spring.legend()
save_figure(figure, "own_body.png")

apex_m = {name: np.nanmax(path.apex_height_m[-100:]) for name, path in paths.items()}
print(", ".join(f"{name}: {apex:.2f} m" for name, apex in apex_m.items()))
assert all(apex > 1.01 for apex in apex_m.values())  # both hop
