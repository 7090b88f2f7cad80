"""How an episode of a MuJoCo model is rewarded, and when it ends; lane by lane."""

from __future__ import annotations

import numpy as np

from tegotae.envs.mujoco.sensing import Sensing, is_sound
from tegotae.envs.mujoco.settings import ModelSettings


class Fate:
    """Rewards and ends of lanes that are stepped together.

    Args:
        settings: of the model.
        sensing: the model.
        step_s: control period [s].
    """

    def __init__(self, settings: ModelSettings, sensing: Sensing, step_s: float) -> None:
        model = sensing.model
        self.steps = max(1, round(settings.duration_s / step_s))
        self._settings = settings
        self._at = {n: sensing.names.index(f"root_{n}") for n in ("forward", "height", "upright")}
        gravity = float(np.linalg.norm(model.opt.gravity)) or 1.0
        self._weight_n = float(model.body_mass.sum()) * gravity
        self._length_m = np.ones(1)
        self._done = np.zeros(1, int)
        self._seen = np.zeros((2, 1))

    def begin(self, seen: np.ndarray, where: np.ndarray | None = None) -> None:
        """A new episode, from what is observed at its start [lanes, entries].

        Args:
            seen: what is observed.
            where: of which lanes, [lanes]; of all by default.
        """
        if where is None:
            where = np.ones(len(seen), bool)
            self._length_m, self._done = np.ones(len(seen)), np.zeros(len(seen), int)
            self._seen = np.zeros((2, len(seen)))
        height = seen[where, self._at["height"]] - self._settings.release_m
        self._length_m[where] = np.maximum(height, 1e-6)
        self._done[where] = 0
        self._seen[0, where], self._seen[1, where] = seen[where, self._at["forward"]], 0.0

    def after(
        self, seen: np.ndarray, work_j: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Reward, whether it has fallen and whether the time is up, [lanes] each."""
        self._done += 1
        forward, before = seen[:, self._at["forward"]], self._seen
        went = (forward - before[0]) / self._length_m
        spent = (work_j - before[1]) / (self._weight_n * self._length_m)
        self._seen = np.stack([forward, work_j])
        low = seen[:, self._at["height"]] < self._settings.fallen_share * self._length_m
        fallen = low | (seen[:, self._at["upright"]] < 0.0) | ~is_sound(seen).all(axis=1)
        return went - self._settings.effort * spent, fallen, self._done >= self.steps
