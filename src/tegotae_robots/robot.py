"""A saved controller as the control loop of a robot has it: what is measured, what is commanded;
and its tick as machine code."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, NamedTuple

import jax
import jax.numpy as jnp
import msgspec
import numpy as np

from lanewise.function import compile_function
from lanewise.nodes import CannotLower
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_N
from tegotae.parts._shapes import Number, PerLimb, StateTree
from tegotae.parts.bodies import Body, Interface
from tegotae.parts.channels import FORCE
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.scaled import in_si
from tegotae.parts.terms import Signals
from tegotae.parts.units import Units
from tegotae.simulation.integrators import (
    held,
    largest_force,
    respond,
    settled,
    to_limbs,
    to_units,
)
from tegotae.systems.controller_file import SavedController
from tegotae_robots.live.controller import NativeController

if TYPE_CHECKING:
    from tegotae.envs.mujoco.legs import LegKinematics


class Decision(NamedTuple):
    """Commands and state of the limbs at one instant, in the limbs' own order."""

    command: jax.Array
    """[commands, limbs, lanes]."""
    feedback: jax.Array
    """Feedback f [rad/s], [limbs, lanes]."""
    phase: jax.Array
    """[rad], [limbs, lanes]; zero without an oscillator that has one."""
    rate: StateTree
    """Time derivative of the oscillators' state, unit by unit."""


