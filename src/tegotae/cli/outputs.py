"""The files that a simulation was asked for, checked before it begins."""

from __future__ import annotations

from pathlib import Path

from tegotae._support.files import output_file


def check_outputs(csv: Path | None, plot: Path | None, animate: Path | None) -> None:
    """Raise `TegotaeError` if a file could not be written.

    Args:
        csv: file of the time series.
        plot: file of a figure.
        animate: file of an animation.
    """
    if csv is not None:
        output_file(csv)
    if plot is not None:
        from tegotae.figures.style import figure_file

        figure_file(plot)
    if animate is not None:
        from tegotae.figures.animation import animation_file

        animation_file(animate)
