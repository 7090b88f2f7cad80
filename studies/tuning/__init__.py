"""Search for the settings of the learning algorithms, through Optuna (extra "tune").

What is open here: `SPACES`, one entry per algorithm, says what may be tried, and how.
"""

from studies.tuning.record import describe
from studies.tuning.spaces import SPACES, Space
from studies.tuning.task import TuningTask
from studies.tuning.tuner import evaluate_settings, tune

__all__ = ["SPACES", "Space", "TuningTask", "describe", "evaluate_settings", "tune"]
