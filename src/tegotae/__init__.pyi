"""The public names, and the modules that have them: the package fetches each from there."""

from tegotae._support.errors import TegotaeError as TegotaeError
from tegotae.api import gaits as gaits, plot as plot
from tegotae.api.about import cite as cite
from tegotae.api.controllers import (
    load as load,
    load_all as load_all,
)
from tegotae.api.demo import demo as demo
from tegotae.api.hopping import HopperController as HopperController
from tegotae.api.listing import list_models as list_models
from tegotae.api.measuring import measure as measure
from tegotae.api.training import train as train
from tegotae.api.walking import WalkerController as WalkerController
from tegotae.measures.check import check as check
from tegotae.parts.bodies import (
    Body as Body,
    Hopper as Hopper,
    Walker as Walker,
)
from tegotae.parts.controller import Controller as Controller
from tegotae.simulation.rollout import (
    Rollout as Rollout,
    Timing as Timing,
)
from tegotae.simulation.world import Scenario as Scenario
from tegotae.systems.controller_file import (
    SavedController as SavedController,
    save as save,
)
from tegotae.systems.experiment import Experiment as Experiment
from tegotae.systems.recipe import recipe as recipe
from tegotae.systems.registry import register as register
from tegotae.systems.system import System as System
from tegotae_robots.api import robots as robots

__version__: str
