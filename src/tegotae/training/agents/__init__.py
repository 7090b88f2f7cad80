"""Agents that learn the feedback law step by step, SAC and PPO through Stable-Baselines3: how they
are set, and which controllers they can learn. What needs torch is imported when it is used."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from tegotae._support.errors import TegotaeError, require_count
from tegotae.parts.controller import Controller
from tegotae.parts.parameters import Part, finite, not_negative, positive, whole
from tegotae.systems.experiment import Trainable
from tegotae.systems.registry import name_of

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecEnv

    from tegotae.training.agents.actor import Feedback

_share = partial(finite, above=0.0, most=1.0)
"""A field that is a share of something."""


@dataclass(frozen=True, kw_only=True)
class AgentSettings(Part):
    """Common settings of the agents: actions, reward and critics.

    Raises:
        TegotaeError: for a setting out of its range.
    """

    NAME: ClassVar[str]
    """Name of the algorithm in `tegotae train --algorithm`."""
    TITLE: ClassVar[str]
    """Name in figures; `NAME` by default."""

    tick_s: float = positive(0.001)
    """Control period of the hopper [s]; an environment has its own."""
    decimation: int = whole(10)
    """Ticks for which an action is held: by default the agent acts every 10 ms, on an environment
    in whole control periods."""
    max_feedback_rad_per_s: float = positive(40.0)
    """L, the feedback that an action of 1 is [rad/s]: `f = L tanh(G A′ R / L)`."""
    n_envs: int = whole(20)
    """Hoppers that are stepped together."""
    critic_senses: tuple[str, ...] = ()
    """Senses of the critics beyond the policy's, such as `velocity` and `height`; on an environment
    entries of its observation."""
    least_work_j: float = not_negative(1e-6)
    """Work up to which a hop is not rewarded [J] (see `tegotae.envs.HopReward`)."""
    charge_stored: bool = False
    """True if energy that the body lost since the last apex is charged as work too."""
    normalize_reward: bool = False
    """True if rewards are divided by the running deviation of their discounted sum, and clipped to
    ±10, before the agent receives them."""
    gamma: float = _share(0.995)
    """Discount per action; 1 / (1 - γ) actions are the agent's horizon, by default 2 s."""
    learning_rate: float = positive(3e-4)
    """Adam's step size."""
    batch_size: int = whole(256, least=2)
    """Transitions per gradient step."""
    noise: float = positive(0.1)
    """Initial standard deviation of the explored actions around the policy's, as a share of L."""
    critic_layers: tuple[int, ...] = (64, 64)
    """Neurons in the hidden layers of a critic."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for size in self.critic_layers:
            require_count("critic_layers", size)
        # As they are read back from a file, so that settings compare equal.
        object.__setattr__(self, "critic_senses", tuple(self.critic_senses))
        object.__setattr__(self, "critic_layers", tuple(self.critic_layers))

    def make(self, env: VecEnv, feedback: Feedback, seed: int) -> BaseAlgorithm:
        """Make the Stable-Baselines3 agent, untrained.

        Args:
            env: a vector of environments whose action is the feedback.
            feedback: the policy, a torch module from observations to actions before tanh; its
                parameters are the controller's weights.
            seed: of all that is drawn.
        """
        raise TegotaeError(
            f"{type(self).__name__} does not say how its agent is made; give it a method "
            "make(env, feedback, seed)"
        )


@dataclass(frozen=True, kw_only=True)
class SACSettings(AgentSettings):
    """Soft actor-critic, through Stable-Baselines3.

    Of Stable-Baselines3's own defaults it differs in the number of gradient steps: one for every
    `n_envs · train_freq / gradient_steps` transitions (SB3: one for each), so that a run of 1000
    episodes of 12 s, 1.2 million transitions, is a matter of minutes on one core.

    Reference: T. Haarnoja et al., Soft actor-critic, ICML 2018.
    """

    NAME = "sac"
    TITLE = "SAC"

    buffer_size: int = whole(300_000)
    """Transitions that the replay buffer holds."""
    learning_starts: int = whole(12_000)
    """Transitions by uniformly random actions before the first gradient step."""
    train_freq: int = whole(1)
    """Steps of all hoppers between updates."""
    gradient_steps: int = whole(2)
    """Gradient steps per update."""
    td_steps: int = whole(1)
    """Steps of reward before a critic's own estimate takes over (n-step returns)."""
    tau: float = _share(0.005)
    """Share by which the target critics follow in a gradient step."""
    target_entropy: float = finite(-1.0)
    """Entropy of each limb's action that the temperature is adapted to [nat]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.buffer_size < max(self.batch_size, self.n_envs):
            raise TegotaeError(
                f"buffer_size is {self.buffer_size}; it must hold at least a batch "
                f"({self.batch_size}) and a step of all hoppers ({self.n_envs})"
            )

    def make(self, env: VecEnv, feedback: Feedback, seed: int) -> BaseAlgorithm:
        """Make SB3's SAC with the feedback law as its actor."""
        from tegotae.training.agents.actor import make_sac

        return make_sac(self, env, feedback, seed)


