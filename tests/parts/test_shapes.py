import subprocess
import sys
from pathlib import Path

import jax.numpy as jnp
import pytest
from beartype import beartype
from jaxtyping import TypeCheckError, jaxtyped

from shapes import checkable
from tegotae.parts import _shapes

PROGRAM = Path(__file__).parents[1] / "helpers" / "shapes.py"
PerLane, PerLimb = map(checkable, (_shapes.PerLane, _shapes.PerLimb))


@jaxtyped(typechecker=beartype)
def _pushed(force_n: PerLimb, ground_m: PerLane) -> PerLimb:
    return force_n + ground_m.reshape((1,) * (force_n.ndim - 1) + (-1,))


@pytest.mark.parametrize(
    "bodies",
    [
        ["bar"],
        pytest.param(["wrapped hopper", "walker"], marks=pytest.mark.thorough),
        pytest.param(["hopper", "plate"], marks=pytest.mark.thorough),
    ],
    ids=" and ".join,
)
def test_what_parts_and_simulation_say_of_shapes_holds_in_a_rollout(bodies):
    process = subprocess.run(
        [sys.executable, str(PROGRAM), *bodies], capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, process.stderr[-3000:]
    assert process.stdout.splitlines() == [f"{body} (2, 1)" for body in bodies]


def test_a_limb_has_the_lanes_of_its_body():
    assert _pushed(jnp.zeros((2, 3)), jnp.zeros(3)).shape == (2, 3)
    assert _pushed(jnp.zeros(3), jnp.zeros(3)).shape == (3,)


@pytest.mark.parametrize("ground_m", [jnp.zeros(4), jnp.zeros(()), jnp.zeros(3, int)])
def test_arrays_of_other_lanes_or_types_are_no_ground(ground_m):
    with pytest.raises(TypeCheckError):
        _pushed(jnp.zeros((2, 3)), ground_m)
