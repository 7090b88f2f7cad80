"""The export: a controller, the tick of its robot, and the data of the C code."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.export.c.names import UNITS, is_c_name
from tegotae.export.c.trace import Piece, Tracer
from tegotae.parts._shapes import Number
from tegotae.parts.bodies import Body, Hopper, Interface
from tegotae.parts.channels import FORCE
from tegotae.parts.terms import WholeBody
from tegotae.simulation.integrators import Hold
from tegotae.systems.controller_file import SavedController
from tegotae.systems.controller_set import EnvTask

MOST_LIMBS = 32
LEAST_TICK_S, MOST_TICK_S = 1e-5, 1.0


@dataclass(frozen=True)
class Export:
    """A saved controller as a program for a robot whose loop has this period.

    The robot evaluates the controller at the start of each tick and holds what it says for that
    tick: the package's `Hold` integrator at the same period. What was trained on an environment
    does as it did there: a force that is switched on in a sector of the phase is its mean over the
    tick.

    Args:
        saved: the controller, its weights, its frequency, and the body that it is for.
        tick_s: period of the robot's control loop [s].
        prefix: what all names in C begin with.

    Raises:
        TegotaeError: for a period that no control loop or that body can have, a prefix that
            is no name in C, or a controller that is not made of a unit a limb.

    Example:
        >>> from tegotae.systems.models import build
        >>> saved = SavedController.of(build("V-reflex-w8"), np.array([2.0]), 8.0)
        >>> Export(saved, prefix="leg").senses
        ('spring_force',)
    """

    saved: SavedController
    tick_s: float = 0.001
    prefix: str = "tegotae"

    def __post_init__(self) -> None:
        require_finite("tick", self.tick_s, above=0.0)
        if not is_c_name(self.prefix):
            raise TegotaeError(
                f"prefix is {self.prefix!r}, which is no name in C; begin with a letter, and go on "
                "with letters, digits and underscores, such as left_leg (31 at most)"
            )
        if isinstance(self.body, Body):
            self.body.check_tick(self.tick_s)
        elif self.body.max_force_n is None and self.commands == FORCE:
            raise TegotaeError(
                "the controller's file does not say the largest force alpha; train it anew "
                "(tegotae train --env), with max_force in its wiring"
            )
        if not LEAST_TICK_S <= self.tick_s <= MOST_TICK_S:
            raise TegotaeError(
                f"tick is {self.tick_s:g}; the period of a robot's control loop is from "
                f"{LEAST_TICK_S:g} to {MOST_TICK_S:g} s (a phase in float32 does not advance "
                "evenly in shorter ones)"
            )
        if self.limbs > MOST_LIMBS:
            raise TegotaeError(
                f"the controller has {self.limbs} limbs; at most {MOST_LIMBS} can be exported"
            )
        if isinstance(actuation := self.saved.controller.actuation, WholeBody):
            raise TegotaeError(
                f"a {type(actuation).__name__} cannot be exported: it is one network over all "
                "limbs, and what is exported is a unit a limb"
            )

    @property
    def limbs(self) -> int:
        """How many limbs there are."""
        return self.saved.controller.limbs

    @property
    def body(self) -> Body | Interface:
        """The body that it is for; the interface of one that moves in another simulator."""
        return self.saved.system.body

    @property
    def max_force_n(self) -> Number | None:
        """The largest force α [N]; on an environment in the units of its wiring."""
        return self.body.max_force_n

    @property
    def averages(self) -> bool:
        """Whether the force is its mean over a tick, as limbs on an environment have it.

        On a body of the package the force is that of the tick's start, as with `Hold`.
        """
        return isinstance(self.body, Interface) and self.saved.controller.actuation.needs_phase

    @property
    def senses(self) -> tuple[str, ...]:
        """What the robot must measure: signals of the body that its terms read."""
        controller, body = self.saved.controller, self.body
        sensed = body.SENSES if isinstance(body, Body) else body.senses
        reads = [name for term in controller.terms.values() for name in term.reads]
        if controller.coupling is not None:
            reads += controller.coupling.READS
        return tuple(name for name in sensed if name in reads)

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """What signals are divided by before a network sees them, in their own units."""
        body = self.body
        if isinstance(body, Interface):
            return body.known_scales

        @jax.jit  # of which only the scales are computed
        def scales(lane: jax.Array) -> dict[str, Number]:
            sensed = body.sense(body.release(lane, lane), lane).scales
            own = {name: sensed[name] for name in self.senses if name in sensed}
            return {**own, "feedback": body.rate_scale}

        found = scales(jnp.ones((1,), jnp.float32))
        for name, scale in found.items():
            if np.size(scale) != 1:
                raise TegotaeError(
                    f"the scale of {name} differs from limb to limb, which cannot be exported"
                )
        return {name: float(np.asarray(scale).reshape(())) for name, scale in found.items()}

    @property
    def commands(self) -> tuple[str, ...]:
        """What the controller commands, limb by limb."""
        return self.saved.controller.actuation.COMMANDS

    @property
    def has_phase(self) -> bool:
        """Whether there is an oscillator with a phase."""
        oscillator = self.saved.controller.oscillator
        return oscillator is not None and oscillator.has_phase

    @property
    def weights(self) -> np.ndarray:
        """The weights as the simulator's float32 has them."""
        return np.asarray(self.saved.weights, np.float32)

    @property
    def trained_tick_s(self) -> float | None:
        """The control period of the training [s], if the file has it."""
        if self.saved.task is not None:
            return control_period_s(self.saved.task)
        trained = self.saved.experiment
        return None if trained is None else trained.timing.tick_s

    @property
    def trained_held(self) -> bool:
        """Whether the training held the controller over its ticks, as the robot does."""
        trained = self.saved.experiment
        return trained is not None and isinstance(trained.system.integrator, Hold)

    def warnings(self) -> list[str]:
        """What an author should know before the robot runs, a line each."""
        trained = self.trained_tick_s
        if trained is not None and abs(trained - self.tick_s) > 1e-9:
            hops = isinstance(self.body, Hopper)
            command = f"tegotae simulate FILE --hold --tick {self.tick_s:g}"
            return [
                f"the controller was trained at a tick of {trained:g} s and is exported for "
                f"{self.tick_s:g} s" + (f"; see how it does there: {command}" if hops else "")
            ]
        return []

    @functools.cached_property
    def tracer(self) -> Tracer:
        """What traces its parts."""
        return Tracer(self.saved.controller, self.senses, tuple(self.scales))

    @functools.cached_property
    def pieces(self) -> dict[str, Piece]:
        """The functions that a tick is made of.

        Raises:
            TegotaeError: for an operation that has no C, by its name.
        """
        controller, tracer = self.saved.controller, self.tracer
        unit = controller.unit_weight_names
        pieces = {}
        if controller.oscillator is not None:
            pieces["started"] = tracer.start()
            pieces["rhythm"] = tracer.rhythm()
            if self.has_phase:
                pieces["phase_of"] = tracer.phase()
        if controller.coupling is not None:
            pieces["coupling"] = tracer.coupling(
                controller.coupling.weight_names(controller.limbs), controller.coupling.READS
            )
        for role, term in controller.terms.items():
            pieces[f"{role}_term"] = tracer.term(role, term, unit[role])
        pieces["feedback_law"] = tracer.feedback()
        if self.averages:
            pieces["phase_after"] = tracer.phase_after(unit.get("oscillator", ()))
        pieces["command_law"] = tracer.command(averaged=self.averages)
        if controller.oscillator is not None:
            pieces["advanced"] = tracer.advance(unit.get("oscillator", ()))
        return pieces


def control_period_s(task: EnvTask) -> float | None:
    """The control period of a training on an environment [s], if its file says it."""
    own = task.settings.get("control_s", task.wiring.step_s)
    return float(own) if isinstance(own, int | float) else None


def usual_tick_s(saved: SavedController) -> float:
    """The control period that an export has by default [s].

    That of the training on an environment, where the file says it, and otherwise a millisecond.
    """
    own = None if saved.task is None else control_period_s(saved.task)
    return 0.001 if own is None else own


def unit_of(name: str) -> tuple[str, str]:
    """The unit of a signal: as part of a name in C, and as people write it."""
    return UNITS.get(name, ("", "the unit of the body's sense"))


def member(name: str) -> str:
    """A signal's name with its unit, as a member of a struct.

    Example:
        >>> member("spring_force"), member("whiskers")
        ('spring_force_n', 'whiskers')
    """
    suffix = unit_of(name)[0]
    return f"{name}_{suffix}" if suffix else name
