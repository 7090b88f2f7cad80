"""Anyone's policy on the hopper: a function, a Stable-Baselines3 model, an ONNX file.

What a policy sees and does is a `Meaning`; how it is asked is a file of its own for each kind.
With both it is a `Policy`, of which `tegotae.analysis` makes surfaces and portraits.
"""

from tegotae._support.errors import require

require("gymnasium", "gym")

from tegotae.envs.policies.base import (  # noqa: E402
    ACTS,
    ClippedFeedbackWarning,
    Meaning,
    Policy,
    from_function,
)
from tegotae.envs.policies.loading import load_policy  # noqa: E402

__all__ = ["ACTS", "ClippedFeedbackWarning", "Meaning", "Policy", "from_function", "load_policy"]
