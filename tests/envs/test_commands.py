"""A robot on legs under commands: its odometry, what its feet are told, commands over time."""

import dataclasses

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

import mujoco

from jointed import jointed_robot
from places import ROOT
from refusals import refused
from tegotae.envs.command import CommandSchedule, VelocityCommand, heading_rate, over_feet
from tegotae.envs.mujoco.env import ModelEnv, ModelLanes
from tegotae.envs.mujoco.legs import legs_of
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.measures.robots import RobotEpisode, episode_numbers

HEXAPOD = ModelSettings(
    model=ROOT / "src" / "tegotae_robots" / "examples" / "hexapod.xml",
    feet=[f"{leg}_foot" for leg in ("LF", "LM", "LH", "RF", "RM", "RH")],
    legs=True,
    command=(0.2, -0.1, 0.5),
)


@pytest.mark.parametrize("kind", [(0, 2, 3, False), (1, 3, 2, True)])
def test_a_foot_that_stands_tells_the_velocity_of_the_trunk(kind):
    """MuJoCo moves the trunk and the joints; a foot at rest in the world is one whose velocity is
    taken away from all."""
    model = mujoco.MjModel.from_xml_string(jointed_robot(*kind))
    legs = dataclasses.replace(
        legs_of(model, [f"foot{leg}" for leg in range(kind[2])]), rolling=0.0
    )
    draw, data = np.random.default_rng(2), mujoco.MjData(model)
    moved = draw.uniform(-0.2, 0.2, legs.start.shape)
    data.qpos[model.jnt_qposadr[legs.joints]] = legs.start + moved
    rates, turning = draw.normal(size=legs.start.shape), draw.normal(size=3)
    expected = legs.trunk_velocities_m_per_s(
        (legs.start + moved)[None], rates[None], turning[None]
    )[0]
    step_s = 1e-4
    earlier, later = (
        legs.places_of((legs.start + moved + sign * step_s * rates)[None])[0] + legs.feet_m
        for sign in (-1.0, 1.0)
    )
    foot = 0.5 * (earlier + later)
    at_foot = expected + np.cross(turning, foot) + (later - earlier) / (2.0 * step_s)
    assert at_foot == pytest.approx(np.zeros_like(at_foot), abs=5e-3)


def test_round_feet_roll_and_so_a_trunk_goes_further_than_their_centres_turn():
    model = mujoco.MjModel.from_xml_string(jointed_robot(0, 2, 3, False))
    legs = legs_of(model, [f"foot{leg}" for leg in range(3)])
    assert 0.0 < legs.rolling < 0.5
    state = legs.start[None], np.ones_like(legs.start)[None], np.zeros((1, 3))
    rolls = legs.trunk_velocities_m_per_s(*state)
    slides = dataclasses.replace(legs, rolling=0.0).trunk_velocities_m_per_s(*state)
    assert rolls == pytest.approx((1.0 + legs.rolling) * slides, rel=1e-4)


def test_a_trunk_that_turns_has_other_velocities_over_its_feet():
    feet = np.array([[0.2, 0.1], [-0.2, -0.1]])
    moving = over_feet(np.array([[0.5, 0.1, 0.0], [0.0, 0.0, 2.0]]), feet)
    assert moving[0] == pytest.approx(np.array([[0.5, 0.1], [0.5, 0.1]]))
    assert moving[1] == pytest.approx(np.array([[-0.2, 0.4], [0.2, -0.4]]))


