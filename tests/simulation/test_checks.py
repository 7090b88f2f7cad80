"""The checks tell an extender what is wrong with a new term, oscillator or body, in one line."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tegotae
from refusals import refused
from tegotae import TegotaeError, check
from tegotae.parts.bodies import Hopper
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import (
    Clamped,
    FootholdOscillator,
    Oscillator,
    PhaseOscillator,
    PhaseState,
    WaryOscillator,
)
from tegotae.parts.parameters import traceable
from tegotae.parts.terms import (
    ConstantGain,
    EllipticFoot,
    LearnedActuation,
    LearnedFoot,
    Network,
    PacedFoot,
    Reflex,
    Sector,
    SectorAndReflex,
    SteppingFoot,
    Term,
    TiltReaction,
    VanillaAction,
    VanillaReaction,
    WaryFoot,
)


@pytest.mark.parametrize(
    "term",
    [
        VanillaAction(),
        VanillaReaction(),
        ConstantGain(),
        Network(("phase", "spring_force", "velocity"), hidden=3),
        Sector(),
        EllipticFoot(),
        LearnedFoot(("phase",), 3),
        PacedFoot(),
        WaryFoot(),
        TiltReaction(),
        SteppingFoot(),
        Reflex(),
        SectorAndReflex(),
        LearnedActuation(("phase", "feedback"), hidden=3),
    ],
    ids=lambda term: type(term).__name__,
)
def test_every_term_of_the_package_passes(term):
    check(term)


@pytest.mark.parametrize(
    "oscillator",
    [
        PhaseOscillator(),
        PhaseOscillator(slowest_rad_per_s=1.0),
        Clamped(PhaseOscillator()),
        WaryOscillator(),
        FootholdOscillator(),
    ],
    ids=repr,
)
def test_every_oscillator_of_the_package_passes(oscillator):
    check(oscillator)


def test_a_hopper_of_other_numbers_passes():
    check(Hopper(mass_kg=2, stiffness_n_per_m=400, flight_damping_ns_per_m=0.1))


def test_a_learned_controller_and_the_single_network_pass_on_the_hopper():
    check(tegotae.recipe("ART").controller(budget=20), Hopper())
    check(tegotae.recipe("T-Fv").controller(budget=12), Hopper())


def broken(name, sound, **members):
    """An instance of a part of this name that differs from a sound one in some members."""
    decorate = dataclass(frozen=True, kw_only=issubclass(sound, Hopper))
    kind = decorate(type(name, (sound,), {"__module__": __name__, **members}))
    return traceable(kind)() if issubclass(sound, Hopper) else kind()


def breaches(sound, rows):
    """Parts that break one promise each, by name, with what is said of them."""
    return [
        pytest.param(broken(name, sound, **members), rf"\b{name}\b.*{message}", id=name)
        for name, (members, message) in rows.items()
    ]


def assert_refused(part, message):
    refused(message, check, part)


# Terms


@dataclass(frozen=True)
class Sound(Term):
    """A sound term, of which each of the following breaks one promise."""

    READS = ("spring_force",)

    @property
    def n_weights(self):
        return 1

    def __call__(self, weights, signals):
        return weights[0] * signals["spring_force"]


class NoDataclass(Sound):
    def __init__(self, size):
        self.size = size


@dataclass(frozen=True)
class Holds(Sound):
    table: Any = None

    def __post_init__(self):
        object.__setattr__(self, "table", self.content())


def valued(function):
    """Return the method for a term's value, a function of its one weight and the spring force."""
    return {"__call__": lambda self, weights, signals: function(weights, signals["spring_force"])}


def reading(function):
    return {"__call__": lambda self, weights, signals: weights[0] * function(signals)}


