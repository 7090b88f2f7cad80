"""Recordings of episodes on an environment, and their quantities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import unknown


@dataclass(frozen=True)
class EnvEpisode:
    """One episode of one candidate, for a fitness of your own."""

    time_s: np.ndarray
    """Time at the end of each step [s], [steps]."""
    observation: np.ndarray
    """The observations at these times, [steps, entries]."""
    names: tuple[str, ...]
    """Names of its entries."""
    action: np.ndarray
    """The action of each step, [steps, entries]."""
    reward: np.ndarray
    """The environment's reward, [steps]."""
    phase_rad: np.ndarray
    """Phases at the end of each step [rad], [steps, limbs]."""
    lasted: float
    """Share of the longest episode that it lasted, 0 ... 1; less than 1 if it ended early."""

    def __getitem__(self, name: str) -> np.ndarray:
        """The observation's entry of that name, [steps].

        Raises:
            TegotaeError: if nothing that is observed has this name.
        """
        if name not in self.names:
            raise unknown("entry of the observation", name, self.names)
        return self.observation[:, self.names.index(name)]


@dataclass(frozen=True)
class EpisodeBatch:
    """Episodes side by side."""

    step_s: float
    """Time of a step [s]."""
    names: tuple[str, ...]
    """Names of the observation's entries."""
    observation: np.ndarray
    """[steps, lanes, entries]; a lane's last one again after it has ended."""
    action: np.ndarray
    """[steps, lanes, entries]."""
    reward: np.ndarray
    """[steps, lanes]; 0 after a lane has ended."""
    phase_rad: np.ndarray
    """[steps, limbs, lanes]."""
    ended: np.ndarray
    """Steps that a lane lasted, [lanes]."""
    steps: int
    """Steps of the longest episode."""
    sound: np.ndarray
    """The lanes that ran to their end without a fault, [lanes]; others have no episode."""

    @property
    def lasted(self) -> np.ndarray:
        """Share of the longest episode that each lane lasted, [lanes]."""
        return self.ended / self.steps

    def entry(self, name: str) -> np.ndarray:
        """The observation's entry of that name, [steps, lanes]."""
        return self.observation[:, :, self.names.index(name)]

    def episode(self, lane: int) -> EnvEpisode:
        """A lane's own."""
        last = int(self.ended[lane])
        return EnvEpisode(
            time_s=self.step_s * np.arange(1, last + 1),
            observation=self.observation[:last, lane],
            names=self.names,
            action=self.action[:last, lane],
            reward=self.reward[:last, lane],
            phase_rad=self.phase_rad[:last, :, lane],
            lasted=float(self.lasted[lane]),
        )
