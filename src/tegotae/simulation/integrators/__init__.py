"""Integrators: how controller and body advance by one control tick."""

from tegotae.simulation.integrators.base import Drive, Integrator, Moment
from tegotae.simulation.integrators.hold import Hold
from tegotae.simulation.integrators.predictor_corrector import PredictorCorrector

__all__ = ["Drive", "Hold", "Integrator", "Moment", "PredictorCorrector"]