@dataclass(frozen=True)
class RobotController:
    """A saved controller for a robot.

    Args:
        saved: the controller, its weights, its frequency, and the body that it is for.
        max_force_n: the force α at full push [N], where the controller's file does not have it.

    Raises:
        TegotaeError: for a largest force that is missing, known already or out of range.
    """

    saved: SavedController
    _: KW_ONLY
    max_force_n: float | None = None

    def __post_init__(self) -> None:
        limit_n = self.body.max_force_n
        if self.max_force_n is None:
            if limit_n is None and self.commands == FORCE:
                raise TegotaeError(
                    "the controller's file does not say the largest force; give max_force_n, such "
                    "as that of the wiring that it was trained with"
                )
            return
        require_finite("max_force_n", self.max_force_n, above=0.0, most=MOST_N)
        if limit_n is not None:
            raise TegotaeError(
                f"max_force_n is {self.max_force_n:g}, and the controller's file has its largest "
                "force already; leave it out"
            )

    @functools.cached_property
    def controller(self) -> Controller:
        """Structure of the controller, in SI units."""
        task = self.saved.task
        units = msgspec.UNSET if task is None else task.wiring.units
        if isinstance(units, msgspec.UnsetType):
            return self.saved.controller
        return in_si(self.saved.controller, Units(**msgspec.structs.asdict(units)))

    @property
    def limbs(self) -> int:
        """Number of limbs."""
        return self.controller.limbs

    @property
    def body(self) -> Body | Interface:
        """The body that it is for; the interface of one that moves in another simulator."""
        return self.saved.system.body

    @functools.cached_property
    def legs(self) -> LegKinematics | None:
        """The legs of its MuJoCo model, where it commands feet to places.

        Raises:
            TegotaeError: for a model that is not there any more.
            MissingExtraError: without MuJoCo.
        """
        task = self.saved.task
        if task is None or not task.settings.get("legs"):
            return None
        from tegotae.envs.env_spec import EnvSpec
        from tegotae.envs.mujoco.sensing import sensing

        return sensing(
            EnvSpec(env=task.env, settings=tuple(task.settings.items())).model_settings
        ).legs

    @property
    def feet_m(self) -> tuple[tuple[float, float], ...]:
        """Places of the feet of a robot that takes commands, forward and to the left of its trunk
        [m], limb by limb; empty of others."""
        task, legs = self.saved.task, self.legs if "commanded_speed" in self.senses else None
        if legs is None or task is None:
            return ()
        feet = dict(zip(legs.feet, legs.feet_m[:, :2].tolist(), strict=True))
        names = [limb.senses["commanded_x"] for limb in task.wiring.limbs]
        return tuple(tuple(feet[name.removesuffix("_commanded_x")]) for name in names)

    @property
    def weights(self) -> np.ndarray:
        """The weights as the simulator's float32 has them."""
        return np.asarray(self.saved.weights, np.float32)

    @property
    def senses(self) -> tuple[str, ...]:
        """Signals that the robot must measure: those of the body that a term or coupling reads."""
        sensed = self.body.SENSES if isinstance(self.body, Body) else self.body.senses
        reads = set(self.controller.reads)
        if self.controller.coupling is not None:
            reads.update(self.controller.coupling.READS)
        return tuple(name for name in sensed if name in reads)

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the controller's commands, limb by limb."""
        return self.controller.actuation.COMMANDS

    @property
    def has_phase(self) -> bool:
        """True if there is an oscillator with a phase."""
        oscillator = self.controller.oscillator
        return oscillator is not None and oscillator.has_phase

    @property
    def alpha_n(self) -> Number | None:
        """The largest force α [N]; on an environment in the units of its wiring."""
        return self.body.max_force_n if self.max_force_n is None else self.max_force_n

    @functools.cached_property
    def signal_scales(self) -> dict[str, Number]:
        """Divisors of signals, and of the feedback, for a network."""
        body = self.body
        if isinstance(body, Interface):
            return dict(body.known_scales)

        @jax.jit  # of which only the scales are computed
        def scales(lane: jax.Array) -> dict[str, Number]:
            sensed = body.sense(body.release(lane, lane), lane).scales
            read = {name: sensed[name] for name in self.senses if name in sensed}
            return {**read, "feedback": body.rate_scale}

        with jax.ensure_compile_time_eval():  # a trace may be under way
            return jax.tree.map(np.asarray, scales(jnp.ones((1,), jnp.float32)))

    def decide(
        self,
        omega: PerLimb,
        oscillator: StateTree,
        sensed: Mapping[str, PerLimb],
        scales: Mapping[str, Number] | None = None,
        *,
        ahead_s: Number | None = None,
    ) -> Decision:
        """Evaluate the controller once.

        Args:
            omega: ω [rad/s], [(limbs,) lanes].
            oscillator: the oscillators' state.
            sensed: what the limbs feel, by signal, [(limbs,) lanes] each.
            ahead_s: time that a force is to be the mean of [s]; by default it is that of now.
        """
        controller, scales = self.controller, scales or self.signal_scales
        rows = controller.spread(tuple(self.weights[:, None]))
        felt = {name: to_units(controller, x) for name, x in sensed.items()}
        limit = 1.0 if self.alpha_n is None else self.alpha_n  # which places of feet do without
        limit = largest_force(self.body) if isinstance(self.body, Body) else limit
        response = respond(
            *(controller, rows, omega, Signals(felt, scales), oscillator, limit),
            rate_scale=scales.get("feedback"),
            ahead_s=ahead_s,
        )
        drive, phase = response.drive, response.phase_rad
        command = to_limbs(controller, response.push).mean_n
        shape = jnp.shape(omega)
        return Decision(
            jnp.reshape(command, (len(self.commands), self.limbs, -1)),
            self._in_order_of_limbs(jnp.broadcast_to(drive.feedback, shape)),
            self._in_order_of_limbs(jnp.broadcast_to(phase, shape)),
            drive.rate,
        )

    def _in_order_of_limbs(self, of_units: PerLimb) -> jax.Array:
        """Return values of units in the order of the limbs, [limbs, lanes]."""
        x = jnp.reshape(of_units, (self.limbs, -1))
        wiring = self.controller.wiring
        if wiring is None:
            return x
        return jnp.stack([x[wiring.index(limb)] for limb in range(self.limbs)])


