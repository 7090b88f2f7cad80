"""Random episodes for many lanes, each lane with a generator of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from gymnasium.utils import seeding
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.envs.settings import HopperSettings
from tegotae.simulation.rollout import Scenario


class LaneScenarios:
    """What every lane's next episode meets.

    Lane i seeded with s draws what a single environment draws that was reset with seed s: a batch
    is so many single environments, to the last random number.
    """

    def __init__(self, settings: HopperSettings, lanes: int) -> None:
        self._settings = settings
        self._random: list[np.random.Generator | None] = [None] * lanes
        self._fixed = None if settings.draws else settings.scenario(None)

    def seed(
        self, seed: int | Sequence[int | None] | None, where: np.ndarray | None = None
    ) -> None:
        """Seed lane i with `seed + i`, or each with its own; None leaves a lane as it is.

        Raises:
            TegotaeError: for a list of seeds that has not one per lane.
        """
        lanes = len(self._random)
        seeds: Sequence[int | None]
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else int(seed) + i for i in range(lanes)]
        else:
            seeds = seed
        if len(seeds) != lanes:
            raise TegotaeError(f"there are {len(seeds)} seeds for {lanes} lanes; give one per lane")
        if self._fixed is not None:
            return
        for lane, own in enumerate(seeds):
            if own is not None and (where is None or where[lane]):
                self._random[lane], _ = seeding.np_random(own)

    def next(
        self, where: np.ndarray | None = None, options: Mapping[str, ArrayLike] | None = None
    ) -> list[Scenario]:
        """One scenario a lane; lanes outside the mask `where` draw nothing.

        Args:
            where: which lanes begin an episode; all by default.
            options: numbers by name, or arrays of shape [lanes], that stand for these episodes.
        """
        lanes = len(self._random)
        if self._fixed is not None and not options:
            return [self._fixed] * lanes
        columns = {
            name: np.broadcast_to(_array(name, value, lanes), (lanes,)).tolist()
            for name, value in (options or {}).items()
        }
        idle = self._fixed or Scenario(omega=0.0)
        return [
            self._settings.scenario(
                self._generator(lane), {name: column[lane] for name, column in columns.items()}
            )
            if where is None or where[lane]
            else idle
            for lane in range(lanes)
        ]

    def _generator(self, lane: int) -> np.random.Generator | None:
        if self._fixed is None and self._random[lane] is None:
            self._random[lane], _ = seeding.np_random()
        return self._random[lane]


def _array(name: str, value: ArrayLike, lanes: int) -> np.ndarray:
    array = np.asarray(value)
    if array.shape not in ((), (lanes,)):
        raise TegotaeError(
            f"option {name} has shape {array.shape}; it must be a number or have shape ({lanes},)"
        )
    return array
