"""Inverse kinematics in C: the geometry of legs, a step towards their joints, and their loads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae_robots.c.reader import CReader
from tegotae_robots.c.text import floating, wrapped
from tegotae_robots.c.trace import Piece, traced

if TYPE_CHECKING:
    from tegotae.envs.mujoco.legs import LegKinematics
    from tegotae_robots.c.plan import Export

COMMAND_SENSES = ("odometry_x", "odometry_y", "commanded_x", "commanded_y", "commanded_speed")
"""Senses of a robot's commands and of what came of them."""
_ROWS = 200
"""Places of a check."""
_TURN = 0.25
"""Largest turn of joints for these places [rad], or slide over the leg's length."""


def leg_pieces(legs: LegKinematics, *, odometry: bool = False) -> list[Piece]:
    """Return the pieces of `LegKinematics`: the solution's start and step, the load on a foot and,
    for odometry, its place and velocity.
    """
    from tegotae.envs.mujoco.chains import (
        Chains,
        borne,
        direct,
        foot_velocities,
        has_closed_form,
        kinematics,
        nearer,
    )

    reader, n = CReader(), legs.joints.shape[1]
    shapes = {"axis": (n, 3), "anchor": (n, 3), "foot": (3,)}
    shapes |= dict.fromkeys(("slides", "low", "high"), (n,))
    vectors = {"wanted": 3, "moved": n, "torque": n, "rates": n}

    def texts(name: str, shape: tuple[int, ...]) -> list[str]:
        return [name + "".join(f"[{i}]" for i in index) for index in np.ndindex(shape)]

    def piece(
        name: str,
        function: Callable[..., Any],
        arguments: tuple[str, str] | tuple[str],
        results: Sequence[str],
        comment: str,
    ) -> Piece:
        def evaluate(geometry: Mapping[str, Sequence[jax.Array]], **values: Any) -> Any:
            rows: Any = {k: jnp.stack(x).reshape(1, *shapes[k]) for k, x in geometry.items()}
            return function(Chains(**rows), *([x[:, None] for x in values[k]] for k in arguments))

        geometry = {name: texts(f"leg->{name}", shape) for name, shape in shapes.items()}
        given = {k: texts(k, (vectors[k],)) for k in arguments}
        return traced(reader, name, evaluate, results, comment, geometry=geometry, **given)

    def closed(chains: Chains, wanted: Any) -> list[jax.Array]:
        found, there = direct(chains, wanted)
        return [*found, there]

    def load(*state: Any) -> jax.Array:
        return borne(*state)[2]

    def motion(chains: Chains, moved: Any, rates: Any) -> list[Any]:
        return [*kinematics(chains, moved)[0], *foot_velocities(chains, moved, rates)]

    joints = [f"joint_{k}" for k in range(n)]
    in_closed_form = "Joints in closed form, and 1 if they need no further step."
    step = "Joints one step nearer to where they put the foot: damped least squares."
    upward = "The ground's upward force on the foot, that holds a leg without mass."
    moves = [f"{quantity}_{axis}" for quantity in ("foot", "velocity") for axis in "xyz"]
    description = "The foot's place and velocity in the axes of the trunk, over the leg's length."
    start = ("direct", closed, ("wanted",), [*joints, "there"], in_closed_form)
    return [
        *([piece(*start)] if has_closed_form(legs.chains) else []),
        piece("nearer", nearer, ("wanted", "moved"), joints, step),
        piece("load", load, ("moved", "torque"), ["upward"], upward),
        *([piece("motion", motion, ("moved", "rates"), moves, description)] if odometry else []),
    ]


def has_odometry(export: Export) -> bool:
    """Return True if the controller takes commands, and senses the odometry of its legs."""
    return export.legs is not None and {*COMMAND_SENSES} <= {*export.senses}


def leg_facts(export: Export) -> dict[str, Any]:
    """Return the values that templates take of legs; none for a controller that commands no feet of
    a model."""
    legs = export.legs
    if legs is None:
        return {"has_legs": False, "has_odometry": False, "legs": []}
    from tegotae.envs.mujoco.chains import STEPS, has_closed_form
    from tegotae.envs.mujoco.legs import STANDS

    order, axes = _wired(export)
    unit = np.where(legs.chains.slides, legs.length_m, 1.0)
    geometry = (*legs.chains, legs.start, unit)
    table = [_braced([np.asarray(part, float)[leg] for part in geometry]) for leg in order]
    several = "[i]" if export.limbs > 1 else ""
    places = [f"leg->foot[{i}]" for i in range(3)]
    for axis, name in zip(axes, export.outputs, strict=False):
        places[axis] += f" + over_length(out->{name}{several})"
    return {
        "has_legs": True,
        "legs": [{"foot": legs.feet[k], "names": ", ".join(legs.joint_names[k])} for k in order],
        "joints": legs.joints.shape[1],
        "steps": STEPS,
        "has_closed_form": has_closed_form(legs.chains),
        "length": floating(legs.length_m),
        "has_odometry": has_odometry(export),
        "rolling": floating(1.0 + legs.rolling),
        "stands": floating(STANDS),
        "rises": floating(legs.rising_m_per_s / legs.length_m),
        "table": ",\n".join(wrapped(row) for row in table),
        "places": ", ".join(places),
    }


def leg_rows(export: Export) -> np.ndarray:
    """Return places, the joints that put the feet there, torques, and their loads, [rows, numbers].

    All are limb by limb; places are only those that the controller commands.
    """
    legs, (order, axes) = export.legs, _wired(export)
    assert legs is not None
    draw, shape = np.random.default_rng(0), (_ROWS, *legs.joints.shape)
    room = np.minimum(0.5 * np.minimum(legs.chains.high, -legs.chains.low), _TURN)
    unit = np.where(legs.chains.slides, legs.length_m, 1.0)
    place = legs.places_of(legs.start + unit * room * draw.uniform(-1.0, 1.0, shape))
    place[..., [i for i in range(3) if i not in axes]] = 0.0
    joints, torques = legs.joints_at(place), draw.uniform(-1.0, 1.0, shape)
    torques *= legs.joints >= 0
    loads = np.maximum(legs.forces_n(joints, torques)[..., 2], 0.0)
    parts = [np.moveaxis(place[:, order][..., axes], 2, 1), joints[:, order], torques[:, order]]
    return np.hstack([x.reshape(_ROWS, -1) for x in (*parts, loads[:, order])])


def _wired(export: Export) -> tuple[list[int], list[int]]:
    """Return the leg of every limb, and the axis of every command."""
    legs, task = export.legs, export.saved.task
    assert legs is not None
    assert task is not None
    indices = [
        [divmod(legs.names.index(name), 3) for name in limb.drives] for limb in task.wiring.limbs
    ]
    for limb, drives in zip(task.wiring.limbs, indices, strict=True):
        uniform = [axis for _, axis in drives] == [axis for _, axis in indices[0]]
        if not uniform or len({leg for leg, _ in drives}) > 1:
            raise TegotaeError(
                f"a limb drives {', '.join(limb.drives)}; for C each must drive one foot, along "
                "the axes of the first, in their order"
            )
    return [drives[0][0] for drives in indices], [axis for _, axis in indices[0]]


def _braced(numbers: Any) -> str:
    """Return numbers as an initialiser of C."""
    if isinstance(numbers, list | np.ndarray):
        return f"{{{', '.join(map(_braced, numbers))}}}"
    return floating(float(numbers))
