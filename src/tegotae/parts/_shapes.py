"""Shapes of arrays, named once: what annotations of parts and simulation say of an array.

The last axis is that of the lanes, the rollouts that are advanced side by side. What belongs to a
limb has the limbs' axis before it on a body with several, and none on a body with one. Within one
call a name stands for one size: two `PerLimb` arguments have the same limbs and the same lanes.
Static checkers read each as `jax.Array`; the tests check sizes and types at run time: they read
`Annotated[Array, "float", "lanes"]` as jaxtyping's `Float[Array, "lanes"]`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from jax import Array

PerLane = Annotated[Array, "float", "lanes"]
"""A real number of each lane, such as the height of the ground."""
PerLimb = Annotated[Array, "float", "*limbs lanes"]
"""A real number of each limb, such as a phase or a weight of a term: [(limbs,) lanes]."""
PerCommand = Annotated[Array, "float", "... lanes"]
"""Commands of the actuators: shaped as `PerLimb`, or with an axis of the commands first."""
MaskPerLane = Annotated[Array, "bool", "lanes"]
"""A boolean for each lane."""
Scalar = Annotated[Array, "float", ""]
"""A real number that is the same for all lanes, such as the control period."""
Index = Annotated[Array, "int", ""]
"""The number of a control tick."""
WeightVector = Annotated[Array, "float", "n_weights"]
"""The trained numbers of one controller, or of one part of it."""
WeightMatrix = Annotated[Array, "float", "n_weights lanes"]
"""The trained numbers of every lane."""
if TYPE_CHECKING:
    Weights = PartWeights = Sequence[Array]
else:  # An array is a sequence of its rows, which JAX does not declare.
    Weights = Sequence[PerCommand] | Annotated[Array, "float", "n_weights ... lanes"]
    PartWeights = Sequence[PerCommand] | Annotated[Array, "float", "n_of_part ... lanes"]
"""n_weights arrays: [lanes], or [limbs, lanes] once they are spread over the limbs."""
Number = float | Annotated[Array, "float", "..."]
"""A number, or an array of numbers that broadcasts against the lanes, such as a field of a body."""
AnyArray = np.ndarray | Array
"""An array of JAX, or of NumPy once it has left the device."""
Numeric = float | np.floating | AnyArray
"""A number or an array of either kind, for formulas that hold for all of them."""
ArrayTree = Annotated[Any, "tree", AnyArray]
"""Any pytree of arrays, such as what a summary makes of a trajectory."""
StateTree = Annotated[Any, "tree", Array]
"""State carried between ticks by a body or an oscillator: any pytree of arrays, lanes last."""
if TYPE_CHECKING:
    LaneNumbers = Any
else:
    LaneNumbers = float | Array | np.ndarray | np.generic | Sequence
"""What a user gives for the lanes: a number, a list or an array of NumPy; in a compiled program an
array of JAX."""
