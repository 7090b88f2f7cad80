"""Parameters of bodies in words, for axes and titles."""

from __future__ import annotations

from tegotae.analysis.gaits.parameter_axes import OMEGA, SIGMA, Axis
from tegotae.figures.style import literal
from tegotae.systems.legged import Legged

_FIELDS = {
    "com_x_m": ("centre of mass, forward", "m"),
    "com_y_m": ("centre of mass, to the left", "m"),
    "com_z_m": ("centre of mass, upward", "m"),
    "inertia_ratio": ("inertia ratio", ""),
    "mass_kg": ("mass", "kg"),
    "stiffness_n_per_m": ("stiffness", "N/m"),
    "damping_ns_per_m": ("damping", "N s/m"),
    "rest_length_m": ("leg length", "m"),
}
"""Fields of bodies in words, and their units."""


def label(axis: Axis, legged: Legged) -> str:
    """A parameter as it is written at an axis."""
    if axis.name == OMEGA:
        return f"frequency ω [rad/{legged.units[1]}]"
    if axis.name == SIGMA:
        return "gain σ"
    per_leg = isinstance(getattr(legged.body, axis.name), tuple)
    words, unit = _FIELDS.get(axis.name, (axis.name, ""))
    if unit == "m" and legged.dimensionless:
        unit = "l0"
    unit = "times usual" if per_leg else unit
    return literal(f"{words} [{unit}]" if unit else words)


def setting(assigned: str) -> str:
    """A field and its value, as on the command line, as it is written in a title.

    Example:
        >>> setting("inertia_ratio=0.35"), setting("my_field=1")
        ('inertia ratio 0.35', 'my_field 1')
    """
    name, _, value = assigned.partition("=")
    return f"{_FIELDS.get(name, (name, ''))[0]} {value}"
