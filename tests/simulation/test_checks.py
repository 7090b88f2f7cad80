"""The checks tell an extender what is wrong with a new term, oscillator or body, in one line."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tegotae
from tegotae import TegotaeError, check_body, check_controller, check_oscillator, check_term
from tegotae.parts.bodies import Hopper
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import (
    Clamped,
    Oscillator,
    PhaseOscillator,
    PhaseState,
)
from tegotae.parts.parameters import traceable
from tegotae.parts.terms import (
    ConstantGain,
    LearnedActuation,
    Network,
    Reflex,
    Sector,
    SectorAndReflex,
    Term,
    VanillaAction,
    VanillaReaction,
)


@pytest.mark.parametrize(
    "term",
    [
        VanillaAction(),
        VanillaReaction(),
        ConstantGain(),
        Network(("phase", "spring_force", "velocity"), hidden=3),
        Sector(),
        Reflex(),
        SectorAndReflex(),
        LearnedActuation(("phase", "feedback"), hidden=3),
    ],
    ids=lambda term: type(term).__name__,
)
def test_every_term_of_the_package_passes(term):
    check_term(term)


@pytest.mark.parametrize(
    "oscillator",
    [PhaseOscillator(), PhaseOscillator(slowest_rad_per_s=1.0), Clamped(PhaseOscillator())],
    ids=repr,
)
def test_every_oscillator_of_the_package_passes(oscillator):
    check_oscillator(oscillator)


def test_a_hopper_of_other_numbers_passes():
    check_body(Hopper(mass_kg=2, stiffness_n_per_m=400, flight_damping_ns_per_m=0.1))


def test_a_learned_controller_and_the_single_network_pass_on_the_hopper():
    check_controller(tegotae.build("ART", budget=20), Hopper())
    check_controller(tegotae.build("T-Fv", budget=12), Hopper())


# Terms


@dataclass(frozen=True)
class Sound(Term):
    """A sound term, of which each of the following breaks one promise."""

    @property
    def reads(self):
        return ("spring_force",)

    @property
    def n_weights(self):
        return 1

    def __call__(self, weights, signals):
        return weights[0] * signals["spring_force"]


@dataclass(frozen=True)
class ReadsAString(Sound):
    @property
    def reads(self):
        return "spring_force"


@dataclass(frozen=True)
class ReadsInSecret(Sound):
    def __call__(self, weights, signals):
        return weights[0] * signals["velocity"]


@dataclass(frozen=True)
class ReadsInSecretDimensionless(Sound):
    def __call__(self, weights, signals):
        return weights[0] * signals.dimensionless("velocity")


@dataclass(frozen=True)
class CountIsAMethod(Sound):
    def n_weights(self):
        return 1


@dataclass(frozen=True)
class WrongInitial(Sound):
    def initial(self, key):
        return jnp.zeros(3)


@dataclass(frozen=True)
class InfiniteInitial(Sound):
    def initial(self, key):
        return jnp.full(1, jnp.inf)


@dataclass(frozen=True)
class Scalar(Sound):
    def __call__(self, weights, signals):
        return jnp.asarray(1.0)


@dataclass(frozen=True)
class Nothing(Sound):
    def __call__(self, weights, signals):
        return None


@dataclass(frozen=True)
class Averages(Sound):
    def __call__(self, weights, signals):
        return weights[0] * signals["spring_force"].mean()


@dataclass(frozen=True)
class Neighbour(Sound):
    def __call__(self, weights, signals):
        return jnp.roll(signals["spring_force"], 1)


@dataclass(frozen=True)
class IgnoresNaN(Sound):
    def __call__(self, weights, signals):
        return signals["spring_force"] - jnp.nanmin(signals["spring_force"])


@dataclass(frozen=True)
class Halves(Sound):
    def __call__(self, weights, signals):
        return signals["spring_force"].astype("float16")


@dataclass(frozen=True)
class Narrows(Sound):
    def __call__(self, weights, signals):
        return signals["spring_force"].astype("float32")


@dataclass(frozen=True)
class Branches(Sound):
    def __call__(self, weights, signals):
        return weights[0] if signals["spring_force"][0] > 0 else -weights[0]


@dataclass(frozen=True)
class UsesNumpy(Sound):
    def __call__(self, weights, signals):
        return jnp.asarray(np.tanh(np.asarray(signals["spring_force"])))


@dataclass(frozen=True)
class Diverges(Sound):
    def __call__(self, weights, signals):
        return jnp.log(-signals["spring_force"])


@dataclass(frozen=True)
class TooManyWeights(Sound):
    def __call__(self, weights, signals):
        return weights[4] * signals["spring_force"]


@dataclass(frozen=True)
class Unhashable(Sound):
    table: Any = None

    def __post_init__(self):
        object.__setattr__(self, "table", [1.0])


@dataclass(frozen=True)
class ComparesArrays(Sound):
    table: Any = None

    def __post_init__(self):
        object.__setattr__(self, "table", np.ones(2))

    def __hash__(self):
        return 1


class NoDataclass(Sound):
    def __init__(self, size):
        self.size = size


@dataclass(frozen=True)
class ShareAboveOne(Sector):
    def full_force(self, phase_start, phase_end, omega):
        share, centre = super().full_force(phase_start, phase_end, omega)
        return share + 2.0, centre


@dataclass(frozen=True)
class ShareAlone(Sector):
    def full_force(self, phase_start, phase_end, omega):
        return super().full_force(phase_start, phase_end, omega)[0]


@pytest.mark.parametrize(
    ("term", "message"),
    [
        (ReadsAString(), r"ReadsAString\.reads is 'spring_force'.*\('spring_force',\)"),
        (ReadsInSecret(), r"'velocity'.*add 'velocity' to what `reads`"),
        (ReadsInSecretDimensionless(), r"'velocity'.*add 'velocity' to what `reads`"),
        (CountIsAMethod(), r"CountIsAMethod\.n_weights.*a property, not a method"),
        (WrongInitial(), r"WrongInitial\.initial returns shape \(3,\); it must be \(1,\)"),
        (InfiniteInitial(), r"InfiniteInitial\.initial.*not finite"),
        (Scalar(), r"Scalar\.__call__ has shape \(\).*shape of the lanes"),
        (Nothing(), r"Nothing\.__call__ returns a NoneType; it must return one array"),
        (Averages(), r"Averages\.__call__ lets one lane change another.*elementwise"),
        (Neighbour(), r"Neighbour\.__call__ lets one lane change another.*elementwise"),
        (IgnoresNaN(), r"IgnoresNaN\.__call__ lets one lane change another.*elementwise"),
        (Halves(), r"Halves\.__call__ is float16 for float32 lanes; it must keep"),
        (Narrows(), r"Narrows\.__call__ is float32 for float64 lanes"),
        (Branches(), r"Branches\.__call__ uses an array's value in Python.*jnp\.where"),
        (UsesNumpy(), r"UsesNumpy\.__call__ uses an array's value in Python.*jnp"),
        (Diverges(), r"Diverges\.__call__ is not finite"),
        (TooManyWeights(), r"TooManyWeights\.__call__ raised IndexError"),
        (Unhashable(), r"Unhashable cannot be hashed.*use tuples"),
        (ComparesArrays(), r"ComparesArrays cannot be compared.*copy of itself"),
        (NoDataclass(3), r"NoDataclass is no frozen dataclass; put @dataclass\(frozen=True\)"),
        (ShareAboveOne(), r"ShareAboveOne\.full_force returns a share outside 0 \.\.\. 1"),
        (ShareAlone(), r"ShareAlone\.full_force must return None, or a pair"),
        (Sound, r"Sound is a class; check an instance"),
        (Term, r"Term is a class.*define __call__ first"),
        (lambda weights, signals: 1.0, r"function is no Term; make it a subclass of"),
    ],
    ids=lambda x: getattr(x, "__name__", type(x).__name__),
)
def test_a_breach_of_the_term_contract_is_named_in_one_line(term, message):
    with pytest.raises(TegotaeError, match=message) as error:
        check_term(term)
    assert "\n" not in str(error.value)


# Oscillators


@dataclass(frozen=True)
class SoundOscillator(PhaseOscillator):
    """A sound oscillator, of which each of the following breaks one promise."""


@dataclass(frozen=True)
class NeverWraps(SoundOscillator):
    def settle(self, state):
        return PhaseState(*state)


@dataclass(frozen=True)
class WrapsInPhase(SoundOscillator):
    def phase(self, state):
        return jnp.mod(state[0], 2 * jnp.pi)

    def settle(self, state):
        return PhaseState(jnp.mod(state[0], 2 * jnp.pi))


@dataclass(frozen=True)
class WrapsToMinusPi(SoundOscillator):
    def settle(self, state):
        return PhaseState(jnp.mod(state[0] + jnp.pi, 2 * jnp.pi) - jnp.pi)


@dataclass(frozen=True)
class BareRate(SoundOscillator):
    def rate(self, state, omega, feedback):
        return omega + feedback


@dataclass(frozen=True)
class TwoRates(SoundOscillator):
    def rate(self, state, omega, feedback):
        return (omega, feedback)


@dataclass(frozen=True)
class ScalarRate(SoundOscillator):
    def rate(self, state, omega, feedback):
        return (jnp.asarray(1.0, omega.dtype),)


@dataclass(frozen=True)
class SharedRate(SoundOscillator):
    def rate(self, state, omega, feedback):
        return (omega + feedback.max(),)


@dataclass(frozen=True)
class BareState(SoundOscillator):
    def start(self, phase_rad):
        return phase_rad


@dataclass(frozen=True)
class StartsElsewhere(SoundOscillator):
    def start(self, phase_rad):
        return PhaseState(phase_rad + 1.0)


@dataclass(frozen=True)
class Swapped(SoundOscillator):
    def sin_cos(self, state):
        return jnp.cos(state[0]), jnp.sin(state[0])


@dataclass(frozen=True)
class ForgetsItsForm(SoundOscillator):
    def settle(self, state):
        return (state[0],)


@dataclass(frozen=True)
class ForgetsASignal(SoundOscillator):
    SIGNALS = ("sin_phase", "cos_phase", "amplitude")


@dataclass(frozen=True)
class MiscountsItsWeights(SoundOscillator):
    @property
    def n_weights(self):
        return 2

    def initial(self, key):
        return jnp.zeros(3)


@pytest.mark.parametrize(
    ("oscillator", "message"),
    [
        (NeverWraps(), r"NeverWraps\.phase leaves \[0, 2π\) after `settle`.*wrap_phase"),
        (WrapsInPhase(), r"WrapsInPhase\.phase jumps.*wrap it in `settle` only"),
        (WrapsToMinusPi(), r"WrapsToMinusPi\.phase leaves \[0, 2π\) after `settle`"),
        (BareRate(), r"BareRate\.rate returns.*a tuple of 1"),
        (TwoRates(), r"TwoRates\.rate returns 2; it must return a tuple of 1"),
        (ScalarRate(), r"ScalarRate\.rate has shape \(\)"),
        (SharedRate(), r"SharedRate\.rate lets one lane change another"),
        (BareState(), r"BareState\.start returns.*must return a tuple"),
        (StartsElsewhere(), r"StartsElsewhere\.phase of StartsElsewhere\.start\(φ\) is"),
        (Swapped(), r"the sine of Swapped\.sin_cos is"),
        (ForgetsItsForm(), r"ForgetsItsForm\.settle.* returns tuple of 1.*PhaseState of 1"),
        (ForgetsASignal(), r"ForgetsASignal\.signals gives .*; SIGNALS names amplitude"),
        (
            MiscountsItsWeights(),
            r"MiscountsItsWeights\.initial returns shape \(3,\); it must be \(2,\)",
        ),
        (Oscillator, r"Oscillator is a class.*define rate, start first"),
        (5.0, r"float is no Oscillator"),
    ],
    ids=lambda x: getattr(x, "__name__", type(x).__name__),
)
def test_a_breach_of_the_oscillator_contract_is_named_in_one_line(oscillator, message):
    with pytest.raises(TegotaeError, match=message) as error:
        check_oscillator(oscillator)
    assert "\n" not in str(error.value)


# Bodies


@dataclass(frozen=True, kw_only=True)
class NoPytree(Hopper):
    pass


@traceable
@dataclass(frozen=True, kw_only=True)
class ExtraSense(Hopper):
    SENSES = (*Hopper.SENSES, "tilt")


@traceable
@dataclass(frozen=True, kw_only=True)
class NoScale(Hopper):
    def sense(self, state, ground_m):
        sensation = super().sense(state, ground_m)
        return sensation._replace(scales={"spring_force": 1.0, "height": 1.0})


@traceable
@dataclass(frozen=True, kw_only=True)
class Weightless(Hopper):
    @property
    def rate_scale(self):
        return 0.0


@traceable
@dataclass(frozen=True, kw_only=True)
class NumericalFailed(Hopper):
    def failed(self, state, ground_m):
        return state.height - ground_m


@traceable
@dataclass(frozen=True, kw_only=True)
class TalkingLanes(Hopper):
    def failed(self, state, ground_m):
        return state.height < state.height.mean()


class Reversed(NamedTuple):
    velocity: jax.Array
    height: jax.Array


@traceable
@dataclass(frozen=True, kw_only=True)
class LosesItsState(Hopper):
    def advance(self, state, push, ground_m, tick_s):
        end, contact = super().advance(state, push, ground_m, tick_s)
        return Reversed(end.velocity, end.height), contact


@traceable
@dataclass(frozen=True, kw_only=True)
class PercentContact(Hopper):
    def advance(self, state, push, ground_m, tick_s):
        end, contact = super().advance(state, push, ground_m, tick_s)
        return end, contact._replace(stance_share=100.0 * contact.stance_share)


@traceable
@dataclass(frozen=True, kw_only=True)
class ApexEverywhere(Hopper):
    def advance(self, state, push, ground_m, tick_s):
        end, contact = super().advance(state, push, ground_m, tick_s)
        return end, contact._replace(apex_height_m=end.height)


@traceable
@dataclass(frozen=True, kw_only=True)
class FallsUpwardsInItsGuess(Hopper):
    def predict(self, state, force_n, ground_m, tick_s):
        guess, start, stop = super().predict(state, force_n, ground_m, tick_s)
        return guess._replace(velocity=2.0 * state.velocity - guess.velocity), start, stop


@traceable
@dataclass(frozen=True, kw_only=True)
class VelocityDownwards(Hopper):
    def advance(self, state, push, ground_m, tick_s):
        end, contact = super().advance(state, push, ground_m, tick_s)
        return end._replace(height=2.0 * state.height - end.height), contact


@traceable
@dataclass(frozen=True, kw_only=True)
class PerpetualMotion(Hopper):
    """Negative damping: a hopper that speeds itself up."""

    def __post_init__(self):
        object.__setattr__(self, "damping_ns_per_m", -0.2)


@traceable
@dataclass(frozen=True, kw_only=True)
class WorkForNothing(Hopper):
    def advance(self, state, push, ground_m, tick_s):
        end, contact = super().advance(state, push, ground_m, tick_s)
        return end, contact._replace(work_j=-contact.work_j)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (NoPytree(), r"NoPytree is no pytree; put @tegotae\.parts\.parameters\.traceable"),
        (ExtraSense(), r"ExtraSense\.sense gives .*; SENSES names .*tilt.*must be the same"),
        (NoScale(), r"NoScale\.sense gives no scale for velocity"),
        (Weightless(), r"Weightless\.rate_scale is 0; it must be finite and greater than 0"),
        (NumericalFailed(), r"NumericalFailed\.failed is float32 for bool lanes"),
        (TalkingLanes(), r"TalkingLanes\.failed lets one lane change another"),
        (LosesItsState(), r"LosesItsState\.advance returns Reversed of 2.*HopperState of 2"),
        (PercentContact(), r"PercentContact\.advance's stance_share is 100, .* must be a share"),
        (
            ApexEverywhere(),
            r"ApexEverywhere\.advance's apex_share and apex_height_m must be NaN on",
        ),
        (FallsUpwardsInItsGuess(), r"FallsUpwardsInItsGuess\.predict does not approach advance"),
        (VelocityDownwards(), r"VelocityDownwards\..*(predict|velocity).*check"),
        (PerpetualMotion(), r"PerpetualMotion makes energy from nothing, without the actuator"),
        (WorkForNothing(), r"WorkForNothing makes energy from nothing, beyond the actuator's"),
        (Hopper, r"Hopper is a class; check an instance"),
    ],
    ids=lambda x: getattr(x, "__name__", type(x).__name__),
)
def test_a_breach_of_the_body_contract_is_named_in_one_line(body, message):
    with pytest.raises(TegotaeError, match=message) as error:
        check_body(body)
    assert "\n" not in str(error.value)


# Controllers


def test_a_controller_is_refused_for_its_worst_part():
    vanilla = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    for controller, message in [
        (VanillaAction(), "VanillaAction is no Controller"),
        (Controller(VanillaAction(), PhaseOscillator(), vanilla), "cannot be the actuation"),
        (Controller(Reflex(), None, vanilla), "no oscillator"),
        (
            Controller(Reflex(), PhaseOscillator(), Tegotae(Averages(), *_rest(vanilla))),
            "Averages.__call__ lets one lane change another",
        ),
    ]:
        with pytest.raises(TegotaeError, match=message):
            check_controller(controller, Hopper())


def _rest(terms):
    return terms.reaction, terms.gain


def test_a_controller_that_reads_what_the_body_does_not_sense_is_refused():
    controller = Controller(LearnedActuation(("tilt",), hidden=1))
    with pytest.raises(TegotaeError, match="the actuation term reads 'tilt'"):
        check_controller(controller, Hopper())
