"""Effects of the paper's claims, described and not computed."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae.systems.observations import OBSERVATIONS

V = ("V",)
LEARNED_FEEDBACK = ("AR", "ART", "ARG", "ARGT")
"""The architectures that learn action and reaction."""
WITH_OSCILLATOR = ("V", "VG", "VT", "VGT", *LEARNED_FEEDBACK)
"""All but the single network."""


@dataclass(frozen=True)
class ArchitectureGroup:
    """Architectures with the same senses; each of them counts alike in the group's mean.

    Args:
        architectures: their names.
        observation: "F" ([F_k]), "Fv" ([F_k, ẏ]), or empty for either.
    """

    architectures: tuple[str, ...]
    observation: str = "F"

    @property
    def label(self) -> str:
        """Label in tables.

        Example:
            >>> ArchitectureGroup(("AR", "ART"), "Fv").label
            'AR, ART on [F_k, ẏ]'
        """
        names = ", ".join(self.architectures)
        if not self.observation:
            return f"{names}, any input"
        symbols = OBSERVATIONS[self.observation].symbols
        return names if self.observation == "F" else f"{names} on [{symbols}]"


@dataclass(frozen=True)
class Difference:
    """A metric of one group minus that of another, at equal ω_t and input of the actuation.

    Differences are averaged over these; the single network, which has neither, is compared with
    each. Both training frequencies count alike, and all five frequencies of the evaluation.

    Args:
        metric: the metric's name.
        ours: the group that the claim is about.
        theirs: what it is compared with; None compares with zero.
        lowest: whether it is compared with the lowest architecture of `theirs`, not their mean.
    """

    metric: str
    ours: ArchitectureGroup
    theirs: ArchitectureGroup | None
    lowest: bool = False


@dataclass(frozen=True)
class DoubleDifference:
    """Difference between the differences of two pairs of groups: `(a - b) - (c - d)`."""

    metric: str
    ours: tuple[ArchitectureGroup, ArchitectureGroup]
    theirs: tuple[ArchitectureGroup, ArchitectureGroup]


@dataclass(frozen=True)
class Correlation:
    """Pearson's correlation of two metrics over all models, each the mean of its runs.

    It is within ω_t: what two frequencies differ by is no relation of the metrics.
    """

    a: str
    b: str


@dataclass(frozen=True)
class OfTrainings:
    """A difference of trainings that an experiment of its own has in its table.

    Args:
        table: the experiment's file.
        metric: the column.
        ours: what the claim is about.
        theirs: what it is compared with; empty compares with zero.
    """

    table: str
    metric: str
    ours: str
    theirs: str = ""


@dataclass(frozen=True)
class OfGainMap:
    """A number of the maps of CoT⁻¹ over gain and frequency (Fig. 4).

    Args:
        measure: `slope`, of the best σ over ω [rad/(s N) per rad/s]; `r_squared`, of that line;
            `resonance_shift`, of the best ω over the range of σ [rad/s]; or `loss`, the share of
            CoT⁻¹ that is lost 1 rad/s away at the same σ.
        ours: "sector", "reflex" or, for the mean of both, "both".
        theirs: what it is compared with; empty compares with zero.
    """

    measure: str
    ours: str
    theirs: str = ""


@dataclass(frozen=True)
class OfGaits:
    """A number of the limit cycles themselves, which the study's table does not have.

    Args:
        measure: `feedback_while_pushing`, the mean feedback while the actuator pushes [rad/s];
            `feedback_share`, mean |f| over ω + mean |f|; `phase_share`, the share of the force's
            variance in stance left beside a line in each of 12 bins of F_k; `rate_slope`, the slope
            of the hop rate over ω; or `nearer_resonance`, by how much the hop rate is nearer to
            that of the body's most efficient gait than to ω [rad/s].
        ours: the group that the claim is about.
        theirs: what it is compared with; None compares with zero.
    """

    measure: str
    ours: ArchitectureGroup
    theirs: ArchitectureGroup | None = None


@dataclass(frozen=True)
class Unmeasured:
    """A number that no table has.

    Args:
        description: the number in words.
    """

    description: str


Effect = (
    Difference | DoubleDifference | Correlation | OfTrainings | OfGainMap | OfGaits | Unmeasured
)
"""Effect of a claim, a single number."""


def groups_of_effect(effect: Effect) -> tuple[ArchitectureGroup, ...]:
    """Return the groups of architectures that an effect compares, or none if it compares others.

    A correlation is about all models.

    Example:
        >>> effect = Difference("cpgu", ArchitectureGroup(V), None)
        >>> [group.label for group in groups_of_effect(effect)]
        ['V']
    """
    if isinstance(effect, Correlation):
        return (ArchitectureGroup((*WITH_OSCILLATOR, "T"), ""),)
    if isinstance(effect, DoubleDifference):
        return (*effect.ours, *effect.theirs)
    if isinstance(effect, OfTrainings | OfGainMap | Unmeasured):
        return ()
    return (effect.ours,) if effect.theirs is None else (effect.ours, effect.theirs)
