"""Inverse kinematics in C: the geometry of legs, a step towards their joints, and their loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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

_ROWS = 200
"""Places of a check."""
_TURN = 0.25
"""Largest turn of joints for these places [rad], or slide over the leg's length."""


def leg_pieces(legs: LegKinematics) -> list[Piece]:
    """Return the pieces of `LegKinematics`: the solution's start and step, and the load on a
    foot.
    """
    from tegotae.envs.mujoco.chains import Chains, borne, direct, has_closed_form, nearer

    reader, n = CReader(), legs.joints.shape[1]
    numbers = {name: f"leg->{name}[{{}}]" for name in ("slides", "foot", "low", "high")}
    triples = {name: f"leg->{name}[{{}}][{{}}]" for name in ("axis", "anchor")}
    geometry = {
        name: [text.format(i) for i in range(3 if name == "foot" else n)]
        for name, text in numbers.items()
    } | {
        name: [text.format(k, i) for k in range(n) for i in range(3)]
        for name, text in triples.items()
    }

    def chains(geometry: Mapping[str, Sequence[jax.Array]]) -> Chains:
        rows = {name: jnp.stack(texts).reshape(1, -1) for name, texts in geometry.items()}
        fields: Any = rows | {name: rows[name].reshape(1, n, 3) for name in triples}
        return Chains(**fields)

    def of_leg(array: Sequence[jax.Array]) -> list[jax.Array]:
        return [x[:, None] for x in array]

    def closed(geometry: Any, wanted: Any) -> list[jax.Array]:
        found, there = direct(chains(geometry), of_leg(wanted))
        return [*found, there]

    def step(geometry: Any, wanted: Any, moved: Any) -> list[jax.Array]:
        return nearer(chains(geometry), of_leg(wanted), of_leg(moved))

    def load(geometry: Any, moved: Any, torque: Any) -> jax.Array:
        return borne(chains(geometry), of_leg(moved), of_leg(torque))[2]

    def indexed(name: str, count: int) -> list[str]:
        return [f"{name}[{i}]" for i in range(count)]

    moved, torque = indexed("moved", n), indexed("torque", n)
    comment = "Joints one step nearer to where they put the foot: damped least squares."
    results = [f"joint_{k}" for k in range(n)]
    wanted = indexed("wanted", 3)

    def in_closed_form() -> Piece:
        return traced(
            reader,
            "direct",
            closed,
            [*results, "there"],
            "Joints in closed form, and 1 if they need no further step.",
            geometry=geometry,
            wanted=wanted,
        )

    return [
        *([in_closed_form()] if has_closed_form(legs.chains) else []),
        traced(
            reader, "nearer", step, results, comment, geometry=geometry, wanted=wanted, moved=moved
        ),
        traced(
            reader,
            "load",
            load,
            ["upward"],
            "The ground's upward force on the foot, that holds a leg without mass.",
            geometry=geometry,
            moved=moved,
            torque=torque,
        ),
    ]


def leg_facts(export: Export) -> dict[str, Any]:
    """Return the values that templates take of legs; none for a controller that commands no feet of
    a model."""
    legs = export.legs
    if legs is None:
        return {"has_legs": False, "legs": []}
    from tegotae.envs.mujoco.chains import STEPS, has_closed_form

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
