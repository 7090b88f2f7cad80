"""Export a controller as C, and replay its golden run through the live controller.

The vectors of an export are ticks of the simulator. Fed with the forces of that run, the compiled
controller commands the same.
"""

from pathlib import Path

import numpy as np

from tegotae.export.c import Export, write
from tegotae.export.live import LiveController
from tegotae.figures.style import COLOURS, new_figure, save_figure, styled
from tegotae.systems.resolve import resolve
from tegotae.training.collection import controller_of

saved = controller_of(resolve("V-reflex-w8"))
for path in write(Export(saved, tick_s=0.001, prefix="leg"), Path("robot")):
    print(path)

run = np.genfromtxt("robot/golden.csv", delimiter=",", names=True, deletechars="")
live = LiveController.of(saved)
replayed = np.zeros(len(run))
for tick, (phase, force) in enumerate(
    zip(run["state.phase"], run["in.spring_force_n"], strict=True)
):
    live.reset(phase_rad=phase)
    replayed[tick] = live.step({"spring_force": force})[0]

with styled():
    figure = new_figure(5.0, 2.4)
    axes = figure.subplots()
    axes.plot(run["t_s"], run["out.force_n"], color=COLOURS[1], lw=2.5, label="simulator")
    axes.plot(run["t_s"], replayed, "--", color=COLOURS[0], label="replayed")
    axes.set(xlabel="time [s]", ylabel="force [N]")
    axes.legend()
save_figure(figure, "export_and_replay.png")

error = np.abs(replayed - run["out.force_n"]).max()
print(f"largest difference {error:.1e} N")
assert error < 1e-3
