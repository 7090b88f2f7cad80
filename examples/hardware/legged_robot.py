"""A MuJoCo model as the robot of legged_node.py, with a watchdog of its own."""

import json
from pathlib import Path

import numpy as np
from legged_link import COMMAND, IMU, JOINTS, PERIOD_S, STATE

from tegotae.envs.mujoco.env import ModelEnv

WATCHDOG = 25  # periods without a new command, after which joints are damped alone


class Robot:
    """The model of a law, whose joints are servos; `folder` is that of the law's export."""

    def __init__(self, law, folder, seed=0):
        task = json.loads(Path(law).read_text())["task"]
        own = {**task["settings"], "legs": False, "control_s": PERIOD_S, "duration_s": 1e4}
        self.env = ModelEnv(model=task["env"], **own)
        model, motors = self.env.model, self.env.action_names
        names = [model.joint(model.actuator_trnid[i, 0]).name for i in range(model.nu)]
        legs = json.loads((Path(folder) / "tegotae.json").read_text())["legs"]
        self.order = [names.index(name) for leg in legs for name in leg["joints"]]
        felt = [*(names[i] for i in self.order), *(f"{motors[i]}_force" for i in self.order), *IMU]
        self.entries = [self.env.observation_names.index(name) for name in felt]
        self.seen, _ = self.env.reset(seed=seed)
        self.count, self.heard, self.waited, self.fell = 1, 0, 0, False

    def state(self):
        """What its sensors say."""
        return STATE.pack(self.count, *self.seen[self.entries])

    def step(self, packet):
        """One period under the newest command, if there is one; whether the servos are on."""
        count, on, *angles = COMMAND.unpack(packet) if packet else (0, 0)
        self.waited = 0 if count > self.heard else self.waited + 1
        self.heard = max(count, self.heard)
        on = on and self.waited <= WATCHDOG and np.isfinite(angles).all()
        action = np.zeros(JOINTS)
        action[self.order] = angles if on else self.seen[self.entries[:JOINTS]]
        self.seen, _, fell, *_ = self.env.step(action)
        self.count, self.fell = self.count + 1, self.fell or fell
        return bool(on)

    def sensed(self, name):
        """What a real robot may not know."""
        return self.seen[self.env.observation_names.index(name)]
