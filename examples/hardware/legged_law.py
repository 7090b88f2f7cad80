"""A law on legs as `tegotae export c` wrote it, compiled and called; needs NumPy and a compiler."""

import ctypes
import json
import subprocess
from pathlib import Path

import numpy as np


class Law:
    """The C of an export's folder: one `step` is one tick of the law."""

    def __init__(self, folder):
        folder = Path(folder)
        manifest = json.loads((folder / "tegotae.json").read_text())
        self.limbs, self.tick_s = manifest["limbs"], manifest["tick_s"]
        self.wired = manifest["wired"]
        self.joints = [name for leg in manifest["legs"] for name in leg["joints"]]
        self.feet = [leg["foot"] for leg in manifest["legs"]]
        self.axes = sum(output["name"].startswith("foot_") for output in manifest["outputs"])
        words = ["cc", "-std=c99", "-O2", "-shared", "-fPIC", "tegotae.c", "-lm", "-o", "law.so"]
        subprocess.run(words, cwd=folder, check=True)
        self.c = ctypes.CDLL(str((folder / "law.so").resolve()))
        members = [entry["name"] for entry in manifest["inputs"]]
        signals = sorted(self.wired[0]["senses"], key=len, reverse=True)
        self.senses = [next(s for s in signals if m.startswith(f"{s}_")) for m in members]
        self.inputs = np.zeros((len(members), self.limbs), np.float32)
        self.outputs = np.zeros(len(manifest["outputs"]) * self.limbs + 1, np.float32)
        self.state = ctypes.create_string_buffer(64 * (self.limbs + 1))
        self.legs = np.zeros((self.limbs, len(self.joints) // self.limbs), np.float32)
        phases = np.array([limb["phase_rad"] for limb in self.wired], np.float32)
        self.c.tegotae_init(self.state, pointer(phases))

    def loads_n(self, angles, torques):
        """The load on every foot, from the torques of its servos."""
        loads = np.zeros(self.limbs, np.float32)
        inputs = [np.array(x, np.float32) for x in (angles, torques)]
        self.c.tegotae_loads(*map(pointer, inputs), pointer(loads))
        return dict(zip((f"{foot}_estimated_force" for foot in self.feet), loads, strict=True))

    def step(self, felt, reach_m):
        """Angles of all joints [rad], from what is felt; feet go no further than the reach."""
        for k, signal in enumerate(self.senses):
            if signal.startswith(("commanded_", "odometry_")):
                continue  # which a `CommandedLaw` sets
            for i, limb in enumerate(self.wired):
                name = limb["senses"][signal]
                self.inputs[k, i] = -felt[name[1:]] if name[0] == "-" else felt[name]
        self.c.tegotae_step(self.state, pointer(self.inputs), pointer(self.outputs))
        places = self.outputs[: self.axes * self.limbs]
        np.clip(places, -reach_m, reach_m, out=places)
        self.c.tegotae_joints(pointer(self.outputs), pointer(self.legs))
        return self.legs.ravel().copy()


def pointer(array):
    """Return the address of an array for C."""
    return array.ctypes.data_as(ctypes.c_void_p)
