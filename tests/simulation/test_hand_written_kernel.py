"""The kernel of the benchmarks makes the engine's numbers: a third way to the same equations."""

import numpy as np
import pytest

from research.benchmarks import engine, kernel
from tegotae.simulation.rollout import Rollout, Scenario, Timing

compiler = kernel.compiler()


@pytest.mark.skipif(compiler is None, reason="no C++ compiler")
def test_the_kernel_climbs_and_works_as_the_engine_does():
    weights = engine.weights(64)
    reference = Rollout(
        controller=engine.benchmark_controller(),
        timing=Timing(duration_s=2.0),
        summary=engine.totals,
    )
    with kernel.CompiledKernel(compiler) as by_hand:
        totals, *_ = by_hand.run(weights, 2000)
    climbed, work, failed = (np.asarray(x) for x in reference.run(weights, Scenario(omega=5.0)))
    assert np.mean(climbed > 0.05) > 0.3, "many hop"
    np.testing.assert_allclose(totals[0], climbed, atol=2e-5)
    np.testing.assert_allclose(totals[1], work, atol=2e-5)
    np.testing.assert_array_equal(totals[2] > 0.0, failed)
