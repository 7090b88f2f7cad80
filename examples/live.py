"""Drive a leg behind a serial port from Python, 500 times a second.

The leg is simulated by another process behind a pseudo-terminal. For a real one, replace
`port.Serial` by pyserial's `serial.Serial`, and its path by that of the cable.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

import tegotae as tg
from tegotae.figures.style import COLOURS, new_figure, save_figure, styled
from tegotae_robots.live import drive_hardware, new_recording

HARDWARE = Path(__file__).parent / "hardware"
sys.path.insert(0, str(HARDWARE))
from port import Serial  # noqa: E402
from serial_leg import SerialLeg  # noqa: E402

recording = new_recording("run.npz")  # before anything starts
simulated = subprocess.Popen(
    [sys.executable, str(HARDWARE / "simulated_leg.py")], stdout=subprocess.PIPE, text=True
)
try:
    assert simulated.stdout is not None
    port = Serial(simulated.stdout.readline().strip(), 921600, timeout=5.0)
    leg = SerialLeg(port)
    report = drive_hardware(
        tg.robots.export_native("V-reflex-w8").live(),
        leg.read,
        leg.write,
        rate_hz=500,
        duration_s=4,
        watchdog_s=5.0,
        recording=recording,
    )
    port.close()
finally:
    simulated.kill()
    simulated.communicate()
print(report)

run = np.load(recording)
with styled():
    figure = new_figure(5.0, 2.6)
    height, force = figure.subplots(2, 1, sharex=True)
    height.axhline(1.0, color="0.5", lw=0.6, ls=":")
    height.plot(run["time_s"], run["height_m"], color=COLOURS[0])
    height.set_ylabel("height [m]")
    force.plot(run["time_s"], run["spring_force"], color=COLOURS[0], label="spring")
    force.plot(run["time_s"], run["force_n"], "--", color=COLOURS[4], label="command")
    force.set(xlabel="time [s]", ylabel="force [N]")
    force.legend()
save_figure(figure, "live.png")

assert report.stopped == "duration"
assert leg.packets.damaged == 0
assert run["height_m"][len(run["height_m"]) // 2 :].max() > 1.02  # still hops
