"""Integrators: how controller and body advance by one control tick."""

from tegotae.integrators.base import Drive, Integrator, Moment
from tegotae.integrators.hold import Hold
from tegotae.integrators.predictor_corrector import PredictorCorrector

__all__ = ["Drive", "Hold", "Integrator", "Moment", "PredictorCorrector"]
