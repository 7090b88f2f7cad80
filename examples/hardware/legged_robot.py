"""A MuJoCo model as the robot of legged_node.py, with a watchdog of its own."""

import json
import secrets
from pathlib import Path

import numpy as np
from legged_link import APART_RAD, COMMAND, IMU, JOINTS, MOST, PERIOD_S, STATE, WATCHDOG

from tegotae.envs.mujoco.env import ModelEnv


class Robot:
    """The model of a law, whose joints are servos; `folder` is that of the law's export."""

    def __init__(self, law, folder, seed=0):
        task = json.loads(Path(law).read_text())["task"]
        settings = {**task["settings"], "legs": False, "control_s": PERIOD_S, "duration_s": 1e4}
        self.env = ModelEnv(model=task["env"], **settings)
        model, motors = self.env.model, self.env.action_names
        names = [model.joint(model.actuator_trnid[i, 0]).name for i in range(model.nu)]
        legs = json.loads((Path(folder) / "tegotae.json").read_text())["legs"]
        self.order = [names.index(name) for leg in legs for name in leg["joints"]]
        felt = [*(names[i] for i in self.order), *(f"{motors[i]}_force" for i in self.order), *IMU]
        self.entries = [self.env.observation_names.index(name) for name in felt]
        self.seen, _ = self.env.reset(seed=seed)
        self.session, self.count, self.fell = 1 + secrets.randbelow(2**32 - 1), 1, False
        self.heard, self.waited, self.on, self.angles = 0, 0, 0, np.zeros(JOINTS)

    def state(self):
        """Return the readings of its sensors."""
        return STATE.pack(self.session, self.count, *self.seen[self.entries])

    def accepts(self, packet):
        """Return True if a command is new, answers a late state of this session, and is finite."""
        if len(packet) != COMMAND.size:
            return False
        session, count, on, *angles = COMMAND.unpack(packet)
        late = max(self.heard, self.count - 1 - WATCHDOG)
        possible = on in (0, 1) and (np.abs(angles) <= MOST[:JOINTS]).all()
        return session == self.session and late < count <= self.count and possible

    def step(self, packet):
        """One period under the newest command, if there is one; whether the servos are on."""
        self.waited += 1
        if self.accepts(packet):
            _, self.heard, self.on, *self.angles = COMMAND.unpack(packet)
            self.waited = 0
        on, angles = self.on and self.waited <= WATCHDOG, self.seen[self.entries[:JOINTS]]
        action = np.zeros(JOINTS)
        action[self.order] = (
            np.clip(self.angles, angles - APART_RAD, angles + APART_RAD) if on else angles
        )
        self.seen, _, fell, *_ = self.env.step(action)
        self.count, self.fell = self.count + 1, self.fell or fell
        return bool(on)

    def sensed(self, name):
        """Return a simulated quantity that a real robot may not know."""
        return self.seen[self.env.observation_names.index(name)]