ELEMENTWISE = r"\.__call__ lets one lane change another.*elementwise"
UNDECLARED = r"'velocity'.*add 'velocity' to what `reads`"
IN_PYTHON = r"\.__call__ uses an array's value in Python.*jnp"
TERMS = {
    "ReadsAString": ({"READS": "spring_force"}, r"\.reads is 'spring_force'.*\('spring_force',\)"),
    "CountIsAMethod": ({"n_weights": lambda self: 1}, r"\.n_weights.*a property, not a method"),
    "WrongInitial": (
        {"initial": lambda self, key: jnp.zeros(3)},
        r"\.initial returns shape \(3,\); it must be \(1,\)",
    ),
    "InfiniteInitial": (
        {"initial": lambda self, key: jnp.full(1, jnp.inf)},
        r"\.initial.*not finite",
    ),
    "Scalar": (
        valued(lambda w, x: jnp.asarray(1.0)),
        r"\.__call__ has shape \(\).*shape of the lanes",
    ),
    "Nothing": (
        valued(lambda w, x: None),
        r"\.__call__ returns a NoneType; it must return one array",
    ),
    "Averages": (valued(lambda w, x: w[0] * x.mean()), ELEMENTWISE),
    "Neighbour": (valued(lambda w, x: jnp.roll(x, 1)), ELEMENTWISE),
    "IgnoresNaN": (valued(lambda w, x: x - jnp.nanmin(x)), ELEMENTWISE),
    "Halves": (
        valued(lambda w, x: x.astype("float16")),
        r"\.__call__ is float16 for float32 lanes; it must keep",
    ),
    "Narrows": (
        valued(lambda w, x: x.astype("float32")),
        r"\.__call__ is float32 for float64 lanes",
    ),
    "Branches": (valued(lambda w, x: w[0] if x[0] > 0 else -w[0]), IN_PYTHON + r"\.where"),
    "UsesNumpy": (valued(lambda w, x: jnp.asarray(np.tanh(np.asarray(x)))), IN_PYTHON),
    "Diverges": (valued(lambda w, x: jnp.log(-x)), r"\.__call__ is not finite"),
    "TooManyWeights": (valued(lambda w, x: w[4] * x), r"\.__call__ raised IndexError"),
}
HOLDING = {
    "Unhashable": ({"content": lambda self: [1.0]}, "cannot be hashed.*use tuples"),
    "ComparesArrays": (
        {"content": lambda self: np.ones(2), "__hash__": lambda self: 1},
        "cannot be compared.*copy of itself",
    ),
}


def sector(change):
    """Return the method of a sector that changes its full force."""
    return {"full_force": lambda self, *path: change(*Sector.full_force(self, *path))}


SECTORS = {
    "ShareAboveOne": (
        sector(lambda share, centre: (share + 2.0, centre)),
        r"\.full_force returns a share outside 0 \.\.\. 1",
    ),
    "ShareAlone": (
        sector(lambda share, centre: share),
        r"\.full_force must return None, or a pair",
    ),
}


FEET = {
    "FlatPlace": (
        {"__call__": lambda self, w, s: EllipticFoot.__call__(self, w, s)[0]},
        r"\.__call__ has shape \(6,\) .* must have shape \(2, 6\), foot_x, foot_z first",
    ),
    "PacedFlat": (
        {"paced": lambda self, w, command, omega: command[0]},
        r"\.paced has shape \(6,\) .* must have shape \(2, 6\), foot_x, foot_z first",
    ),
    "PacedTogether": (
        {"paced": lambda self, w, command, omega: command * omega.mean()},
        r"\.paced .* lane",
    ),
}


@pytest.mark.parametrize(
    ("term", "message"),
    [
        *breaches(Sound, TERMS),
        *breaches(EllipticFoot, FEET),
        *breaches(Holds, HOLDING),
        *breaches(Sector, SECTORS),
        (broken("ReadsInSecret", Sound, **reading(lambda s: s["velocity"])), UNDECLARED),
        (
            broken("Dimensionless", Sound, **reading(lambda s: s.dimensionless("velocity"))),
            UNDECLARED,
        ),
        (NoDataclass(3), r"NoDataclass is no frozen dataclass; put @dataclass\(frozen=True\)"),
        (Sound, r"Sound is a class; check an instance"),
        (Term, r"Term is a class.*define __call__ first"),
        (lambda weights, signals: 1.0, r"function is no Term or Oscillator or Body or Metric"),
    ],
    ids=lambda x: getattr(x, "__name__", type(x).__name__),
)
def test_a_breach_of_the_term_contract_is_named_in_one_line(term, message):
    assert_refused(term, message)


