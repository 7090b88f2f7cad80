"""The node of a legged robot: it walks a model over a bad link, within its limits, and replays."""

from __future__ import annotations

import importlib
import shutil
import socket
import subprocess
import sys

import numpy as np
import pytest

from places import ROOT
from tegotae import cli

HARDWARE = ROOT / "examples" / "hardware"
ROBOT = ROOT / "examples" / "robots" / "servo_quadruped.xml"
FEET = [f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")]
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture
def example(monkeypatch):
    """Imports a file of the examples."""
    monkeypatch.syspath_prepend(HARDWARE)
    for path in HARDWARE.glob("*.py"):
        monkeypatch.delitem(sys.modules, path.stem, raising=False)
    return importlib.import_module


@pytest.fixture(scope="module")
def law(tmp_path_factory):
    """The file of a walker's law on a robot, and the folder of its C."""
    pytest.importorskip("mujoco")
    folder = tmp_path_factory.mktemp("legged")
    wiring, file, robot = (str(folder / name) for name in ("legs.toml", "law.json", "robot"))
    where = ["--feet", *FEET, "--settings", "legs=true"]
    assert not cli.main(["wiring", "suggest", str(ROBOT), *where, "--out", wiring])
    env = ["--env", str(ROBOT), "--wiring", wiring]
    assert not cli.main(["wiring", "transfer", "quadruped-c", *env, *where, "--out", file])
    assert not cli.main(["export", "c", file, "--out", robot])
    return file, robot


def walked(example, law, seconds, **bad):
    """A robot and its node, a packet at a time over two ports; both, and the log."""
    link, file_folder = example("legged_link"), law
    robot, node = example("legged_robot").Robot(*file_folder), example("legged_node").Node(law[1])
    there, back, log = link.Link(1, **bad), link.Link(2, **bad), b""
    with (
        socket.socket(type=socket.SOCK_DGRAM) as ours,
        socket.socket(type=socket.SOCK_DGRAM) as theirs,
    ):
        for port in (ours, theirs):
            port.bind(("127.0.0.1", 0))
            port.settimeout(10.0)
        ours.connect(theirs.getsockname())
        theirs.connect(ours.getsockname())
        for _ in range(round(seconds / link.PERIOD_S)):
            command = b""
            if state := there.passed(robot.state()):
                theirs.send(state)
                ours.send(command := node.answer(ours.recv(link.STATE.size)))
                log += state + command
                command = theirs.recv(link.COMMAND.size)
            robot.step(back.passed(command))
    return robot, node, log


def test_it_walks_over_a_bad_link_and_its_log_replays_to_the_bit(example, law, tmp_path):
    robot, node, log = walked(example, law, 6.0, late=1, jitter=2, lost=0.1)
    assert not node.stopped
    assert not robot.fell
    assert robot.sensed("root_forward") > 0.3
    assert example("legged_node").replayed(law[1], log) > 2900
    worse = bytearray(log)
    worse[-1] ^= 1
    with pytest.raises(SystemExit, match="another answer"):
        example("legged_node").replayed(law[1], bytes(worse))
    (tmp_path / "walk.log").write_bytes(log)
    words = [sys.executable, "legged_walk.py", law[1], "--replay", str(tmp_path / "walk.log")]
    ran = subprocess.run(words, cwd=HARDWARE, capture_output=True, text=True, check=True)
    assert ran.stdout.endswith("answers, all the same\n")


def test_a_link_gives_the_newest_that_came_and_loses_its_share(example):
    link = example("legged_link")
    packets = [link.COMMAND.pack(k, 1, *[0.0] * 12) for k in range(1, 1001)]
    late = link.Link(0, late=3)
    assert [link.count_of(late.passed(x)) for x in packets] == [0, 0, 0, *range(1, 998)]
    bad = link.Link(0, jitter=4, lost=0.2)
    counts = [link.count_of(bad.passed(x)) for x in packets]
    assert counts == sorted(counts)
    assert link.count_of(link.Link(0, lost=1.0).passed(packets[0])) == 0


def state_of(link, count, angles=0.0, **imu):
    """A packet of a robot's."""
    joints = [*np.full(12, angles), *np.zeros(12)]
    return link.STATE.pack(count, *joints, *(imu.get(name, 0.0) for name in link.IMU))


def test_a_tilted_robot_is_damped_from_then_on(example, law):
    link, node = example("legged_link"), example("legged_node").Node(law[1])
    on = [
        link.COMMAND.unpack(node.answer(state_of(link, k, root_roll=tilt)))[1]
        for k, tilt in enumerate((0.1, -0.8, 0.0), start=1)
    ]
    assert on == [1, 0, 0]
    assert node.stopped == "tilted"


@pytest.mark.parametrize("sense", ["angles", "root_roll"])
def test_a_robot_whose_senses_are_no_numbers_is_damped_from_then_on(example, law, sense):
    link, node = example("legged_link"), example("legged_node").Node(law[1])
    for k, value in enumerate((np.nan, 0.0), start=1):
        answer = link.COMMAND.unpack(node.answer(state_of(link, k, **{sense: value})))
        assert answer[1] == 0
        assert np.isfinite(answer).all()
    assert node.stopped == "a sense is no number"


def test_no_target_is_far_from_its_joint_so_that_torque_has_a_limit(example, law):
    link, node = example("legged_link"), example("legged_node")
    _, _, *targets = link.COMMAND.unpack(node.Node(law[1]).answer(state_of(link, 1, angles=3.0)))
    assert np.min(targets) >= 3.0 - node.APART_RAD - 1e-6


def test_no_foot_is_sent_beyond_its_reach(example, law):
    within = example("legged_law").Law(law[1])
    felt = dict.fromkeys((f"{foot}_estimated_force" for foot in FEET), 0.0)
    still = within.step(felt, 0.0)
    for _ in range(50):
        within.step(felt, 0.01)
        assert np.abs(within.outputs[:8]).max() <= 0.01 + 1e-6
    assert within.step(felt, 0.0) == pytest.approx(still)


def test_a_node_that_hears_nothing_new_and_a_robot_without_commands_are_damped(example, law):
    link, node = example("legged_link"), example("legged_node")
    deaf = node.Node(law[1])
    on = [link.COMMAND.unpack(deaf.answer(state_of(link, 1)))[1] for _ in range(node.WATCHDOG + 3)]
    assert on == [1] * (node.WATCHDOG + 1) + [0] * 2
    assert deaf.stopped == "no new state"
    alone, command = example("legged_robot").Robot(*law), link.COMMAND.pack(1, 1, *[0.0] * 12)
    assert [alone.step(command) for _ in range(node.WATCHDOG + 3)][-3:] == [True, False, False]


def test_old_commands_in_turn_and_angles_that_are_no_numbers_are_not_driven(example, law):
    link, node = example("legged_link"), example("legged_node")
    robot = example("legged_robot").Robot(*law)
    old = [link.COMMAND.pack(count, 1, *[0.0] * 12) for count in (5, 4)]
    on = [robot.step(old[k % 2]) for k in range(node.WATCHDOG + 3)]
    assert on[-3:] == [True, False, False]
    assert not robot.step(link.COMMAND.pack(6, 1, *[np.nan] * 12))
