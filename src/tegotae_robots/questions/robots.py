"""From a robot's model, or its log, to a law on the robot: all functions of `tegotae.robots`."""

from tegotae.questions.wiring import EnvironmentOptions, wiring_baseline
from tegotae_robots.questions.benchmark import benchmark
from tegotae_robots.questions.exporting import export_c, export_cost, export_native
from tegotae_robots.questions.identifying import identify
from tegotae_robots.questions.suggesting_wirings import suggest_wiring
from tegotae_robots.questions.template import fit_template
from tegotae_robots.questions.transfer import transfer

__all__ = [
    "EnvironmentOptions",
    "benchmark",
    "export_c",
    "export_cost",
    "export_native",
    "fit_template",
    "identify",
    "suggest_wiring",
    "transfer",
    "wiring_baseline",
]
