"""Controllers that were trained on an environment as C: the same limbs, in the same closed loop."""

import dataclasses
import subprocess

import numpy as np
import pytest

import tegotae as tg
from compiled import FLAGS, Compiled, needs_gcc
from tegotae.envs import Limb, Wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.wrapper import Pilot
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.training.environments.experiment import EnvExperiment
from tegotae_robots.c import Export
from tegotae_robots.c.plan import usual_tick_s

pytest.importorskip("mujoco")
LEGS = Wiring(
    limbs=[
        Limb(senses={"spring_force": "leg_spring"}, drives="leg", rest=0.1, push=0.9),
        Limb(senses={"spring_force": "-knee"}, drives="knee", rest=2.0, push=-1.0, phase_rad=3.0),
    ],
    scales={"spring_force": 0.981, "feedback": 3.132},
    max_force=2.0,
    sector_rad=(3.0, 2.0),
)


def trained(model: str, wiring: Wiring = LEGS, **settings) -> tuple[EnvExperiment, SavedController]:
    """A model with random weights, as a training on the MuJoCo hopper saves it."""
    spec = EnvSpec(env="hopper", settings=tuple(settings.items()))
    task = EnvExperiment.from_recipe(recipe(model), spec, wiring, omega=8.0, budget=24)
    weights = 2.0 * np.random.default_rng(3).standard_normal(task.controller.n_weights)
    return task, SavedController(task.system, weights, model, task=task.task)


@needs_gcc
@pytest.mark.parametrize("model", ["AR-rF-sector-w8", "ART-rF-tphif-w8"])
def test_a_mujoco_body_moves_under_the_c_as_under_the_limbs_that_were_trained(model, tmp_path):
    single = dataclasses.replace(
        LEGS,
        limbs=[Limb(senses={"spring_force": "leg_spring"}, drives="leg", rest=0.0, push=4.0)],
    )
    task, saved = trained(model, single, control_s=0.01)
    program = Compiled(Export(saved, usual_tick_s(saved)), tmp_path)
    env = task.spec.make()
    pilot = Pilot(task.wires, task.wiring, saved.weights[:, None])
    felt = task.wires.observed.index("leg_spring")

    def of_package(observation):
        return pilot.act(observation[None])[0]

    def of_c(observed):
        force = program.step([max(observed[felt], 0.0)])[0, 0]
        return np.array([program.number("action", force)])

    def heights(act):
        readings, _ = env.reset(seed=0)
        pilot.reset()
        program.init(0.0)
        result = []
        for _ in range(150):
            readings = env.step(act(readings))[0]
            result.append(readings[0])
        return np.array(result)

    package = heights(of_package)
    assert np.ptp(package) > 0.1, "it does not move"
    assert np.abs(heights(of_c) - package).max() < 1e-5


@needs_gcc
def test_what_limbs_do_on_an_environment_passes_the_programs_own_check(tmp_path):
    _, saved = trained("AR-rF-sector-w8")
    tg.robots.export_c(saved, tick_s=0.02, prefix="legs").save(tmp_path)
    command = ["gcc", *FLAGS, "-O1", "legs.c", "test_legs.c", "-lm", "-o", "check"]
    subprocess.run(command, check=True, cwd=tmp_path)
    process = subprocess.run([tmp_path / "check"], capture_output=True, text=True)
    assert process.returncode == 0, process.stdout
    header = (tmp_path / "legs.h").read_text()
    assert "#define LEGS_PHASE_RAD {0.0f, 3.0f}" in header
    assert "limb 1: spring_force is -knee, drives knee" in " ".join(header.split())


def test_an_export_is_at_the_control_period_of_the_training():
    _, saved = trained("ART-rF-tphif-w8", control_s=0.02)
    answer = tg.robots.export_c(saved)
    assert answer.notes == []
    assert "#define TEGOTAE_TICK_S 0.02f" in answer.files["tegotae.h"]
