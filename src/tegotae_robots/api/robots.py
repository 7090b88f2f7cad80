"""From a robot's model, or its log, to a law on the robot: all functions of `tegotae.robots`."""

from tegotae.api.wiring import EnvironmentOptions, wiring_baseline
from tegotae_robots.api.benchmark import benchmark
from tegotae_robots.api.exporting import export_c, export_cost, export_native
from tegotae_robots.api.identifying import identify
from tegotae_robots.api.judging import benchmark_commands, benchmark_conditions
from tegotae_robots.api.suggesting_wirings import suggest_wiring
from tegotae_robots.api.template import fit_template
from tegotae_robots.api.transfer import transfer

__all__ = [
    "EnvironmentOptions",
    "benchmark",
    "benchmark_commands",
    "benchmark_conditions",
    "export_c",
    "export_cost",
    "export_native",
    "fit_template",
    "identify",
    "suggest_wiring",
    "transfer",
    "wiring_baseline",
]
