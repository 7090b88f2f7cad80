"""Search for the settings of the learning algorithms, through Optuna (extra "tune").

What is open here: `SPACES`, one entry per algorithm, says what may be tried, and how.
"""

from research.studies.tuning.record import describe
from research.studies.tuning.spaces import SPACES, Space
from research.studies.tuning.task import TuningTask
from research.studies.tuning.tuner import evaluate_settings, tune

__all__ = ["SPACES", "Space", "TuningTask", "describe", "evaluate_settings", "tune"]
