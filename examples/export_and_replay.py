"""Export a controller as C, and replay its golden run through the live controller.

The vectors of an export are ticks of the simulator. Fed with the forces of that run, the compiled
controller commands the same.
"""

import numpy as np

import tegotae as tg
from tegotae.figures.style import COLOURS, new_figure, save_figure, styled

exported = tg.robots.export_c("V-reflex-w8", tick_s=0.001, prefix="leg")
for path in exported.save("robot"):
    print(path)

run = exported.table
live = tg.robots.export_native("V-reflex-w8").live()
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
