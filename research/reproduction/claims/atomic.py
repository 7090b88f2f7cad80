"""The paper's claims, one sentence and one effect each, fixed before the runs that judge them.

Each has the paper's own words, the effect that they are about and the sign that they claim. None
has a threshold: the paper sets none. Where its words have a size ("vastly") the size of the effect
stands beside that of what it is compared with, and decides nothing. Where they claim that two
things are alike ("on par") there is no sign, and `EQUIVALENCE` decides.

The list was fixed before anything was computed by it. Tables of an earlier study were there, and
had been judged by other rules; those of later studies were not. It is not changed to suit results:
a claim that was read wrongly is marked so, and stays. Three things came later, when the results of
the others were known: the claims of `LATER`, `EQUIVALENCE`, and that `ar-cot`, which says that AR
"has the potential", is about the best run.
"""

from __future__ import annotations

from dataclasses import dataclass

from research.reproduction.claims.counting import BEST
from research.reproduction.claims.effects import (
    LEARNED_FEEDBACK,
    WITH_OSCILLATOR,
    ArchitectureGroup,
    Correlation,
    Difference,
    DoubleDifference,
    Effect,
    OfGainMap,
    OfGaits,
    OfTrainings,
    Unmeasured,
    V,
)

MORE, LESS, ALIKE = 1, -1, 0
"""The claimed sign of an effect; that two things are alike has none."""

EQUIVALENCE = (0.8, 1.25)
"""Two things are alike if the one is this share of the other. The paper has no margin; this is that
of bioequivalence."""

OMISSION = "[…]"
"""Marks words of the paper that a quotation leaves out."""


@dataclass(frozen=True, kw_only=True)
class AtomicClaim:
    """One statement of the paper that one number can support or contradict.

    Args:
        name: short and unique, such as `vg-cot`.
        title: the claim in a few words, for figures and tables.
        words: the paper's, verbatim but for `OMISSION`.
        section: where they stand.
        effect: the number.
        sign: that the paper claims: `MORE`, `LESS`, or `ALIKE`, within `EQUIVALENCE`.
        size: the paper's word for how large the effect is; empty if it has none.
        headline: whether it is what the paper says of itself in abstract or conclusion.
        run: the run that it is about, such as `research.reproduction.claims.counting.BEST`; empty
            if the paper does not say.
        note: what a reader of the verdict should know.
    """

    name: str
    title: str
    words: str
    section: str
    effect: Effect
    sign: int
    size: str = ""
    headline: bool = False
    run: str = ""
    note: str = ""


def _f(*architectures: str) -> ArchitectureGroup:
    return ArchitectureGroup(architectures)


def _fv(*architectures: str) -> ArchitectureGroup:
    return ArchitectureGroup(architectures, "Fv")


_OVER_ALPHA = "Rates are over the largest possible force α: a weak force counts as smooth."
_NOT_KEPT = "The study's tables have no metric of it."
_EQUAL_TIME = "All learn from the same simulated time, 6000 s."
_GAIN_ON_LEARNED = ("ARG", "ARGT")
_OTHERS = ArchitectureGroup(tuple(name for name in WITH_OSCILLATOR if name not in V), "")
_ALL_OTHERS = ArchitectureGroup((*_OTHERS.architectures, "T"), "")

