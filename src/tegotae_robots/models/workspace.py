"""The workspace of feet: where they reach, and the ellipse that a wiring sends them on."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.parts.terms.foot import EllipticFoot
from tegotae_robots.models.suggesting import Suggestion
from tegotae_robots.models.suggesting_legs import workspace

_PLANES = {"from the side": (0, 2), "from the front": (1, 2)}
_NAMES = ("ahead x [m]", "left y [m]", "up z [m]")


@styled()
def workspace_figure(suggestion: Suggestion) -> Figure:
    """Draw places within reach of every foot, from the side and from the front, one column per leg.

    Places are from the foot's at rest. A dot is the first joint of the leg, a line the ellipse of
    the wiring's law, where it has one.

    Args:
        suggestion: with legs.
    """
    legs, wiring = suggestion.legs, suggestion.wiring
    assert legs is not None
    figure = new_figure(PAGE_IN, 0.2 + 2.0 * PAGE_IN / (max(len(legs.feet), 4) + 0.5))
    wide = np.array([-0.8, 0.8]) * legs.length_m
    panels = figure.subplots(2, len(legs.feet), sharey=True, squeeze=False)
    hips = legs.length_m * (legs.chains.anchor[:, 0] - legs.chains.foot)
    ellipse, phase = wiring.controller.actuation, np.linspace(0.0, 2.0 * np.pi, 100)
    for row, (title, (first, second)) in zip(panels, _PLANES.items(), strict=True):
        along, within = workspace(legs, (first, second))
        row[0].set_ylabel(f"{title}\n{_NAMES[second]}")
        for leg, axes in enumerate(row):
            axes.contourf(along, along, within[..., leg].T, levels=[0.5, 1.5], colors=["0.88"])
            axes.plot(*hips[leg, [first, second]], "o", color=COLOURS[0], markersize=3)
            if isinstance(ellipse, EllipticFoot) and first == 0:
                place = ellipse.place(np.sin(phase), np.cos(phase))
                assert wiring.units is not None
                axes.plot(*np.asarray(place) * wiring.units.length_m, color=COLOURS[1])
            axes.plot(0.0, 0.0, "+", color="black", markersize=4)
            axes.set(aspect="equal", xlabel=_NAMES[first], xlim=wide, ylim=wide)
            axes.locator_params(nbins=3)
    for axes, foot in zip(panels[0], legs.feet, strict=True):
        axes.set_title(foot)
    return figure
