"""Limbs on an environment as an agent learns them: episodes side by side, feedback as action."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from tegotae._support.errors import TegotaeError, require, unknown
from tegotae.envs._types import Info
from tegotae.envs.pilot import Pilot
from tegotae.envs.settings import feedback_controller
from tegotae.envs.wires import read_by
from tegotae.parts.controller import Controller
from tegotae.training.agents.actor import Observed
from tegotae.training.agents.settings import AgentSettings, agent_controller
from tegotae.training.environments.evaluator import SampleWarning
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.rollouts import EnvRollouts, lanes_of
from tegotae.training.environments.step_rewards import step_reward

require("stable_baselines3", "sb3")

from stable_baselines3.common.monitor import Monitor  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402

_PHASE = ("sin_phase", "cos_phase")


@dataclass(frozen=True)
class EnvAgentTraining:
    """An experiment on an environment as an agent learns it, by some settings.

    The agent has the experiment's episodes: the same environment, starts and frequencies, of which
    every limb observes its phase and what its controller reads. What it is paid adds up to the
    experiment's objective (`tegotae.training.environments.step_rewards`). The deterministic policy
    is judged by that objective, as candidates of a population are.

    Args:
        experiment: what is learned.
        settings: the algorithm and how it is set.

    Raises:
        TegotaeError: for a controller without a meaning for agents, or critics that sense what is
            not observed.
    """

    experiment: EnvExperiment
    settings: AgentSettings

    def __post_init__(self) -> None:
        _ = self.controller

    @property
    def controller(self) -> Controller:
        """The policy, with a limit to its feedback (`agent_controller`)."""
        return agent_controller(self.experiment, self.settings)

    @property
    def hold(self) -> int:
        """Control periods for which an action is held."""
        settings = self.settings
        held_s = settings.tick_s * settings.decimation
        return max(1, round(held_s / self.experiment.wires.step_s))

    @property
    def actions_per_episode(self) -> int:
        """Actions in a whole episode."""
        steps = max(1, round(self.duration_s / self.experiment.wires.step_s))
        return -(-steps // self.hold)

    @property
    def duration_s(self) -> float:
        """Length of an episode [s]."""
        return self.experiment.duration_s

    @property
    def observed(self) -> Observed:
        """What the columns of an observation are, of one limb."""
        own = self.experiment
        scales = {name: float(x) for name, x in own.wiring.scales.items()}
        return Observed((*_PHASE, *read_by(own.controller)), scales)

    def make_env(self) -> VecEnv:
        """The episodes."""
        return LimbVecEnv(self)

    @cached_property
    def _rollouts(self) -> EnvRollouts:
        wiring = self.experiment.wiring.reading(self.controller)
        own = dataclasses.replace(self.experiment, wiring=wiring)
        return EnvRollouts(own, len(own.evaluation_starts))

    def judge(self, weights: np.ndarray) -> tuple[float, float]:
        """CoT⁻¹ [m/J], NaN where it is not measured, and fitness, over the evaluation set."""
        starts = self.experiment.evaluation_starts
        found = self._rollouts.try_out(np.tile(weights, (len(starts), 1)), starts=starts)
        if troubles := [each for each in found.troubles if each is not None]:
            raise TegotaeError(f"{self.experiment.spec.env}: {troubles[0]}")
        return float(found.cot_inverse.mean()), float(found.fitness.mean())


class LimbVecEnv(VecEnv):
    """Episodes side by side whose action is the feedback of the limbs, in shares of its limit.

    Observed is of every limb in turn sin φ, cos φ and its senses over their scales; behind these is
    what critics sense besides. Episodes begin in turn as those of a candidate in a population; a
    lane's rounds draw starts of their own where generations do.

    Args:
        training: the experiment, and how the agent is set.
    """

    def __init__(self, training: EnvAgentTraining) -> None:
        own, settings = training.experiment, training.settings
        wires, controller = own.wires, training.controller
        assert controller.oscillator is not None
        assert controller.tegotae is not None
        assert controller.tegotae.limit_rad_per_s is not None
        bare = feedback_controller(controller.actuation, controller.oscillator)
        bare = dataclasses.replace(bare, limbs=controller.limbs)
        self._own, self._hold, self._wires = own, training.hold, wires
        self._limit = controller.tegotae.limit_rad_per_s
        lanes = settings.n_envs
        self._lanes = lanes_of(own, lanes)
        self._pilot = Pilot(
            dataclasses.replace(wires, controller=bare), own.wiring, np.zeros((1, lanes))
        )
        self._reward = step_reward(
            own,
            lanes,
            self._lanes.steps,
            self._pilot,
            least_work_j=settings.least_work_j,
            charge_stored=settings.charge_stored,
        )
        self._scales = {
            name: float(own.wiring.scales.get(name, 1.0)) for name in training.observed.names
        }
        for name in settings.critic_senses:
            if name not in wires.observed:
                raise unknown("entry of the observation", name, wires.observed)
        self._besides = [wires.observed.index(name) for name in settings.critic_senses]
        self._actions = np.zeros((lanes, wires.limbs), np.float32)
        self._warned: set[str] = set()
        self.render_mode = None  # Stable-Baselines3 warns of an environment that says nothing
        width = wires.limbs * len(training.observed.names) + len(self._besides)
        super().__init__(lanes, Box(-np.inf, np.inf, (width,)), Box(-1.0, 1.0, (wires.limbs,)))

    def reset(self) -> np.ndarray:
        """An episode in every lane: the first in the first, the second in the second and so on."""
        every, own = np.ones(self.num_envs, bool), self._own
        self._seen = self._lanes.reset(own.seed, every)
        self._episode = np.arange(self.num_envs) % own.episodes - 1
        self._begun = np.zeros(self.num_envs, int)
        self._length, self._return = np.zeros(self.num_envs, int), np.zeros(self.num_envs)
        self._omega = np.zeros(self.num_envs)
        self._begin(every)
        return self._shown()

    def _begin(self, where: np.ndarray) -> None:
        """The next episode of some lanes."""
        own = self._own
        self._episode = np.where(where, (self._episode + 1) % own.episodes, self._episode)
        seeds = np.zeros(self.num_envs, np.int64)
        for lane in map(int, np.flatnonzero(where)):
            episode, begun = int(self._episode[lane]), int(self._begun[lane])
            seeds[lane] = own.starts(lane, begun // own.episodes)[0, episode]
            self._omega[lane] = own.wiring_in(episode).omega
        self._begun += where
        self._seen = self._lanes.restart(seeds, where)
        self._check(where)
        self._pilot.restart(where, self._omega)
        self._reward.begin(self._seen, where)
        self._length[where], self._return[where] = 0, 0.0

    def _check(self, begun: np.ndarray) -> None:
        """Raise `TegotaeError` for an environment that cannot be reset; warn of other troubles."""
        for lane, trouble in enumerate(self._lanes.troubles):
            if trouble is None:
                continue
            if begun[lane]:
                raise TegotaeError(f"{self._own.spec.env} cannot begin an episode: {trouble}")
            if trouble not in self._warned:
                self._warned.add(trouble)
                warnings.warn(
                    f"{self._own.spec.env}: {trouble}; the episode ends there, the training "
                    "continues",
                    SampleWarning,
                    stacklevel=2,
                )

    def _shown(self) -> np.ndarray:
        """[lanes, columns], limb by limb."""
        phase, seen = self._pilot.phase, self._seen
        columns = [np.sin(phase), np.cos(phase)]
        for name, (at, sign) in self._wires.sensed.items():
            felt = sign[:, None] * seen[:, at].T
            felt = np.maximum(felt, 0.0) if name == "spring_force" else felt
            columns.append(felt / self._scales[name])
        of_limbs = np.stack(columns, axis=-1)  # [limbs, lanes, columns]
        rows = np.swapaxes(of_limbs, 0, 1).reshape(self.num_envs, -1)
        return np.concatenate([rows, seen[:, self._besides]], axis=1).astype(np.float32)

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions, [lanes, limbs], for the step to come."""
        self._actions = np.clip(np.asarray(actions, np.float32), -1.0, 1.0)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[Info]]:
        """Hold the feedback for its control periods, and begin new episodes where one ended."""
        n = self.num_envs
        rewards, going, cut = np.zeros(n), np.ones(n, bool), np.zeros(n, bool)
        for _ in range(self._hold):
            acted = self._pilot.act(self._seen, added=self._limit * self._actions.T)
            seen, paid, over = self._lanes.step(acted, going)
            seen = np.nan_to_num(seen, posinf=0.0, neginf=0.0)
            self._seen = np.where(going[:, None], seen, self._seen)
            self._length += going
            paid = np.where(going, paid, 0.0)
            rewards += self._reward.of_step(self._seen, acted, paid, going)
            late = self._length >= self._lanes.steps
            cut |= going & (self._lanes.truncated | (late & ~over))
            going &= ~(over | late)
            if not going.any():
                break
        over = ~going
        rewards += self._reward.at_the_end(over)
        self._return += rewards
        shown = self._shown()
        infos: list[Info] = [{} for _ in range(n)]
        if over.any():
            for lane in np.flatnonzero(over).tolist():
                infos[lane] = {
                    "terminal_observation": shown[lane],
                    "TimeLimit.truncated": bool(cut[lane]),
                    "episode": {"r": float(self._return[lane]), "l": int(self._length[lane])},
                }
            self._check(np.zeros(n, bool))
            self._begin(over)
            shown = self._shown()
        return shown, rewards.astype(np.float32), over, infos

    def close(self) -> None:
        """Close the environments."""
        self._lanes.close()

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """An attribute, the same for each lane asked for."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(
        self, attr_name: str, value: object, indices: int | Iterable[int] | None = None
    ) -> None:
        """Set an attribute of all lanes."""
        setattr(self, attr_name, value)

    def env_method(
        self,
        method_name: str,
        *method_args: object,
        indices: int | Iterable[int] | None = None,
        **method_kwargs: object,
    ) -> NoReturn:
        """There are no environments behind the lanes whose methods could be called."""
        raise TegotaeError(f"limbs have no single environments, and so no method {method_name!r}")

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """False for each lane asked for, but true of `Monitor`, whose record is kept here."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]