def test_a_robot_with_commands_observes_what_its_feet_are_told_and_another_one_does_not():
    env = ModelEnv(HEXAPOD)
    observed = dict(zip(env.observation_names, env.reset(seed=0)[0], strict=True))
    legs = env.sensing.legs
    expected = over_feet(np.array([HEXAPOD.command]), legs.feet_m[:, :2])[0]
    for foot, velocity in zip(legs.feet, expected, strict=True):
        assert [observed[f"{foot}_commanded_{axis}"] for axis in "xy"] == pytest.approx(velocity)
        assert abs(observed[f"{foot}_odometry_x"]) < 0.05
    assert observed["commanded_speed"] == pytest.approx(np.linalg.norm(expected, axis=1).max())
    assert observed["commanded_yaw_rate"] == 0.5
    names = env.observation_names
    env.close()
    plain = ModelEnv(dataclasses.replace(HEXAPOD, command=()))
    added = ("odometry", "commanded", "root_heading")
    assert [name for name in names if not any(part in name for part in added)] == [
        *plain.observation_names[: names.index("root_left")],
        "root_left",
        *plain.observation_names[names.index("root_left") :],
    ]
    plain.close()


def test_odometry_is_the_velocity_of_a_robot_that_is_dragged_over_its_standing_feet():
    """Feet that go back at a speed move the trunk ahead."""
    env = ModelEnv(HEXAPOD)
    names, speed = list(env.observation_names), 0.06
    env.reset(seed=0)
    rows = []
    for k in range(50):
        action = np.zeros(len(env.action_names))
        action[0::3] = 0.01 - speed * env.dt * k
        rows.append(env.step(action)[0])
    env.close()
    observed = np.array(rows)[20:].mean(axis=0)
    expected = np.mean([observed[names.index(f"{foot}_odometry_x")] for foot in HEXAPOD.feet])
    assert expected == pytest.approx(observed[names.index("root_speed")], rel=0.1)
    assert expected == pytest.approx(speed, rel=0.2)


def test_commands_hold_from_their_time_on_and_come_from_a_file(tmp_path):
    file = tmp_path / "path.csv"
    file.write_text(
        "time_s,forward_m_per_s,left_m_per_s,yaw_rate_rad_per_s\n0,0.6,0,0\n2,0,0,0.5\n"
    )
    schedule = CommandSchedule.from_command(str(file))
    numbers = schedule.commands_at(np.array([0.0, 1.99, 2.0, 50.0]))
    assert numbers[:, :3].tolist() == [[0.6, 0, 0], [0.6, 0, 0], [0, 0, 0.5], [0, 0, 0.5]]
    assert np.isnan(numbers[:, 3]).all()
    file.write_text(
        "time_s,forward_m_per_s,left_m_per_s,yaw_rate_rad_per_s,heading_rad\n0,0,0,1,\n2,0,0,0,0.5\n"
    )
    headings = CommandSchedule.from_command(file).commands_at(np.array([0.0, 2.0]))[:, 3]
    assert headings.tolist() == pytest.approx([np.nan, 0.5], nan_ok=True)
    command = VelocityCommand(forward_m_per_s=0.6, heading_rad=0.2)
    assert CommandSchedule.from_command(command).commands_at(np.zeros(1)).tolist() == [
        [0.6, 0.0, 0.0, 0.2]
    ]


def test_lanes_have_commands_of_their_own():
    schedule = CommandSchedule(np.zeros(1), np.array([[[0.1, 0.0, 0.0], [0.0, 0.2, 0.0]]]))
    lanes = ModelLanes(HEXAPOD, 2, threads=1, schedule=schedule)
    observed = lanes.reset(0, np.ones(2, bool))
    assert observed[:, lanes.names.index("commanded_forward")].tolist() == [0.1, 0.0]
    assert observed[:, lanes.names.index("commanded_left")].tolist() == [0.0, 0.2]
    lanes.close()


def test_a_heading_is_turned_to_the_shorter_way_and_not_too_fast():
    assert heading_rate(np.array([6.0, -6.0, 2.0, 0.1])) == pytest.approx(
        [-0.56637, 0.56637, 1.0, 0.2], abs=1e-4
    )