LATER = (
    AtomicClaim(
        name="art-extends-stance",
        title="ART slows its oscillator while it pushes",
        words="the feedback mechanism of the selected ART policy exhibits the stance phase "
        "extension behavior of standard Tegotae",
        section="V",
        effect=OfGaits("feedback_while_pushing", _f("ART")),
        sign=LESS,
        note="The paper's is one selected policy. The tables have the feedback during the push, "
        "not over the whole stance.",
    ),
    AtomicClaim(
        name="argt-force-reflex",
        title="ARGT's force depends less on the phase",
        words="while in (VIII) feedback reflexive actuation decays to force reflexive actuation",
        section="V",
        effect=OfGaits("phase_share", _f("ARGT"), _f("ART")),
        sign=LESS,
        size="decays",
        note="A force that F_k alone decides leaves nothing to the phase. The paper's is one "
        "policy, compared here with ART, which has no active gain.",
    ),
    AtomicClaim(
        name="dependent-follows",
        title="dependent models hop near ω",
        words="the tight coupling between oscillators and actuation offers elegant means of "
        "velocity modulation",
        section="V",
        effect=Correlation("cpgu", "delta_w"),
        sign=LESS,
        size="tight",
        note="The paper defines Δw, and its text says nothing else that Δw can measure.",
    ),
    AtomicClaim(
        name="arg-short-push",
        title="ARG has little time to push",
        words="This leads to little time available for power injection in (VI) as the actuation "
        "instant is coupled to the oscillator state",
        section="V",
        effect=Unmeasured("duration of the push, ARG − AR"),
        sign=LESS,
        size="little",
        note=_NOT_KEPT,
    ),
    AtomicClaim(
        name="vg-erratic",
        title="VG's feedback is erratic",
        words="which is visible in the erratic Tegotae feedback in Fig. 5 (IV)",
        section="V",
        effect=Unmeasured("rate of change of the feedback, VG − V"),
        sign=MORE,
        size="erratic",
        note=_NOT_KEPT,
    ),
    AtomicClaim(
        name="agents-periodic",
        title="the feedback of SAC and PPO is periodic",
        words="While SAC and PPO produce periodic feedback patterns, their actions are based on "
        "too short time horizons",
        section="V",
        effect=Unmeasured("periodicity of the feedback, SAC and PPO"),
        sign=MORE,
        note="The table of the algorithms has CoT⁻¹ alone.",
    ),
)
"""Claims that came to the list when the results of the others were known."""

