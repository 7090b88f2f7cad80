"""A control tick is traced once, whatever is recorded of it and however often it is compiled."""

import dataclasses
from dataclasses import dataclass

import jax
import numpy as np
import pytest

from tegotae import Hopper, Rollout, Scenario, Timing
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.objectives.objective import EpisodeSummary
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.simulation import xla
from tegotae.simulation.loop import ClosedLoop
from tegotae.simulation.rollout import as_lanes
from tegotae.systems.recipe import recipe


@pytest.fixture
def controller():
    """One that no other test has a trace of: its oscillator is of a class of its own."""

    @dataclass(frozen=True)
    class Own(PhaseOscillator):
        """The phase oscillator."""

    return dataclasses.replace(recipe("V-reflex-w8").controller(), oscillator=Own())


@pytest.fixture
def ticks(monkeypatch):
    """The control ticks that are traced, by their controllers."""
    controllers = []
    tick = ClosedLoop.tick

    def counted(self, *arguments):
        controllers.append(self.controller)
        return tick(self, *arguments)

    monkeypatch.setattr(ClosedLoop, "tick", counted)
    return controllers


def trace(rollout: Rollout) -> None:
    """Trace the rollout's program; nothing is compiled."""
    weights = np.zeros((2, rollout.controller.n_weights))
    lanes = as_lanes(rollout.controller, Hopper(), weights, Scenario(omega=8.0), "float32")
    body = jax.tree.map(np.float32, Hopper())
    statics = rollout.program, rollout.timing, rollout.summary
    xla._block.eval_shape(*statics, lanes, body)


def test_a_program_of_all_channels_traces_the_tick_once(controller, ticks):
    trace(Rollout(controller=controller))
    assert len(ticks) == 1


def test_programs_that_differ_in_time_and_summary_share_one_trace(controller, ticks):
    trace(Rollout(controller=controller, summary=EpisodeSummary(Fitness())))
    trace(Rollout(controller=controller, timing=Timing(duration_s=80.0)))
    trace(Rollout(controller=controller, timing=Timing(duration_s=40.0, frame_s=0.001)))
    assert len(ticks) == 1


def test_another_control_period_is_another_number_in_the_same_trace(controller, ticks):
    trace(Rollout(controller=controller, timing=Timing(tick_s=0.001)))
    trace(Rollout(controller=controller, timing=Timing(tick_s=0.002)))
    assert len(ticks) == 1


@pytest.mark.thorough
def test_an_evaluation_traces_the_tick_once_with_its_oscillator_and_once_with_it_clamped(
    controller, ticks
):
    protocol = Protocol(undisturbed_s=2.0, disturbed_s=2.0, clamped_phases=2, tick_s=0.002)
    evaluate(controller, np.ones(controller.n_weights), 8.0, protocol=protocol)
    assert len(ticks) == 2
    assert ticks.count(controller) == 1
