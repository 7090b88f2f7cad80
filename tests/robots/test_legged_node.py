"""The node of a legged robot: it walks a model over a bad link, within its limits, and replays."""

import importlib
import io
import runpy
import shutil
import socket
import subprocess
import sys

import numpy as np
import pytest

from places import ROOT
from tegotae import cli

HARDWARE = ROOT / "examples" / "hardware"
ROBOT = ROOT / "src" / "tegotae_robots" / "examples" / "servo_quadruped.xml"
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
    assert not cli.main(["wiring", "transfer", f"quadruped-c@{wiring}", "--out", file])
    assert not cli.main(["export", "c", file, "--out", robot])
    return file, robot


def walked(example, law, seconds, **bad):
    """A robot and its node, a packet at a time over two ports; both, and the log."""
    link, file_folder = example("legged_link"), law
    robot, node = example("legged_robot").Robot(*file_folder), example("legged_node").Node(law[1])
    target, back, log = link.Link(1, **bad), link.Link(2, **bad), b""
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
            if state := target.passed(robot.state()):
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
    packets = [link.COMMAND.pack(1, k, 1, *[0.0] * 12) for k in range(1, 1001)]
    late = link.Link(0, late=3)
    assert [link.count_of(late.passed(x)) for x in packets] == [0, 0, 0, *range(1, 998)]
    bad = link.Link(0, jitter=4, lost=0.2)
    counts = [link.count_of(bad.passed(x)) for x in packets]
    assert counts == sorted(counts)
    assert link.count_of(link.Link(0, lost=1.0).passed(packets[0])) == 0


SESSION = 7


def state_of(link, count, angles=0.0, torques=0.0, session=SESSION, **imu):
    """A packet of a robot's."""
    joints = [*np.full(12, angles), *np.full(12, torques)]
    return link.STATE.pack(session, count, *joints, *(imu.get(name, 0.0) for name in link.IMU))


def test_a_tilted_robot_is_damped_from_then_on(example, law):
    link, node = example("legged_link"), example("legged_node").Node(law[1])
    on = [
        link.COMMAND.unpack(node.answer(state_of(link, k, root_roll=tilt)))[2]
        for k, tilt in enumerate((0.1, -0.8, 0.0), start=1)
    ]
    assert on == [1, 0, 0]
    assert node.stopped == "tilted"


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
@pytest.mark.parametrize("sense", ["angles", "torques", "root_roll", "root_pitch_rate"])
def test_a_robot_whose_senses_cannot_be_is_damped_from_then_on(example, law, sense, value):
    link, node = example("legged_link"), example("legged_node").Node(law[1])
    for k, sensed in enumerate((value, 0.0), start=1):
        answer = link.COMMAND.unpack(node.answer(state_of(link, k, **{sense: sensed})))
        assert answer[2] == 0
        assert np.abs(answer[3:]).max() < 6.3
    assert node.stopped == "a sense is no number, or out of range"


def test_an_old_state_is_answered_by_the_command_of_the_newest(example, law):
    link, node = example("legged_link"), example("legged_node")
    robots = node.Node(law[1])
    newest = robots.answer(state_of(link, 5, angles=0.1))
    assert robots.answer(state_of(link, 4, angles=1.0)) == newest
    _, count, _, *targets = link.COMMAND.unpack(newest)
    assert count == 5
    assert np.abs(np.subtract(targets, 0.1)).max() <= link.APART_RAD + 1e-6


def test_a_node_answers_one_session_and_no_count_far_ahead(example, law):
    link, node = example("legged_link"), example("legged_node").Node(law[1])
    previous = node.answer(state_of(link, 1))
    assert node.answer(state_of(link, 2, session=SESSION + 1)) == b""
    assert node.answer(state_of(link, 2**32 - 1)) == previous
    assert link.count_of(node.answer(state_of(link, 2))) == 2


def test_no_target_is_far_from_its_joint_so_that_torque_has_a_limit(example, law):
    link, node = example("legged_link"), example("legged_node")
    _, _, _, *targets = link.COMMAND.unpack(node.Node(law[1]).answer(state_of(link, 1, angles=3.0)))
    assert np.min(targets) >= 3.0 - link.APART_RAD - 1e-6


def test_no_foot_is_sent_beyond_its_reach(example, law):
    within = example("legged_law").Law(law[1])
    felt = dict.fromkeys((f"{foot}_estimated_force" for foot in FEET), 0.0)
    still = within.step(felt, 0.0)
    for _ in range(50):
        within.step(felt, 0.01)
        assert np.abs(within.outputs[:8]).max() <= 0.01 + 1e-6
    assert within.step(felt, 0.0) == pytest.approx(still)


def test_a_node_that_hears_nothing_new_is_damped(example, law):
    link, node = example("legged_link"), example("legged_node").Node(law[1])
    answers = [node.answer(state_of(link, 1)) for _ in range(link.WATCHDOG + 3)]
    on = [link.COMMAND.unpack(answer)[2] for answer in answers]
    assert on == [1] * (link.WATCHDOG + 1) + [0] * 2
    assert node.stopped == "no new state"