# Oscillators


def rate(function):
    return {"rate": lambda self, state, omega, feedback: function(omega, feedback)}


def settles(function):
    return {"settle": lambda self, state: function(state[0])}


def swapped(self, state):
    return jnp.cos(state[0]), jnp.sin(state[0])


TURN = 2 * jnp.pi
OSCILLATORS = {
    "NeverWraps": (settles(PhaseState), r"\.phase leaves \[0, 2π\) after `settle`.*wrap_phase"),
    "WrapsInPhase": (
        {
            "phase": lambda self, state: jnp.mod(state[0], TURN),
            **settles(lambda phase: PhaseState(jnp.mod(phase, TURN))),
        },
        r"\.phase jumps.*wrap it in `settle` only",
    ),
    "WrapsToMinusPi": (
        settles(lambda phase: PhaseState(jnp.mod(phase + jnp.pi, TURN) - jnp.pi)),
        r"\.phase leaves \[0, 2π\) after `settle`",
    ),
    "BareRate": (rate(lambda omega, f: omega + f), r"\.rate returns.*a tuple of 1"),
    "TwoRates": (
        rate(lambda omega, f: (omega, f)),
        r"\.rate returns 2; it must return a tuple of 1",
    ),
    "ScalarRate": (
        rate(lambda omega, f: (jnp.asarray(1.0, omega.dtype),)),
        r"\.rate has shape \(\)",
    ),
    "SharedRate": (
        rate(lambda omega, f: (omega + f.max(),)),
        r"\.rate lets one lane change another",
    ),
    "BareState": (
        {"start": lambda self, phase_rad: phase_rad},
        r"\.start returns.*must return a tuple",
    ),
    "StartsElsewhere": (
        {"start": lambda self, phase_rad: PhaseState(phase_rad + 1.0)},
        r"\.phase of StartsElsewhere\.start\(φ\) is",
    ),
    "ForgetsItsForm": (
        settles(lambda phase: (phase,)),
        r"\.settle.* returns tuple of 1.*PhaseState of 1",
    ),
    "ForgetsASignal": (
        {"SIGNALS": ("sin_phase", "cos_phase", "amplitude")},
        r"\.signals gives .*; SIGNALS names amplitude",
    ),
    "KeepsNoAlarm": (
        {"STATE": ("alarm",)},
        r"\.STATE names alarm, which its state lacks.*named tuples",
    ),
    "MiscountsItsWeights": (
        {"n_weights": property(lambda self: 2), "initial": lambda self, key: jnp.zeros(3)},
        r"\.initial returns shape \(3,\); it must be \(2,\)",
    ),
}


@pytest.mark.parametrize(
    ("oscillator", "message"),
    [
        *breaches(PhaseOscillator, OSCILLATORS),
        (broken("Swapped", PhaseOscillator, sin_cos=swapped), r"the sine of Swapped\.sin_cos is"),
        (Oscillator, r"Oscillator is a class.*define rate, start first"),
        (5.0, r"float is no Term or Oscillator or Body"),
    ],
    ids=lambda x: getattr(x, "__name__", type(x).__name__),
)
def test_a_breach_of_the_oscillator_contract_is_named_in_one_line(oscillator, message):
    assert_refused(oscillator, message)


# Bodies


@dataclass(frozen=True, kw_only=True)
class NoPytree(Hopper):
    pass


class Reversed(NamedTuple):
    velocity: jax.Array
    height: jax.Array


def advances(change):
    """Return the method that advances a hopper by a function of the state before, that after, and
    the contact."""
    return {
        "advance": lambda self, state, *arguments: change(
            state, *Hopper.advance(self, state, *arguments)
        )
    }


def senses(self, state, ground_m):
    sensation = Hopper.sense(self, state, ground_m)
    return sensation._replace(scales={"spring_force": 1.0, "height": 1.0})