def compiled(saved: SavedController, max_force_n: float | None = None) -> NativeController:
    """Compile a saved controller for this kind of processor: one tick for one robot.

    The oscillators advance at the rate of the last step for as long as has passed since; then the
    controller is evaluated, and its command holds until the next step. At equal steps that is
    `Hold`, and what an exported C program does.

    The code takes `signals`, `omega` and `elapsed_s`, and gives `command`, `phase_rad`,
    `feedback_rad_per_s`, and whether all of them and the next state are `finite`; if not, state and
    outputs stay as they were.

    Args:
        saved: the controller.
        max_force_n: the force at full push [N], where the file does not know it.

    Raises:
        TegotaeError: for a largest force that is missing, known already or out of range; for an
            operation that has no native code.
    """
    robot = RobotController(saved, max_force_n=max_force_n)
    controller = robot.controller
    shape = (*controller.limb_shape, 1)
    began = _started(robot)
    leaves, structure = jax.tree.flatten(began)

    def tick(
        state: dict[str, StateTree], inputs: dict[str, StateTree]
    ) -> tuple[dict[str, StateTree], dict[str, jax.Array]]:
        omega = jnp.broadcast_to(inputs["omega"], shape)
        oscillator = jax.tree.unflatten(structure, state["oscillator"])
        oscillator = settled(controller, held(oscillator, state["rate"], inputs["elapsed_s"]))
        decision = robot.decide(omega, oscillator, inputs["signals"])
        outputs = {
            "command": decision.command,
            "phase_rad": decision.phase,
            "feedback_rad_per_s": decision.feedback,
        }
        results = {
            "oscillator": jax.tree.leaves(oscillator),
            "outputs": outputs,
            "rate": jax.tree.leaves(decision.rate),
        }
        finite = jnp.stack([jnp.isfinite(x).all() for x in jax.tree.leaves(results)]).all()
        results = jax.tree.map(lambda new, old: jnp.where(finite, new, old), results, state)
        return results, {**results["outputs"], "finite": finite}

    of_limbs = np.zeros((robot.limbs, 1), np.float32)
    state = {
        "oscillator": leaves,
        "outputs": {
            "command": np.zeros((len(robot.commands), robot.limbs, 1), np.float32),
            "phase_rad": of_limbs,
            "feedback_rad_per_s": of_limbs,
        },
        "rate": [jnp.zeros_like(x) for x in leaves],
    }
    number, signal = np.float32(0.0), np.zeros(shape, np.float32)
    inputs = {
        "signals": dict.fromkeys(robot.senses, signal),
        "omega": number,
        "elapsed_s": number,
    }
    try:
        kernel = compile_function(tick, state, inputs)
    except CannotLower as error:
        raise TegotaeError(str(error)) from None
    names = [name for name, _, _ in kernel.layout[0]]
    numbers = [np.asarray(x).tolist() for x in jax.tree.leaves(state)]
    by_phase = type(controller.oscillator) is PhaseOscillator
    return NativeController(
        name=saved.name,
        senses=robot.senses,
        commands=robot.commands,
        limbs=robot.limbs,
        omega_rad_per_s=saved.omega,
        phase_entry=next(x for x in names if x.startswith("oscillator")) if by_phase else None,
        start=dict(zip(names, numbers, strict=True)),
        code=kernel.to_bytes(),
        feet_m=robot.feet_m,
    )


def _started(robot: RobotController) -> StateTree:
    """Return the oscillators at the release, at its phases."""
    controller, system = robot.controller, robot.saved.system
    if controller.oscillator is None:
        return ()
    release = system.release.scenario(system.omega)
    phases = np.broadcast_to(
        np.asarray(release.phase_rad, np.float32).reshape(-1, 1), (robot.limbs, 1)
    )
    start = jnp.asarray(phases.reshape((*controller.limb_shape, 1)))
    state = {name: jnp.full_like(start, x) for name, x in dict(release.oscillator_state).items()}
    return controller.oscillator.start(start, **state)
