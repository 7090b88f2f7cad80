"""The examples of robots: a serial leg whose packets survive a bad cable, and a node of ROS 2."""

import array
import importlib
import runpy
import struct
import subprocess
import sys
import types
from unittest import mock

import matplotlib
import numpy as np
import pytest

from clocks import Clock
from places import ROOT
from tegotae import TegotaeError, cli
from tegotae_robots.live import LiveController, drive_hardware

HARDWARE = ROOT / "examples" / "hardware"


@pytest.fixture
def example(monkeypatch):
    """Imports a file of the examples."""
    monkeypatch.syspath_prepend(HARDWARE)
    for path in HARDWARE.glob("*.py"):
        monkeypatch.delitem(sys.modules, path.stem, raising=False)
    return importlib.import_module


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    path = tmp_path_factory.mktemp("hardware") / "leg.native"
    assert cli.main(["export", "native", "V-reflex-w8", "--out", str(path)]) == 0
    return path


class Cable:
    """A port that is the leg itself, with the time of a clock."""

    def __init__(self, leg, clock) -> None:
        self.leg, self.clock, self.waiting = leg, clock, b""

    def write(self, data: bytes) -> None:
        self.waiting += self.leg.answer(data, self.clock.now_s)

    def read(self, size: int) -> bytes:
        data, self.waiting = self.waiting[:size], self.waiting[size:]
        return data

    def close(self) -> None:
        pass


def test_packets_are_found_in_pieces_and_among_others(example):
    serial_leg = example("serial_leg")
    packets = serial_leg.Packets("<ff")
    stream = b"\x00\xa5" + serial_leg.packet("<ff", 1.5, -2.0) + serial_leg.packet("<ff", 3.0, 0.25)
    result = [numbers for i in range(len(stream)) for numbers in packets.feed(stream[i : i + 1])]
    assert result == [(1.5, -2.0), (3.0, 0.25)]
    assert packets.damaged == 0


def test_every_damaged_bit_of_a_packet_is_noticed_and_the_next_packet_is_read(example):
    serial_leg = example("serial_leg")
    good = serial_leg.packet("<ff", 1.5, -2.0)
    for bit in range(8 * len(good)):
        bad = bytearray(good)
        bad[bit // 8] ^= 1 << bit % 8
        packets = serial_leg.Packets("<ff")
        assert packets.feed(bytes(bad) + 2 * good)[-1] == (1.5, -2.0)
        assert len(packets.feed(good)) == 1


def test_a_mark_within_the_numbers_does_no_harm(example):
    serial_leg = example("serial_leg")
    (number,) = struct.unpack("<f", b"\x00" + serial_leg.MARK + b"\x00")
    packets = serial_leg.Packets("<ff")
    assert packets.feed(5 * serial_leg.packet("<ff", number, number)) == 5 * [(number, number)]


@pytest.mark.parametrize("junk", [b"\x00", b"\xa5", b"\xa5\x5a", b"\xa5\x5a\xa5"])
def test_the_buffer_stays_shorter_than_a_packet_and_the_next_packet_is_read(example, junk):
    serial_leg = example("serial_leg")
    packets = serial_leg.Packets("<ff")
    for _ in range(200):
        packets.feed(junk)
        assert len(packets.buffer) < packets.size
    assert packets.feed(2 * serial_leg.packet("<ff", 1.5, -2.0))[-1] == (1.5, -2.0)


def test_a_leg_that_sends_junk_for_ever_does_not_answer(example, monkeypatch, clock):
    serial_leg = example("serial_leg")
    monkeypatch.setattr(serial_leg.time, "monotonic", clock.perf_counter)
    port = mock.MagicMock()
    port.read.side_effect = lambda size: clock.sleep(0.01) or bytes(size)
    with pytest.raises(TimeoutError, match="does not answer"):
        serial_leg.SerialLeg(port).read()
    assert clock.perf_counter() == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("number", [np.nan, np.inf, 1e30])
@pytest.mark.parametrize("layout", ["<ff", "<Bf"])
def test_a_packet_with_a_number_that_cannot_be_counts_as_damaged(example, layout, number):
    serial_leg = example("serial_leg")
    packets = serial_leg.Packets(layout)
    good = serial_leg.packet(layout, 1, 1.0)
    assert packets.feed(serial_leg.packet(layout, 1, number) + good) == [(1, 1.0)]
    assert packets.damaged >= 1


def test_a_controller_makes_the_leg_hop_through_its_packets(example, exported):
    simulated = example("simulated_leg")
    clock = Clock()
    leg = example("serial_leg").SerialLeg(Cable(simulated.Leg(0.0), clock))
    live = LiveController.load(exported)
    heights = []
    for tick in range(2000):
        clock.now_s = 0.004 * tick
        measured = leg.read()
        heights.append(measured["height_m"])
        leg.write(live.step(measured, 0.004))
    assert max(heights[1500:]) > 1.1
    assert min(heights) > 0.3


def test_the_example_of_a_loop_at_500_hz_makes_the_leg_hop(example, clock, tmp_path, monkeypatch):
    """Its leg and its loop keep the time of one clock; the check is the example's own."""
    simulated, port = example("simulated_leg"), example("port")
    monkeypatch.setattr(port, "Serial", lambda *_, **__: Cable(simulated.Leg(clock.now_s), clock))
    monkeypatch.setattr(subprocess, "Popen", mock.MagicMock())
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    with matplotlib.rc_context({"savefig.dpi": 100}):
        runpy.run_path(str(HARDWARE.parent / "live.py"))
    assert len(np.load(tmp_path / "run.npz")["time_s"]) == 2000
    assert (tmp_path / "live.png").stat().st_size > 5000


def test_the_example_refuses_a_recording_that_exists_before_anything_starts(tmp_path, monkeypatch):
    (tmp_path / "run.npz").touch()
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: pytest.fail("the leg was started"))
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(TegotaeError, match=r"run\.npz exists; choose another name"):
        runpy.run_path(str(HARDWARE.parent / "live.py"))