def falls_upwards(self, state, *arguments):
    guess, *stance = Hopper.predict(self, state, *arguments)
    return guess._replace(velocity=2.0 * state.velocity - guess.velocity), *stance


BODIES = {
    "ExtraSense": (
        {"SENSES": (*Hopper.SENSES, "tilt")},
        r"\.sense gives .*; SENSES names .*tilt.*must be the same",
    ),
    "NoScale": ({"sense": senses}, r"\.sense gives no scale for velocity"),
    "Weightless": (
        {"rate_scale": property(lambda self: 0.0)},
        r"\.rate_scale is 0; it must be greater than 0",
    ),
    "NumericalFailed": (
        {"failed": lambda self, state, ground_m: state.height - ground_m},
        r"\.failed is float32 for bool lanes",
    ),
    "TalkingLanes": (
        {"failed": lambda self, state, ground_m: state.height < state.height.mean()},
        r"\.failed lets one lane change another",
    ),
    "LosesItsState": (
        advances(lambda _, end, contact: (Reversed(end.velocity, end.height), contact)),
        r"\.advance returns Reversed of 2.*HopperState of 2",
    ),
    "PercentContact": (
        advances(lambda _, end, c: (end, c._replace(stance_share=100.0 * c.stance_share))),
        r"\.advance's stance_share is 100, .* must be a share",
    ),
    "ApexEverywhere": (
        advances(lambda _, end, contact: (end, contact._replace(apex_height_m=end.height))),
        r"\.advance's apex_share and apex_height_m must be NaN on",
    ),
    "FallsUpwardsInItsGuess": (
        {"predict": falls_upwards},
        r"\.predict does not approach advance",
    ),
    "VelocityDownwards": (
        advances(lambda old, end, c: (end._replace(height=2.0 * old.height - end.height), c)),
        r"\..*(predict|velocity).*check",
    ),
    "PerpetualMotion": (  # negative damping: a hopper that speeds itself up
        {"__post_init__": lambda self: object.__setattr__(self, "damping_ns_per_m", -0.2)},
        "makes energy from nothing, without the actuator",
    ),
    "WorkForNothing": (
        advances(lambda _, end, contact: (end, contact._replace(work_j=-contact.work_j))),
        "makes energy from nothing, beyond the actuator's",
    ),
}


@pytest.mark.parametrize(
    ("body", "message"),
    [
        *breaches(Hopper, BODIES),
        (NoPytree(), r"NoPytree is no pytree; put @tegotae\.parts\.parameters\.traceable"),
        (Hopper, r"Hopper is a class; check an instance"),
    ],
    ids=lambda x: getattr(x, "__name__", type(x).__name__),
)
def test_a_breach_of_the_body_contract_is_named_in_one_line(body, message):
    assert_refused(body, message)


# Controllers


def test_a_controller_is_refused_for_its_worst_part():
    vanilla = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    averages = broken("Averages", Sound, **TERMS["Averages"][0])
    for controller, message in [
        (Controller(VanillaAction(), PhaseOscillator(), vanilla), "cannot be the actuation"),
        (Controller(Reflex(), None, vanilla), "no oscillator"),
        (
            Controller(
                Reflex(), PhaseOscillator(), Tegotae(averages, *_reaction_and_gain(vanilla))
            ),
            "Averages.__call__ lets one lane change another",
        ),
    ]:
        with pytest.raises(TegotaeError, match=message):
            check(controller, Hopper())


def test_a_controller_is_checked_on_the_hopper_by_default_and_no_other_part_takes_a_body():
    check(tegotae.recipe("V-reflex-w4").controller())
    refused("body belongs to the check of a controller", lambda: check(VanillaAction(), Hopper()))


def _reaction_and_gain(terms):
    return terms.reaction, terms.gain


def test_a_controller_that_reads_what_the_body_does_not_sense_is_refused():
    controller = Controller(LearnedActuation(("tilt",), hidden=1))
    refused("the actuation term reads 'tilt'", lambda: check(controller, Hopper()))
