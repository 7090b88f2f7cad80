"""The further statements of the paper, one sentence and one number each, as in
`research.reproduction.claims.atomic`.

Their tables were made, and their numbers chosen, when the results of the claims were known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from research.reproduction.claims.atomic import (
    ALIKE,
    ATOMIC_CLAIMS,
    LESS,
    MORE,
    AtomicClaim,
)
from research.reproduction.claims.effects import (
    LEARNED_FEEDBACK,
    ArchitectureGroup,
    Difference,
    DoubleDifference,
    OfGaits,
    Unmeasured,
    V,
)

STUDY, PUSHES, CUT, WITHOUT_OMEGA, HELD = "study", "pushes", "cut", "without ΔΩ", "held"
"""Tables that a number is computed from: the study's, that of its pushes, the same models with and
without feedback, with and without ΔΩ, and the single network of a sampled controller beside V."""

BEFORE, AFTER = "before", "after"
"""Architectures of a table that compares the same models in two ways: as they are, and changed."""


@dataclass(frozen=True)
class Balance:
    """A loss minus a gain by ẏ, each over the range of its metric among all models (Fig. 2)."""

    loss: str
    gain: str


@dataclass(frozen=True)
class JointReach:
    """The largest share of models that one model is better than in each of several metrics, minus
    that of models whose metrics are shuffled. Ranks are within ω_t, unsettled models rank last.
    """

    metrics: tuple[str, ...]


@dataclass(frozen=True)
class OfHorizon:
    """CoT⁻¹ late in training of PPO with the longer horizon minus that of PPO as in Fig. 3."""

    model: str


Number = Difference | DoubleDifference | OfGaits | Balance | JointReach | OfHorizon


@dataclass(frozen=True, kw_only=True)
class Statement(AtomicClaim):
    """A claim whose number is computed from a table beside the study's.

    Args:
        source: the table.
        number: how the effect is computed; `effect` says it in words.
        drive: the input of the actuation of the models that count; empty for all.
    """

    source: str
    number: Number
    drive: str = ""


def _f(*architectures: str) -> ArchitectureGroup:
    return ArchitectureGroup(architectures)


def _any(*architectures: str) -> ArchitectureGroup:
    return ArchitectureGroup(architectures, "")


_CLAIMS = {claim.name: claim for claim in ATOMIC_CLAIMS}


def _measured(name: str, words: str, number: Number, **fields: str) -> Statement:
    """Return a claim of the list, which the study's table cannot judge, with a number."""
    claim = replace(_CLAIMS[name], effect=Unmeasured(words), note="")
    return Statement(**{**vars(claim), **fields}, source=PUSHES, number=number)


_HORIZON = "their actions are based on too short time horizons"
_SENSES = "automatic pattern generation in the absence of sensory information"
_RETAINS = "while retaining the characteristics of Tegotae control"


def _horizon(drive: str) -> Statement:
    return Statement(
        name=f"horizon-{drive}",
        title=f"a longer horizon helps PPO ({drive})",
        words=_HORIZON,
        section="V",
        effect=Unmeasured("CoT⁻¹ late in training [m/J], PPO with a horizon of 5 s − of 2.5 s"),
        sign=MORE,
        note="The second also holds actions for 50 ms in place of 10, learns for twice as long, "
        "and has a critic that senses all: no effect is no fault of the horizon alone.",
        source="",
        number=OfHorizon(f"AR-rF-{drive}-w8"),
    )


def _senses(drive: str, force: str) -> Statement:
    return Statement(
        name=f"no-senses-{force}",
        title=f"without senses {drive}-driven models hop on",
        words=_SENSES,
        section="IV-B",
        effect=Unmeasured("limit cycles, with the feedback at zero − whole"),
        sign=ALIKE,
        size="core properties",
        note=f"All models whose force follows {drive}.",
        source=CUT,
        number=Difference("settled", _any(AFTER), _any(BEFORE)),
        drive=drive,
    )


def _graded(drive: str, vanilla: str) -> Statement:
    return Statement(
        name=f"art-graded-{vanilla}",
        title=f"ART grades its push more than the {vanilla}",
        words="while the power injection strategy is more finely modulated",
        section="V",
        effect=Unmeasured("share of the push with a force neither off nor full, ART − V"),
        sign=MORE,
        size="finely",
        note=f"Models whose force follows {drive}.",
        source=PUSHES,
        number=OfGaits("graded_share", _f("ART"), _f(*V)),
        drive=drive,
    )


