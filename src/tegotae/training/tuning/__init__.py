"""Search for the settings of the learning algorithms, through Optuna (extra "tune").

What is open here: `SPACES`, one entry per algorithm, says what may be tried, and how.
"""

from tegotae.training.tuning.record import describe
from tegotae.training.tuning.spaces import SPACES, Space
from tegotae.training.tuning.task import Task
from tegotae.training.tuning.tuner import evaluate_settings, tune

__all__ = ["SPACES", "Space", "Task", "describe", "evaluate_settings", "tune"]
