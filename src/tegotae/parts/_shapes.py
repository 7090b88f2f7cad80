"""Shapes of arrays, named once: what annotations of parts and simulation say of an array.

The last axis is that of the lanes, the rollouts that are advanced side by side. What belongs to a
limb has the limbs' axis before it on a body with several, and none on a body with one. Within one
call a name stands for one size: two `PerLimb` arguments have the same limbs and the same lanes.
Static checkers read each as `jax.Array`; the tests check sizes and types at run time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Array, Bool, Float, Int, Shaped

PerLane = Float[Array, "lanes"]
"""A real number of each lane, such as the height of the ground."""
PerLimb = Float[Array, "*limbs lanes"]
"""A real number of each limb, such as a phase or a weight of a term: [(limbs,) lanes]."""
PerCommand = Float[Array, "... lanes"]
"""What actuators are commanded: as `PerLimb`, or with an axis of the commands first."""
MaskPerLane = Bool[Array, "lanes"]
"""Whether something holds of each lane."""
Scalar = Float[Array, ""]
"""A real number that is the same for all lanes, such as the control period."""
Index = Int[Array, ""]
"""The number of a control tick."""
WeightVector = Float[Array, "n_weights"]
"""The trained numbers of one controller, or of one part of it."""
WeightMatrix = Float[Array, "n_weights lanes"]
"""The trained numbers of every lane."""
if TYPE_CHECKING:
    Weights = Sequence[Array]
else:  # An array is a sequence of its rows, which JAX does not declare.
    Weights = Sequence[PerCommand] | Float[Array, "n_weights ... lanes"]
"""n_weights arrays: [lanes], or [limbs, lanes] once they are spread over the limbs."""
Number = float | Float[Array, "..."]
"""A number, or an array of numbers that broadcasts against the lanes, such as a field of a body."""
AnyArray = Shaped[np.ndarray | Array, "..."]
"""An array of JAX, or of NumPy once it has left the device."""
Numeric = float | np.floating | AnyArray
"""A number or an array of either kind, for formulas that hold for all of them."""
if TYPE_CHECKING:
    ArrayTree = Any
else:
    from jaxtyping import PyTree

    ArrayTree = PyTree[AnyArray]
"""Any pytree of arrays, such as what a summary makes of a trajectory."""
if TYPE_CHECKING:
    StateTree = ArrayTree
else:
    StateTree = PyTree[Shaped[Array, "..."]]
"""What a body or an oscillator keeps between ticks: any pytree of arrays, lanes last."""
if TYPE_CHECKING:
    LaneNumbers = Any
else:
    LaneNumbers = float | Shaped[Array, "..."] | np.ndarray | np.generic | Sequence
"""What a user gives for the lanes: a number, a list or an array of NumPy; in a compiled program an
array of JAX."""
