"""Figures and animations, registered on what a simulator gives: results know no pictures."""

from __future__ import annotations

from contextlib import suppress
from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from tegotae._support.errors import MissingExtraError, TegotaeError
from tegotae.analysis.gaits.releases import GaitRun
from tegotae.analysis.simulation import Result
from tegotae.figures import animation
from tegotae.figures.gaits import animation as gait_animation
from tegotae.figures.gaits.lags import footfall_figure, lags_figure
from tegotae.figures.recording import recording_figure
from tegotae.figures.rollout import episode_figure, rollout_figure
from tegotae.figures.style import literal_text, styled

if TYPE_CHECKING:
    from tegotae.training.environments.replay import Replay


@singledispatch
def figures(raw: Any, note: str) -> dict[str, Figure]:
    """Pictures by name, the most telling one first.

    Args:
        raw: of the simulator.
        note: a title.
    """
    raise TegotaeError(f"there is no figure of a {type(raw).__name__}")


@figures.register
def _(raw: Result, note: str) -> dict[str, Figure]:
    return {"rollout": rollout_figure(raw)}


@figures.register
def _(raw: GaitRun, note: str) -> dict[str, Figure]:
    title = literal_text(note)
    return {"footfall": footfall_figure(raw, title), "lags": lags_figure(raw, title)}


def _of_replay(raw: Replay, note: str) -> dict[str, Figure]:
    """The gait as that of a recording where its hops can be measured, else loads and phases."""
    measured, rest_length_m = raw.episode.hopping, raw.experiment.wiring.rest_length_m
    title = literal_text(note)
    loads = {"loads": episode_figure(raw, note=title)}
    if measured is None or rest_length_m is None:
        return loads
    return {"gait": recording_figure(measured, rest_length_m=rest_length_m, note=title), **loads}


@singledispatch
def animation_of(raw: Any) -> animation.Animation:
    """What moves.

    Args:
        raw: of the simulator.
    """
    raise TegotaeError(f"there is no animation of a {type(raw).__name__}")


animation_of.register(Result, animation.animation)
animation_of.register(GaitRun, gait_animation.gait_animation)

with suppress(MissingExtraError):  # without Gymnasium there is no replay to draw
    from tegotae.training.environments.replay import Replay

    figures.register(Replay, _of_replay)
    animation_of.register(Replay, animation.film_animation)


def animate(raw: Any, path: Path | str) -> Path:
    """Write the animation, whole or not at all, as .gif, or .mp4 where ffmpeg is installed.

    Args:
        raw: of the simulator.
        path: the file.

    Raises:
        TegotaeError: for what cannot be drawn, another ending, a missing ffmpeg, or a file that
            cannot be written.
    """
    path = animation.animation_file(path)
    with styled():
        return animation.save_animation(animation_of(raw), path)