FURTHER: tuple[Statement, ...] = (
    Statement(
        name="omega-term",
        title="ΔΩ keeps the gait at ω",
        words="should facilitate finding solutions that comply with prescribed oscillator "
        "frequencies",
        section="III-C",
        effect=Unmeasured("Δw, trained with ΔΩ − by CoT⁻¹ alone"),
        sign=LESS,
        note="AR, VG and ARG with reflex and ART with φ and f, trained at 4 and 8 rad/s.",
        source=WITHOUT_OMEGA,
        number=Difference("delta_w", _any(BEFORE), _any(AFTER)),
    ),
    _horizon("sector"),
    _horizon("reflex"),
    Statement(
        name="vg-instant",
        title="VG pushes at no fixed phase",
        words="This effect is further expressed in the independence of the actuation instant "
        "from the oscillator state",
        section="V",
        effect=Unmeasured("spread of the phase at which pushes begin over five ω, VG − V"),
        sign=MORE,
        size="independence",
        note="0 is one phase, 1 is phases anywhere. A sector begins at one phase by definition.",
        source=PUSHES,
        number=OfGaits("onset_spread", _f("VG"), _f(*V)),
    ),
    Statement(
        name="contrary-to-vg",
        title="a gain helps less where A and R are learned",
        words="Contrary to VG, added gain modulation to the generalized Tegotae feedback "
        "structure (ARG and ARGT), reduces the efficiency",
        section="V",
        effect=Unmeasured("CoT⁻¹ [m/J], (ARG, ARGT − AR, ART) − (VG − V)"),
        sign=LESS,
        size="contrary",
        source=STUDY,
        number=DoubleDifference(
            "cot_inverse", (_f("ARG", "ARGT"), _f("AR", "ART")), (_f("VG"), _f(*V))
        ),
    ),
    Statement(
        name="criteria-joint",
        title="no model is good by all criteria",
        words="the individual performance criteria are not independently achievable",
        section="V",
        effect=Unmeasured(
            "share of models that one model surpasses by CoT⁻¹, T0, T1 and Δw at once, "
            "− of models with shuffled criteria"
        ),
        sign=LESS,
        source=STUDY,
        number=JointReach(("cot_inverse", "t0_s", "t1_s", "delta_w")),
    ),
    _senses("φ", "phase"),
    _senses("f", "feedback"),
    _senses("φf", "both"),
    _graded("φ", "sector"),
    _graded("f", "reflex"),
    _measured(
        "arg-short-push",
        "share of the stance in which the actuator pushes, ARG − AR",
        OfGaits("push_share", _f("ARG"), _f("AR")),
    ),
    _measured(
        "vg-erratic",
        "mean rate of change of the feedback over its mean size [1/s], VG − V",
        OfGaits("feedback_change", _f("VG"), _f(*V)),
    ),
    Statement(
        name="equally-large",
        title="ẏ costs as much stability as it gains efficiency",
        words="but entails an equally large degradation of stability to disturbances",
        section="V",
        effect=Unmeasured("T1 by ẏ − CoT⁻¹ by ẏ, each over its range among all models"),
        sign=ALIKE,
        size="equally large",
        source=STUDY,
        number=Balance("t1_s", "cot_inverse"),
    ),
    Statement(
        name="retains-dependence",
        title="learned feedback depends on its oscillator as V does",
        words=_RETAINS,
        section="VI",
        effect=Unmeasured("CPGu, AR, ART, ARG, ARGT − V"),
        sign=ALIKE,
        size="retaining",
        source=STUDY,
        number=Difference("cpgu", _f(*LEARNED_FEEDBACK), _f(*V)),
    ),
    Statement(
        name="retains-waiting",
        title="learned feedback slows its oscillator while it pushes",
        words=_RETAINS,
        section="VI",
        effect=Unmeasured("feedback while the actuator pushes [rad/s], AR, ART, ARG, ARGT"),
        sign=LESS,
        size="retaining",
        source=STUDY,
        number=OfGaits("feedback_while_pushing", _f(*LEARNED_FEEDBACK)),
    ),
    Statement(
        name="t-held",
        title="a sampled T is less efficient than V",
        words="it is not capable of beating or even approaching the baseline",
        section="V",
        effect=Unmeasured("CoT⁻¹ [m/J], T on [F_k] trained and judged under a held force − V"),
        sign=LESS,
        note="In continuous time its zero is a theorem. A force that is held over a tick lags, and "
        "the theorem does not hold.",
        source=HELD,
        number=Difference("cot_inverse", _f("T"), _f(*V)),
    ),
)
"""The statements, in the order of the paper's argument."""