def test_a_robot_is_told_to_turn_to_its_heading_and_holds_that_which_its_yaw_rate_gave_it():
    """A robot that does not turn falls behind a yaw rate of 0.2 rad/s, and behind a set-point."""
    numbers = np.array([[[0.0, 0.0, 0.2, np.nan], [0.0, 0.0, 0.0, -0.3]]])
    lanes = ModelLanes(HEXAPOD, 2, threads=1, schedule=CommandSchedule(np.zeros(1), numbers))
    observed = lanes.reset(0, np.ones(2, bool))
    still = np.tile(lanes.sensing.still, (2, 1))
    for _ in range(50):
        observed = lanes.step(still, np.ones(2, bool))[0]
    lanes.close()
    columns = {name: observed[:, lanes.names.index(name)] for name in lanes.names[-2:]}
    error = columns["commanded_heading"] - columns["root_heading"]
    assert columns["commanded_heading"] == pytest.approx([0.2 * 50 * lanes.batch.step_s, -0.3])
    assert np.abs(columns["root_heading"]).max() < 0.05
    feet = lanes.sensing.legs.feet_m[:, :2]
    turning = np.array([[0.0, 0.0, 0.2 + 2.0 * error[0]], [0.0, 0.0, 2.0 * error[1]]])
    names = [f"{foot}_commanded_x" for foot in HEXAPOD.feet]
    felt = observed[:, [lanes.names.index(name) for name in names]]
    assert felt == pytest.approx(over_feet(turning, feet)[..., 0])


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ((0.5, 0.0), "command is .0.5, 0.0.; it must be three numbers"),
        ((0.5, float("nan"), 0.0), "left_m_per_s of the command is nan"),
        ("path.txt", "command is path.txt; a file of commands must end in .csv"),
        ("gone.csv", "cannot read gone.csv"),
    ],
)
def test_commands_that_are_none_are_refused(command, message):
    refused(message, CommandSchedule.from_command, command)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,forward_m_per_s\n0,1\n", "is no table of commands; its columns must be"),
        ("1,0,0,0\n", "time_s begins at 1; it must begin at 0"),
        ("0,0,0,0\n0,0,0,1\n", "time_s must ascend"),
        ("0,0,0,inf\n", "all numbers be finite"),
        ("0,0,0,fast\n", "is no table of commands"),
    ],
)
def test_a_file_that_is_no_table_of_commands_is_refused(text, message, tmp_path):
    head = (
        ""
        if text.startswith("time")
        else ",".join(("time_s", "forward_m_per_s", "left_m_per_s", "yaw_rate_rad_per_s")) + "\n"
    )
    file = tmp_path / "path.csv"
    file.write_text(head + text)
    refused(message, CommandSchedule.from_command, file)


def test_a_command_needs_legs():
    refused("add legs=true", ModelSettings, model="quadruped", command=(0.1, 0.0, 0.0))


@pytest.mark.parametrize(("share", "off"), [(1.0, 0.0), (0.6, 0.2)])
def test_displacement_counts_along_the_commanded_path_and_turning_as_the_gyroscope_has_it(
    share, off
):
    """A circle at 1 m/s and 0.5 rad/s; a robot that turns away goes on along its tangent."""
    step_s, rate = 0.01, 0.5
    time_s = step_s * np.arange(1, 401)
    zero, unit = np.zeros_like(time_s), np.ones_like(time_s)
    columns = {
        "commanded_forward": unit,
        "commanded_left": zero,
        "commanded_yaw_rate": rate * unit,
        "commanded_heading": rate * time_s,
        "root_forward": share * np.sin(rate * time_s) / rate,
        "root_left": share * (1.0 - np.cos(rate * time_s)) / rate,
        "root_heading": (rate + off) * time_s,
    }
    episode = RobotEpisode(
        time_s=time_s,
        observation=np.stack([*columns.values()], axis=1),
        names=(*columns,),
        action=np.zeros((400, 1)),
        reward=zero,
        phase_rad=np.zeros((400, 1)),
        lasted=1.0,
        fitness=0.0,
        step_s=step_s,
    )
    numbers = episode_numbers(episode)
    assert numbers["followed"] == pytest.approx(share, rel=0.01)
    assert numbers["heading_error_rad"] == pytest.approx(off * 4.0)
    plain = dataclasses.replace(episode, names=("a", "b", "c", *episode.names[3:]))
    assert "followed" not in episode_numbers(plain)
