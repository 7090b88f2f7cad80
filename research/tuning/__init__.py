"""Search for the settings of the learning algorithms, through Optuna (extra "tune").

What is open here: `SPACES`, one entry per algorithm, says what may be tried, and how.
"""

from research.tuning.record import describe
from research.tuning.spaces import SPACES, Space
from research.tuning.task import TuningTask
from research.tuning.tuner import evaluate_settings, tune

__all__ = ["SPACES", "Space", "TuningTask", "describe", "evaluate_settings", "tune"]