@dataclass(frozen=True, kw_only=True)
class PPOSettings(AgentSettings):
    """Proximal policy optimisation, through Stable-Baselines3.

    The defaults are the settings from which the search began. `tegotae train --algorithm ppo` takes
    those that it found, `tegotae.training.settings.tuned("ppo")`: they differ in `gamma`,
    `learning_rate`, `noise`, `n_steps`, `gae_lambda`, `clip_range` and `ent_coef`. Of the other
    algorithms the defaults are the tuned settings.

    Reference: J. Schulman et al., Proximal policy optimization algorithms, 2017.
    """

    NAME = "ppo"
    TITLE = "PPO"

    batch_size: int = whole(240, least=2)
    """Transitions per gradient step."""
    n_steps: int = whole(120)
    """Actions of each hopper between updates."""
    n_epochs: int = whole(10)
    """Passes over what was gathered, per update."""
    gae_lambda: float = _share(0.95)
    """λ of the generalised advantage estimate."""
    clip_range: float = positive(0.2)
    """Largest change of an action's probability ratio that is rewarded."""
    ent_coef: float = not_negative(0.0)
    """Weight of the entropy bonus."""
    vf_coef: float = not_negative(0.5)
    """Weight of the critic's loss."""
    max_grad_norm: float = positive(0.5)
    """Norm to which gradients are clipped."""

    def __post_init__(self) -> None:
        super().__post_init__()
        gathered = self.n_steps * self.n_envs
        if gathered % self.batch_size:
            raise TegotaeError(
                f"batch_size is {self.batch_size}; it must divide the {gathered} transitions that "
                f"{self.n_envs} hoppers gather in {self.n_steps} steps"
            )

    def make(self, env: VecEnv, feedback: Feedback, seed: int) -> BaseAlgorithm:
        """Make SB3's PPO with the feedback law as its actor."""
        from tegotae.training.agents.actor import make_ppo

        return make_ppo(self, env, feedback, seed)


def agent_controller(experiment: Trainable, settings: AgentSettings) -> Controller:
    """Return an experiment's controller as an agent's deterministic policy, `f = L tanh(G A′ R /
    L)`.

    It has the weights of the experiment's own controller; only its feedback saturates at the
    settings' L, for an agent's action is bounded.

    Args:
        experiment: whose controller.
        settings: the agent's, which have L.

    Raises:
        TegotaeError: for a controller without a meaning for an agent whose action is the feedback.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> from tegotae.training.agents import SACSettings
        >>> controller = agent_controller(recipe("AR").experiment(), SACSettings())
        >>> controller.n_weights, controller.tegotae.limit_rad_per_s
        (96, 40.0)
    """
    controller = experiment.controller
    without = f"{name_of(type(settings))} has no meaning for {experiment.name}:"
    if controller.tegotae is None:
        raise TegotaeError(
            f"{without} an agent's action is the Tegotae feedback, and it has none; use pgpe"
        )
    if experiment.is_searched:
        raise TegotaeError(
            f"{without} it has no network to learn; its gain is found by search, with pgpe"
        )
    if controller.actuation.n_weights:
        raise TegotaeError(
            f"{without} the weights of its actuation come after the agent's action, the feedback, "
            "where no gradient reaches them; take a model without, such as AR, or use pgpe"
        )
    if controller.sets > 1 or controller.coupling is not None:
        raise TegotaeError(
            f"{without} its limbs have weights of their own or a coupling, and an agent learns one "
            "law for all of them; use pgpe"
        )
    limit = settings.max_feedback_rad_per_s
    tegotae = dataclasses.replace(controller.tegotae, limit_rad_per_s=limit)
    return dataclasses.replace(controller, tegotae=tegotae)
