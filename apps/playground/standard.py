"""The controllers of the page that comes without any of one's own."""

from __future__ import annotations

from importlib import resources

from apps.playground.page import ControllerChoice
from tegotae.api.demo import CONTROLLER
from tegotae.systems import controller_file
from tegotae.systems.resolve import resolve
from tegotae.training.collection import controller_of

LABELS = {
    "vanilla": "V: nothing learned",
    "art": "ART: learned A, R and T",
    "ar": "AR: learned A and R, hops at 4 rad/s",
    "argt": "ARGT: all learned",
}
"""Labels by the names of their files, in the order of the page."""
DEMO = "ART, as tegotae demo shows it"
"""Label of the last controller, that of `tegotae demo`."""


def standard() -> list[ControllerChoice]:
    """Return the paper's vanilla controller, three learned ones, trained as docs/playground.md
    says, and that of `tegotae demo`.

    Example:
        >>> [choice.saved.name for choice in standard()][0]
        'V-sector-w8'
    """
    folder = resources.files("apps.playground") / "controllers"
    choices = []
    for name, label in LABELS.items():
        with resources.as_file(folder / f"{name}.json") as path:
            choices.append(ControllerChoice(label, controller_file.load(path)))
    return [*choices, ControllerChoice(DEMO, controller_of(resolve(CONTROLLER)))]