def test_the_simulated_leg_answers_behind_a_port(example):
    started = [sys.executable, str(HARDWARE / "simulated_leg.py")]
    with subprocess.Popen(started, stdout=subprocess.PIPE, text=True) as process:
        try:
            port = example("port").Serial(process.stdout.readline().strip(), timeout=900.0)
            leg = example("serial_leg").SerialLeg(port, deadline_s=900.0)
            leg.write([1.0])
            assert 0.0 < leg.read()["height_m"] < 1.3
            assert leg.read().keys() == {"spring_force", "height_m"}
            assert leg.packets.damaged == 0
            port.close()
        finally:
            process.kill()


def test_without_commands_the_firmware_gives_no_force(example):
    simulated, serial_leg = example("simulated_leg"), example("serial_leg")
    leg = simulated.Leg(0.0)
    assert leg.answer(serial_leg.packet("<Bf", 1, 9.0), 0.01) == b""
    assert leg.force_n == 4.0  # its actuator has no more
    leg.answer(b"", 0.4)
    assert leg.force_n == 4.0
    leg.answer(b"", 0.6)
    assert leg.force_n == 0.0


def test_a_leg_that_does_not_answer_ends_the_loop_with_the_safe_command(example, exported):
    sent = []

    class Silent:
        def write(self, data: bytes) -> None:
            sent.append(data)

        def read(self, size: int) -> bytes:
            return b""

    serial_leg = example("serial_leg")
    leg = serial_leg.SerialLeg(Silent())
    live = LiveController.load(exported)
    with pytest.raises(TimeoutError, match="does not answer"):
        drive_hardware(live, leg.read, leg.write, duration_s=60.0, safe=0.0, watchdog_s=30.0)
    assert sent[-1] == serial_leg.packet("<Bf", 1, 0.0)


class Node:
    """Node of rclpy with a clock of its own."""

    def __init__(self, name: str) -> None:
        self.name, self.published, self.now_ns = name, [], 0

    def declare_parameter(self, name, default):
        return types.SimpleNamespace(value=Node.parameters.get(name, default))

    def get_clock(self):
        return types.SimpleNamespace(now=lambda: types.SimpleNamespace(nanoseconds=self.now_ns))

    def create_publisher(self, kind, topic, depth):
        return types.SimpleNamespace(publish=lambda message: self.published.append(message.data))

    def create_subscription(self, kind, topic, callback, depth):
        self.receive = callback


@pytest.mark.parametrize(("controller", "limbs"), [("V-reflex-w8", 1), ("quadruped-c", 4)])
def test_the_node_of_ros_2_steps_the_controller_for_each_message(
    example, monkeypatch, tmp_path, controller, limbs
):
    path = tmp_path / "leg.native"
    assert cli.main(["export", "native", controller, "--out", str(path)]) == 0
    nodes: list[Node] = []
    rclpy = types.ModuleType("rclpy")
    rclpy.__dict__.update(init=lambda: None, spin=nodes.append)
    messages = types.ModuleType("std_msgs.msg")
    messages.__dict__["Float32MultiArray"] = types.SimpleNamespace
    for name, module in {
        "rclpy": rclpy,
        "rclpy.node": types.SimpleNamespace(Node=Node),
        "std_msgs": types.ModuleType("std_msgs"),
        "std_msgs.msg": messages,
    }.items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(Node, "parameters", {"controller": str(path)}, raising=False)
    example("ros2_node").main()
    (node,) = nodes
    live = LiveController.load(path)
    for tick in range(5):
        node.now_ns = 10_000_000 * tick
        forces = array.array("f", [0.3 * tick] * limbs)  # as rclpy hands them over
        node.receive(types.SimpleNamespace(data=forces))
        expected = live.step({"spring_force": np.asarray(forces)}, 0.01)
        assert node.published[-1] == pytest.approx(expected.ravel().tolist(), abs=1e-6)
