"""A hopper under vanilla Tegotae feedback; the ground drops by 0.2 m, and it hops on."""

import numpy as np

import tegotae as tg

run = tg.load("V-reflex-w8").simulate(sigma=2.0, drop_m=0.2, drop_time_s=8.0, duration_s=16.0)
run.plot("hopper.png")

time_s, apex_m = (np.array(run.to_dict()[name]) for name in ("apex_time_s", "apex_height_m"))
before, after = apex_m[time_s < 8.0][-1], apex_m[-1]
print(f"apex {before:.3f} m before the drop, {after:.3f} m after it")
assert abs(after - (before - 0.2)) < 0.01  # the same hop, 0.2 m lower
