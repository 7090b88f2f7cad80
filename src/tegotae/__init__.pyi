"""The public names and their types; `_HOMES` of the module has where each is fetched from."""

from tegotae._support.errors import TegotaeError as TegotaeError
from tegotae.measures.evaluation import Protocol as Protocol
from tegotae.measures.objectives.fitness import Fitness as Fitness
from tegotae.parts.bodies import (
    Bar as Bar,
    Body as Body,
    Hopper as Hopper,
    Walker as Walker,
)
from tegotae.parts.controller import (
    Controller as Controller,
    Tegotae as Tegotae,
)
from tegotae.questions.about import cite as cite
from tegotae.questions.drawing import (
    figure_basin as figure_basin,
    figure_learning_curves as figure_learning_curves,
    figure_phase_locking as figure_phase_locking,
    figure_phase_response as figure_phase_response,
    figure_poincare as figure_poincare,
    figure_portrait as figure_portrait,
    figure_surface as figure_surface,
)
from tegotae.questions.explaining import explain as explain
from tegotae.questions.gaits import (
    gait_front as gait_front,
    gait_lesion as gait_lesion,
    gait_map as gait_map,
    gait_stability as gait_stability,
    gait_sweep as gait_sweep,
)
from tegotae.questions.generalising import generalise as generalise
from tegotae.questions.listing import models as models
from tegotae.questions.measuring import measure as measure
from tegotae.questions.training import train as train
from tegotae.questions.verbs import (
    compare as compare,
    evaluate as evaluate,
    simulate as simulate,
)
from tegotae.questions.wiring import wiring_baseline as wiring_baseline
from tegotae.simulation.checks import (
    check_body as check_body,
    check_controller as check_controller,
    check_oscillator as check_oscillator,
    check_term as check_term,
)
from tegotae.simulation.rollout import (
    Engine as Engine,
    Timing as Timing,
    Trajectory as Trajectory,
)
from tegotae.simulation.world import (
    Scenario as Scenario,
    Step as Step,
)
from tegotae.systems.controller_file import (
    ControllerSet as ControllerSet,
    SavedController as SavedController,
    load as load,
    save as save,
)
from tegotae.systems.experiment import Experiment as Experiment
from tegotae.systems.legged import Legged as Legged
from tegotae.systems.models import (
    Model as Model,
    all_models as all_models,
    build as build,
    find as find,
)
from tegotae.systems.registry import register as register
from tegotae.systems.system import (
    Release as Release,
    System as System,
)
from tegotae_robots.questions.benchmark import benchmark_run as benchmark_run
from tegotae_robots.questions.exporting import (
    export_c as export_c,
    export_cost as export_cost,
    export_native as export_native,
)
from tegotae_robots.questions.identifying import identify as identify
from tegotae_robots.questions.suggesting_wirings import wiring_suggest as wiring_suggest
from tegotae_robots.questions.template import template as template
from tegotae_robots.questions.transfer import wiring_transfer as wiring_transfer

__version__: str