ATOMIC_CLAIMS: tuple[AtomicClaim, ...] = (
    # What the paper says of itself.
    AtomicClaim(
        name="learned-beats-v",
        title="learned feedback is more efficient than V",
        words="our end-to-end learnable Tegotae policy demonstrated major efficiency gains, "
        "compared to previous, manually designed Tegotae-based methods",
        section="VI",
        effect=Difference("cot_inverse", _f(*LEARNED_FEEDBACK), _f(*V)),
        sign=MORE,
        size="major",
        headline=True,
    ),
    AtomicClaim(
        name="learned-beats-t",
        title="learned feedback is more efficient than T",
        words="our approach can learn efficient and adaptive locomotion on minimal feedback "
        "information, while outperforming unstructured, classic reinforcement learning policies of "
        "equal complexity",
        section="Abstract",
        effect=Difference("cot_inverse", _f(*LEARNED_FEEDBACK), _f("T")),
        sign=MORE,
        headline=True,
        note="On [F_k] the single network's zero is a theorem in continuous time.",
    ),
    AtomicClaim(
        name="sparse-input",
        title="ART loses less than T without ẏ",
        words="The distributed policy architecture proved to be especially robust to reduced "
        "information environments",
        section="VI",
        effect=DoubleDifference("cot_inverse", (_fv("ART"), _f("ART")), (_fv("T"), _f("T"))),
        sign=LESS,
        headline=True,
        note="What ART loses without ẏ, less what T loses.",
    ),
    AtomicClaim(
        name="pgpe-over-sac",
        title="PGPE is above SAC",
        words="their actions are based on too short time horizons, which do not lead to fruitful "
        "entrainment",
        section="V",
        effect=OfTrainings("figure3.csv", "cot_inverse", "pgpe-figure3", "sac"),
        sign=MORE,
        headline=True,
        note=_EQUAL_TIME,
    ),
    AtomicClaim(
        name="pgpe-over-ppo",
        title="PGPE is above PPO",
        words="the entrainment mechanisms fundamental to Tegotae control have been shown to be "
        "disrupted by modern algorithms like SAC and PPO",
        section="V",
        effect=OfTrainings("figure3.csv", "cot_inverse", "pgpe-figure3", "ppo"),
        sign=MORE,
        headline=True,
        note=_EQUAL_TIME,
    ),
    # V, the baseline.
    AtomicClaim(
        name="v-cpgu",
        title="V depends on its oscillator",
        words="The resulting control strategies are strongly connected to the state of the "
        "oscillators",
        section="V",
        effect=Difference("cpgu", _f(*V), _OTHERS),
        sign=MORE,
        size="strongly",
    ),
    AtomicClaim(
        name="v-medium-cot",
        title="V is of medium efficiency",
        words="and achieved medium CoT^{-1} performance",
        section="V",
        effect=Difference("cot_inverse", _f(*V), _OTHERS, lowest=True),
        sign=MORE,
        size="medium",
        note="Medium has others below it: V is compared with the lowest other architecture.",
    ),
    AtomicClaim(
        name="v-t0",
        title="V settles quickly",
        words="their stability to unforeseen environmental disturbances are among the best (small "
        "T0 and T1) of all tested architectures",
        section="V",
        effect=Difference("t0_s", _f(*V), _ALL_OTHERS),
        sign=LESS,
        size="among the best",
    ),
    AtomicClaim(
        name="v-t1",
        title="V recovers quickly",
        words="their stability to unforeseen environmental disturbances are among the best (small "
        "T0 and T1) of all tested architectures",
        section="V",
        effect=Difference("t1_s", _f(*V), _ALL_OTHERS),
        sign=LESS,
        size="among the best",
    ),
    AtomicClaim(
        name="v-slows-while-pushing",
        title="V slows its oscillator while it pushes",
        words="the oscillator is slowed down during actuation in both instances, to synchronize "
        "power injection with the stance phase",
        section="V",
        effect=OfGaits("feedback_while_pushing", _f(*V)),
        sign=LESS,
    ),
    # The gain map.
    AtomicClaim(
        name="map-sector-line",
        title="sector: the best σ is linear in ω",
        words="For the latter a near linear relationship between σ and ω can be found",
        section="V",
        effect=OfGainMap("slope", "sector"),
        sign=MORE,
        size="near linear",
        note="The size is the share of the ridge's variance that a line explains.",
    ),
    AtomicClaim(
        name="map-reflex-complex",
        title="reflex: the best σ is less linear in ω",
        words="The dynamics of the reflex actuation are noticeably more complex",
        section="V",
        effect=OfGainMap("r_squared", "reflex", "sector"),
        sign=LESS,
        size="noticeably",
    ),
    AtomicClaim(
        name="map-reflex-resonance",
        title="reflex: σ does not move the resonance",
        words="the closed-loop resonance cannot be influenced by fixed Tegotae gains",
        section="V",
        effect=OfGainMap("resonance_shift", "reflex", "sector"),
        sign=LESS,
        note="How far the best ω moves over the range of σ, against the sector.",
    ),
    AtomicClaim(
        name="map-quick-loss",
        title="efficiency falls quickly beside the best ω",
        words="leads to quick performance degradation when the oscillator frequency is varied",
        section="V",
        effect=OfGainMap("loss", "both"),
        sign=MORE,
        size="quick",
    ),
    # An active gain on vanilla terms.
    AtomicClaim(
        name="vg-cot",
        title="VG is more efficient than V",
        words="Adding active gain modulation to the otherwise unchanged model (VG) vastly improves "
        "the CoT^{-1}",
        section="V",
        effect=Difference("cot_inverse", _f("VG"), _f(*V)),
        sign=MORE,
        size="vastly",
    ),
    AtomicClaim(
        name="vg-t0",
        title="VG settles later than V",
        words="initial and perturbation recovery transients are substantially prolonged",
        section="V",
        effect=Difference("t0_s", _f("VG"), _f(*V)),
        sign=MORE,
        size="substantially",
    ),
    AtomicClaim(
        name="vg-t1",
        title="VG recovers later than V",
        words="initial and perturbation recovery transients are substantially prolonged",
        section="V",
        effect=Difference("t1_s", _f("VG"), _f(*V)),
        sign=MORE,
        size="substantially",
    ),
    AtomicClaim(
        name="vg-feedback-off",
        title="VG switches the feedback off",
        words="gain modulation effectively switches off the oscillator feedback mechanism",
        section="V",
        effect=OfGaits("feedback_share", _f("VG"), _f(*V)),
        sign=LESS,
        size="effectively switches off",
    ),
    AtomicClaim(
        name="vg-independent-of-phase",
        title="VG's force depends less on the phase",
        words="the independence of the actuation instant from the oscillator state, while the "
        "actuation force is solely modulated by F_k",
        section="V",
        effect=OfGaits("phase_share", _f("VG"), _f(*V)),
        sign=LESS,
        size="independence",
    ),
    # A learned actuation on vanilla terms.
    AtomicClaim(
        name="vt-cot",
        title="VT is as efficient as V",
        words="does on average not lead to large deviations from the baseline performance",
        section="V",
        effect=Difference("cot_inverse", _f("VT"), _f(*V)),
        sign=ALIKE,
        size="not large",
    ),
    AtomicClaim(
        name="vt-smooth",
        title="VT is smoother than V",
        words="but produces smoother actuation signals (compare Fig. 5 (V) and (VT))",
        section="V",
        effect=Difference("smoothness", _f("VT"), _f(*V)),
        sign=LESS,
        note=_OVER_ALPHA,
    ),
    # Learned action and reaction.
    AtomicClaim(
        name="ar-cot",
        title="AR can be more efficient than V",
        words="Learning the Tegotae feedback mechanism (AR), has the potential to improve the "
        "efficiency of the system",
        section="V",
        effect=Difference("cot_inverse", _f("AR"), _f(*V)),
        sign=MORE,
        run=BEST,
        note="Potential is that of the run of highest fitness in training.",
    ),
    AtomicClaim(
        name="ar-t0",
        title="AR settles sooner than VG",
        words="while significantly lowering the transient spikes encountered for mere gain "
        "modulation",
        section="V",
        effect=Difference("t0_s", _f("AR"), _f("VG")),
        sign=LESS,
        size="significantly",
    ),
    AtomicClaim(
        name="ar-t1",
        title="AR recovers sooner than VG",
        words="while significantly lowering the transient spikes encountered for mere gain "
        "modulation",
        section="V",
        effect=Difference("t1_s", _f("AR"), _f("VG")),
        sign=LESS,
        size="significantly",
    ),
    AtomicClaim(
        name="ar-frequency",
        title="AR's hop rate follows ω",
        words="easily controlled through its tight coupling to the oscillator frequency",
        section="V",
        effect=OfGaits("rate_slope", _f("AR")),
        sign=MORE,
        size="tight",
        note="The slope of the hop rate over ω, which is 1 for a gait that follows.",
    ),
    AtomicClaim(
        name="art-cot",
        title="ART is more efficient than AR",
        words="Paring an AR controller with a learnable actuation function (ART) leads to further "
        "gains in locomotion efficiency",
        section="V",
        effect=Difference("cot_inverse", _f("ART"), _f("AR")),
        sign=MORE,
    ),
    AtomicClaim(
        name="art-smooth",
        title="ART is smoother than AR",
        words="The resulting smoother actuator signal has the potential to reduce actuator tears",
        section="V",
        effect=Difference("smoothness", _f("ART"), _f("AR")),
        sign=LESS,
        note=_OVER_ALPHA,
    ),
    # An active gain on learned terms.
    AtomicClaim(
        name="arg-cot",
        title="ARG is less efficient than AR",
        words="added gain modulation to the generalized Tegotae feedback structure (ARG and ARGT), "
        "reduces the efficiency",
        section="V",
        effect=Difference("cot_inverse", _f("ARG"), _f("AR")),
        sign=LESS,
    ),
    AtomicClaim(
        name="argt-cot",
        title="ARGT is less efficient than ART",
        words="added gain modulation to the generalized Tegotae feedback structure (ARG and ARGT), "
        "reduces the efficiency",
        section="V",
        effect=Difference("cot_inverse", _f("ARGT"), _f("ART")),
        sign=LESS,
    ),
    AtomicClaim(
        name="arg-t0",
        title="ARG, ARGT settle sooner than AR, ART",
        words="reduces the efficiency, which is inherently correlated with lower transient periods",
        section="V",
        effect=Difference("t0_s", _f(*_GAIN_ON_LEARNED), _f("AR", "ART")),
        sign=LESS,
    ),
    AtomicClaim(
        name="arg-t1",
        title="ARG, ARGT recover sooner than AR, ART",
        words="reduces the efficiency, which is inherently correlated with lower transient periods",
        section="V",
        effect=Difference("t1_s", _f(*_GAIN_ON_LEARNED), _f("AR", "ART")),
        sign=LESS,
    ),
    AtomicClaim(
        name="arg-below-v",
        title="ARG is less efficient than V",
        words="For ARG this results in below-baseline performance",
        section="V",
        effect=Difference("cot_inverse", _f("ARG"), _f(*V)),
        sign=LESS,
    ),
    AtomicClaim(
        name="arg-feedback-off",
        title="ARG, ARGT switch the feedback off",
        words="gain modulation switches off the Tegotae feedback mechanism",
        section="V",
        effect=OfGaits("feedback_share", _f(*_GAIN_ON_LEARNED), _f("AR", "ART")),
        sign=LESS,
        size="switches off",
    ),
    # The single network.
    AtomicClaim(
        name="t-below-v",
        title="T is less efficient than V",
        words="it is not capable of beating or even approaching the baseline",
        section="V",
        effect=Difference("cot_inverse", _f("T"), _f(*V)),
        sign=LESS,
        size="zero performance",
        note="On [F_k] the single network's zero is a theorem in continuous time.",
    ),
    AtomicClaim(
        name="t-viable",
        title="ẏ makes T viable",
        words="Increasing the information content in the sensory feedback also makes the standard "
        "MLP policy viable",
        section="V",
        effect=Difference("cot_inverse", _fv("T"), _f("T")),
        sign=MORE,
    ),
    AtomicClaim(
        name="t-par",
        title="with ẏ T is as efficient as ART",
        words="raises its efficiency on par with that of Tegotae control",
        section="V",
        effect=Difference("cot_inverse", _fv("T"), _fv("ART")),
        sign=ALIKE,
        size="on par",
        note="Tegotae control is taken as ART, which learns actuation, too.",
    ),
    AtomicClaim(
        name="t-t0",
        title="with ẏ T settles later than ART",
        words="but requires very long transient periods to achieve a stable limit cycle",
        section="V",
        effect=Difference("t0_s", _fv("T"), _fv("ART")),
        sign=MORE,
        size="very long",
    ),
    AtomicClaim(
        name="t-t1",
        title="with ẏ T recovers later than ART",
        words="but requires very long transient periods to achieve a stable limit cycle",
        section="V",
        effect=Difference("t1_s", _fv("T"), _fv("ART")),
        sign=MORE,
        size="very long",
    ),
    # The body's velocity as an input.
    AtomicClaim(
        name="v-input-cpgu",
        title="ẏ lowers dependence on the oscillator",
        words=r"providing \dot{y} to the Tegotae feedback structure, makes the controller less "
        "dependent on the oscillator activity (low CPGu metric)",
        section="V",
        effect=Difference("cpgu", _fv(*LEARNED_FEEDBACK), _f(*LEARNED_FEEDBACK)),
        sign=LESS,
        size="low",
    ),
    AtomicClaim(
        name="v-input-cot",
        title="ẏ raises efficiency",
        words="and enables large gains in efficiency",
        section="V",
        effect=Difference(
            "cot_inverse",
            _fv(*LEARNED_FEEDBACK),
            _f(*LEARNED_FEEDBACK),
        ),
        sign=MORE,
        size="large",
    ),
    AtomicClaim(
        name="v-input-t1",
        title="ẏ slows recovery",
        words="but entails an equally large degradation of stability to disturbances",
        section="V",
        effect=Difference("t1_s", _fv(*LEARNED_FEEDBACK), _f(*LEARNED_FEEDBACK)),
        sign=MORE,
        size="equally large",
    ),
    # Over all models.
    AtomicClaim(
        name="efficient-is-slow",
        title="efficient models settle later",
        words="high efficiency leads to a trade-off with slow convergence to a limit cycle",
        section="V",
        effect=Correlation("cot_inverse", "t0_s"),
        sign=MORE,
    ),
    AtomicClaim(
        name="efficient-is-unstable",
        title="efficient models recover later",
        words="high efficiency leads to a trade-off with slow convergence to a limit cycle and "
        "reduced stability to disturbances",
        section="V",
        effect=Correlation("cot_inverse", "t1_s"),
        sign=MORE,
    ),
    AtomicClaim(
        name="dependent-is-quick",
        title="dependent models recover sooner",
        words="the high dependency of the actuation dynamics on the CPG activity greatly improves "
        "the convergence behavior for unexpected perturbations",
        section="V",
        effect=Correlation("cpgu", "t1_s"),
        sign=LESS,
        size="greatly",
    ),
    AtomicClaim(
        name="dependent-is-inefficient",
        title="dependent models are less efficient",
        words="While this entails lowered efficiency, the tight coupling between oscillators and "
        "actuation offers elegant means of velocity modulation",
        section="V",
        effect=Correlation("cpgu", "cot_inverse"),
        sign=LESS,
    ),
    # What PGPE can do.
    AtomicClaim(
        name="pgpe-resonance",
        title="AR hops near the body's resonance",
        words="PGPE was able to converge to solutions, that operate at the resonance of the "
        "controlled system",
        section="V",
        effect=OfTrainings("figure3_gaits.csv", "nearer_resonance", "pgpe-figure3", ""),
        sign=MORE,
        note="The trainings of Fig. 3, whose fitness is CoT⁻¹ alone; ΔΩ ties the study's to ω.",
    ),
    AtomicClaim(
        name="more-than-128",
        title="more than 128 parameters train worse",
        words="We found that policies exceeding 128 parameters, were untrainable",
        section="V",
        effect=OfTrainings("parameter_limit.csv", "fitness", "more than 128", "at most 128"),
        sign=LESS,
        size="untrainable",
    ),
    *LATER,
)
"""The claims, the paper's own account of itself first."""