def command_of(link, robot, count, angle=0.0, on=1, session=None):
    """A packet for a robot."""
    session = robot.session if session is None else session
    return link.COMMAND.pack(session, count, on, *[angle] * 12)


def test_a_robot_without_a_new_command_is_damped(example, law):
    link, robot = example("legged_link"), example("legged_robot").Robot(*law)
    command = command_of(link, robot, 1)
    on = [robot.step(command) for _ in range(link.WATCHDOG + 3)]
    assert on == [True] * (link.WATCHDOG + 1) + [False] * 2


@pytest.mark.parametrize(
    "wrong",
    [
        {"count": 0},  # older than that before
        {"count": 1},  # that before
        {"count": 3},  # of a state that was not sent
        {"count": 2**32 - 1},
        {"angle": np.nan},
        {"angle": 1e30},
        {"on": 2},
        {"session": 0},
    ],
    ids=str,
)
def test_a_robot_does_not_take_a_command_that_cannot_be_its_nodes(example, law, wrong):
    link, robot = example("legged_link"), example("legged_robot").Robot(*law)
    assert robot.step(command_of(link, robot, 1))
    assert not robot.accepts(command_of(link, robot, **{"count": 2, **wrong}))
    assert not robot.accepts(command_of(link, robot, 2)[:-1])
    assert robot.accepts(command_of(link, robot, 2))
    robot.step(command_of(link, robot, **{"count": 2, **wrong}))
    assert robot.heard == 1


def test_a_command_for_a_state_of_long_ago_is_not_taken(example, law):
    link, robot = example("legged_link"), example("legged_robot").Robot(*law)
    for _ in range(link.WATCHDOG + 2):
        robot.step(b"")
    assert not robot.accepts(command_of(link, robot, 1))
    assert robot.accepts(command_of(link, robot, robot.count))


def test_no_command_moves_a_joint_further_than_its_limit(example, law):
    link, robot = example("legged_link"), example("legged_robot").Robot(*law)
    requested = []
    step = robot.env.step
    robot.env.step = lambda action: requested.append(action) or step(action)
    current = robot.seen[robot.entries[: link.JOINTS]]
    robot.step(command_of(link, robot, 1, angle=6.0))
    assert np.abs(requested[0][robot.order] - current).max() <= link.APART_RAD + 1e-6


class Port:
    """A port that hears these packets, and then nothing."""

    def __init__(self, heard, clock):
        self.heard, self.clock, self.sent = list(heard), clock, []

    def settimeout(self, timeout_s):
        self.timeout_s = timeout_s

    def send(self, packet):
        self.sent.append(packet)

    def sendto(self, packet, address):
        self.sent.append((packet, address))

    def recvfrom(self, size):
        packet, address = self.heard.pop(0)
        return packet[:size], address

    def recv(self, size):
        self.clock.sleep(0.1)
        if self.heard:
            return self.heard.pop(0)[:size]
        raise TimeoutError


def test_a_robot_is_driven_by_who_called_and_by_no_other_address(example, law, monkeypatch, clock):
    link, ports = example("legged_link"), example("legged_ports")
    robot = example("legged_robot").Robot(*law)
    ours, theirs = ("127.0.0.1", 1), ("127.0.0.1", 2)
    spoofed, original = (command_of(link, robot, 1, angle=a) for a in (0.2, 0.1))
    heard = [(b"junk", theirs), (link.CALL, ours), (spoofed, theirs), (original, ours)]
    port = Port(heard, clock)
    monkeypatch.setattr(ports.time, "monotonic", clock.perf_counter)

    def ready(ports, *_):
        clock.sleep(0.0005)
        return ports if port.heard else [], [], []

    monkeypatch.setattr(ports.select, "select", ready)
    ports.serve(port, robot, 2 * link.PERIOD_S, (0, 0, 0.0))
    assert {address for _, address in port.sent} == {ours}
    assert robot.heard == 1
    np.testing.assert_allclose(robot.angles, 0.1, rtol=1e-6)


@pytest.mark.parametrize("junk", ["other session", "another size", "repeated"])
def test_a_node_ends_where_no_new_state_comes_whatever_else_does(
    example, law, monkeypatch, clock, junk
):
    link, ports = example("legged_link"), example("legged_ports")
    packet = {
        "other session": state_of(link, 2, session=1),
        "another size": b"junk",
        "repeated": state_of(link, 1),
    }[junk]
    port = Port([state_of(link, 1), *[packet] * 1000], clock)
    monkeypatch.setattr(ports.time, "monotonic", clock.perf_counter)
    ports.drive(port, example("legged_node").Node(law[1]), io.BytesIO())
    assert len(port.heard) > 900


@pytest.mark.parametrize(
    "words", [["robot"], [".", "law.json"], [".", "--replay", "walk.log"]], ids=lambda x: x[-1]
)
def test_a_file_that_is_not_there_ends_a_walk_in_a_line(
    words, example, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["legged_walk.py", *words])
    with pytest.raises(SystemExit) as end:
        runpy.run_path(str(HARDWARE / "legged_walk.py"), run_name="__main__")
    assert end.value.code == 2
    assert f"error: there is no {words[-1]}; " in capsys.readouterr().err
