"""Search for the settings of the learning algorithms, through Optuna (extra "tune").

What is open here: `SPACES`, one entry per algorithm, says what may be tried and how it is judged.
"""

from tegotae.tuning.record import describe
from tegotae.tuning.spaces import SPACES, Space
from tegotae.tuning.task import Task
from tegotae.tuning.tuner import judge, tune

__all__ = ["SPACES", "Space", "Task", "describe", "judge", "tune"]
