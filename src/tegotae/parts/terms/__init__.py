"""Terms of the controller: Action, Reaction, Gain and Actuation, vanilla and learned."""

from tegotae.parts.terms.actuation import (
    Actuation as Actuation,
    FreeSector as FreeSector,
    FreeSectorAndReflex as FreeSectorAndReflex,
    LearnedActuation as LearnedActuation,
    Reflex as Reflex,
    Sector as Sector,
    SectorAndReflex as SectorAndReflex,
    with_vanilla_settings as with_vanilla_settings,
)
from tegotae.parts.terms.base import (
    ConstantGain as ConstantGain,
    DecayingReaction as DecayingReaction,
    OffsetAction as OffsetAction,
    ReversingReaction as ReversingReaction,
    SaturatingReaction as SaturatingReaction,
    ShiftedAction as ShiftedAction,
    Signals as Signals,
    SpeedReaction as SpeedReaction,
    Term as Term,
    TiltReaction as TiltReaction,
    TwoHarmonicsAction as TwoHarmonicsAction,
    UnitAction as UnitAction,
    VanillaAction as VanillaAction,
    VanillaReaction as VanillaReaction,
)
from tegotae.parts.terms.foot import (
    BalancedFoot as BalancedFoot,
    CorrectedFoot as CorrectedFoot,
    EllipticFoot as EllipticFoot,
    LearnedFoot as LearnedFoot,
    PacedFoot as PacedFoot,
    PlacedFoot as PlacedFoot,
    SteppingFoot as SteppingFoot,
    TunedFoot as TunedFoot,
    WaryFoot as WaryFoot,
)
from tegotae.parts.terms.network import Network as Network
from tegotae.parts.terms.whole_body import (
    WholeBody as WholeBody,
    WholeBodyCorrectedFoot as WholeBodyCorrectedFoot,
    WholeBodyFoot as WholeBodyFoot,
)
