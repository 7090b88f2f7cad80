"""A live controller gives what the simulator computes, and keeps its promises when driven."""

import contextlib
import copy
import dataclasses
import pickle
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from separate_hoppers import SeparateHoppers

from refusals import refused
from tegotae import TegotaeError
from tegotae.cli import main
from tegotae.parts.bodies import Interface
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import AdaptiveHopf, Matsuoka
from tegotae.parts.terms import Reflex
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.systems.system import System
from tegotae_robots.api.robots import export_native
from tegotae_robots.c.golden import golden
from tegotae_robots.c.plan import Export, member
from tegotae_robots.live import LiveController, drive_hardware
from tegotae_robots.live.controller import read_native, write_native
from tegotae_robots.robot import compiled

SIGMA = 2.0


def vanilla() -> SavedController:
    return SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([SIGMA]), 8.0)


def live_of(saved: SavedController, max_force_n: float | None = None) -> LiveController:
    return LiveController(compiled(saved, max_force_n))


def learned(model: str) -> SavedController:
    controller = recipe(model).experiment().system.controller
    weights = np.random.default_rng(0).normal(0.0, 0.3, controller.n_weights)
    omega = None if controller.oscillator is None else 8.0
    return SavedController.from_weights(controller, weights, omega)


def with_oscillator(oscillator: object) -> SavedController:
    plain = recipe("V-reflex-w8").controller()
    controller = Controller(Reflex(), oscillator, tegotae=plain.tegotae)
    return SavedController.from_weights(controller, np.full(controller.n_weights, SIGMA), 8.0)


def walker() -> SavedController:
    return resolve("quadruped-c").controller()


CASES = {
    "vanilla": vanilla,
    "ART": lambda: learned("ART"),
    "ARGT": lambda: learned("ARGT"),
    "T": lambda: learned("T"),
    "adaptive Hopf": lambda: with_oscillator(AdaptiveHopf()),
    "Matsuoka": lambda: with_oscillator(Matsuoka()),
    "quadruped": walker,
}
QUICK = ("ARGT", "T", "adaptive Hopf", "quadruped")
"""Those that are repeated in every run of the tests."""


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.thorough) for name in CASES],
)
def test_every_tick_of_a_simulated_run_is_repeated(name):
    saved = CASES[name]()
    export = Export(saved)
    run = golden(export)
    live = live_of(saved)
    columns = list(run.columns)

    def of(prefix: str) -> np.ndarray:
        index = [i for i, item in enumerate(columns) if item.split("[")[0] == prefix]
        return run.rows[:, index]

    state = [x for x in live._step.state.dtype.names if x.startswith("oscillator")]
    names = [element.split("[")[0] for element in columns if element.startswith("state.")]
    previous = [of(element) for element in dict.fromkeys(names)]
    updated = [of(element.replace("state.", "next.")) for element in dict.fromkeys(names)]
    paths = [np.atleast_2d(of(f"out.{member(element)}").T).T for element in live.commands]
    for tick in range(0, len(run.rows), 10):
        live.reset()
        for entry, values in zip(state, previous, strict=True):
            live._step.state[entry][...] = values[tick].reshape(live._step.state[entry].shape)
        senses = {element: of(f"in.{member(element)}")[tick] for element in live.senses}
        command = np.reshape(live.step(senses, 0.001), (len(live.commands), -1))
        for got, expected in zip(command, paths, strict=True):
            np.testing.assert_allclose(got, expected[tick], rtol=1e-5, atol=1e-5)
        feedback = of("out.feedback_rad_per_s")[tick]
        np.testing.assert_allclose(live.feedback_rad_per_s, feedback, rtol=1e-5, atol=1e-4)
        live.step(senses, 0.001)
        for entry, values in zip(state, updated, strict=True):
            current = live._step.state[entry].reshape(-1)
            off = np.abs(
                np.angle(np.exp(1j * (current - values[tick])))
            )  # a phase may have wrapped
            assert (off < 1e-5).all(), entry


def test_a_unit_feels_and_drives_the_limb_that_its_wiring_names():
    """The wiring is not its own inverse."""
    wiring, gains, forces = (1, 2, 0), (1.0, 2.0, 3.0), (0.5, 1.0, 2.0)
    single = recipe("V-reflex-w8").controller()
    three = dataclasses.replace(single, limbs=3, sharing=(0, 1, 2), wiring=wiring)
    body = SeparateHoppers(hoppers=3)
    together = live_of(SavedController.from_weights(three, np.array(gains), 8.0, body))
    of_units = [live_of(SavedController.from_weights(single, np.array([x]), 8.0)) for x in gains]
    for _ in range(3):
        commands = together.step({"spring_force": forces}, 0.05)
        for live, limb in zip(of_units, wiring, strict=True):
            alone = live.step({"spring_force": forces[limb]}, 0.05)
            assert commands[limb] == pytest.approx(alone[0], rel=1e-5)
            assert together.phase_rad[limb] == pytest.approx(live.phase_rad[0], rel=1e-5)
            assert together.feedback_rad_per_s[limb] == pytest.approx(
                live.feedback_rad_per_s[0], rel=1e-5
            )


def test_the_frequency_can_be_set_between_steps():
    live = live_of(vanilla())
    live.step({"spring_force": 0.0}, 0.1)
    live.omega_rad_per_s = 3.0
    live.step({"spring_force": 0.0}, 0.1)  # the step before was at 8 rad/s
    live.step({"spring_force": 0.0}, 0.1)
    assert live.phase_rad == pytest.approx([0.8 + 0.3], abs=1e-5)


def test_a_reset_begins_anew_or_at_a_phase():
    live = live_of(vanilla())
    first = [float(live.step({"spring_force": 9.0 * i}, 0.01)[0]) for i in range(5)]
    live.reset()
    assert [float(live.step({"spring_force": 9.0 * i}, 0.01)[0]) for i in range(5)] == first
    live.reset(phase_rad=2.0)
    live.step({"spring_force": 0.0}, 0.01)
    assert live.phase_rad == pytest.approx([2.0])


def undisturbed(steps: int) -> np.ndarray:
    """Phases after so many steps of 10 ms at a force of 1 N."""
    live = live_of(vanilla())
    for _ in range(steps):
        live.step({"spring_force": 1.0}, 0.01)
    return live.phase_rad


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda live: pickle.loads(pickle.dumps(live))]
)
@pytest.mark.parametrize("name", ["vanilla", "quadruped"])
def test_a_copy_goes_on_by_itself_from_where_the_controller_is(name, copied):
    live = live_of(CASES[name]())
    live.omega_rad_per_s = 3.0
    for force in (1.0, 5.0):
        live.step({"spring_force": force}, 0.01)
    second = copied(live)
    assert (second.steps, second.omega_rad_per_s) == (2, 3.0)
    expected = live.step({"spring_force": 9.0}, 0.01).copy()
    live.reset()
    np.testing.assert_array_equal(second.step({"spring_force": 9.0}, 0.01), expected)


def test_what_cannot_be_stepped_is_refused_and_changes_nothing():
    live = live_of(vanilla())
    live.step({"spring_force": 1.0}, 0.01)
    live.step({"spring_force": 1.0}, 0.01)
    previous = live.phase_rad
    for measured, dt_s, reason in (
        ({"force": 1.0}, 0.01, "lack 'spring_force'.* was given force"),
        ({"spring_force": np.nan}, 0.01, "spring_force is nan at step 2"),
        ({"spring_force": np.ones(3)}, 0.01, r"is array\(.*it must be a finite number or one for"),
        ({"spring_force": "strong"}, 0.01, "is 'strong' at step 2; it must be a finite number"),
        ({"spring_force": None}, 0.01, "spring_force is None at step 2"),
        ({"spring_force": 1e39}, 0.01, r"spring_force is 1e\+39 at step 2"),
        ({"spring_force": 10**400}, 0.01, "spring_force is 1000.*0 at step 2"),
        ({"spring_force": 3e38}, 0.01, "gives numbers that are not finite.* are too large"),
        (3.0, 0.01, "the measurements are 3.0; they must be numbers by name"),
        ({"spring_force": 1.0}, -0.01, "dt_s is -0.01"),
        ({"spring_force": 1.0}, np.nan, "dt_s is nan; it must be finite"),
        ({"spring_force": 1.0}, 1e38, r"dt_s is 1e\+38; it must be at most 3600"),
        ({"spring_force": 1.0}, 10**400, "dt_s is .*too large"),
        ({"spring_force": 1.0}, "soon", "dt_s is 'soon'; it must be a number"),
        ({"spring_force": 1.0}, [0.01, 0.02], r"dt_s is \[0.01, 0.02\]; it must be a number"),
    ):
        refused(reason, live.step, measured, dt_s)
    for phase in ([1.0, 2.0], "late", 1e39, 10**400, np.nan):
        refused("phase_rad is", live.reset, phase_rad=phase)
    for omega, reason in (
        (None, "has an oscillator"),
        (1e39, "at most 1000"),
        (10**400, "too large"),
        (np.nan, "must be finite"),
        ("fast", "must be a number"),
    ):
        with pytest.raises(TegotaeError, match=reason):
            live.omega_rad_per_s = omega
    assert live.steps == 2
    assert (live.phase_rad == previous).all()
    live.step({"spring_force": 1.0}, 0.01)
    assert live.phase_rad == pytest.approx(undisturbed(3), abs=0.0)


def test_the_phase_follows_the_clock_and_the_time_of_a_refused_step_is_not_lost():
    seconds = iter((5.0, 5.25, 5.5, 5.75))
    live = LiveController(compiled(vanilla()), clock=lambda: next(seconds))
    for force in (0.0, np.nan, 0.0, 0.0):
        if np.isnan(force):
            refused("is nan", live.step, {"spring_force": force})
        else:
            live.step({"spring_force": force})
    assert live.phase_rad == pytest.approx([6.0], abs=1e-5)  # 8 rad/s for 0.75 s


def test_an_interface_without_a_largest_force_is_asked_for_one():
    system = System(controller=recipe("V-reflex-w8").controller(), body=Interface(), omega=8.0)
    saved = SavedController(system, np.array([SIGMA]))
    refused("give max_force_n", live_of, saved)
    live = live_of(saved, max_force_n=4.0)
    force = float(live.step({"spring_force": 1e3}, 0.01)[0])
    assert 0.0 <= force <= 4.0


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    path = tmp_path_factory.mktemp("live") / "leg.native"
    write_native(compiled(vanilla()), path)
    return path


def test_a_small_process_loads_and_steps_without_jax(exported):
    program = (
        "import sys\n"
        "from tegotae_robots.live import LiveController\n"
        f"live = LiveController.load({str(exported)!r})\n"
        "print(*(float(live.step({'spring_force': 9.0 * i}, 0.01)[0]) for i in range(5)))\n"
        "assert 'jax' not in sys.modules and 'pandas' not in sys.modules\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, process.stderr
    live = live_of(vanilla())
    current = [float(live.step({"spring_force": 9.0 * i}, 0.01)[0]) for i in range(5)]
    assert [float(x) for x in process.stdout.split()] == current


def test_the_command_writes_what_load_reads(tmp_path, capsys):
    path = tmp_path / "walker.native"
    assert main(["export", "native", "quadruped-c", "--out", str(path)]) == 0
    assert "commands foot_x, foot_z" in capsys.readouterr().out
    live = LiveController.load(path)
    assert live.step({"spring_force": np.ones(4)}, 0.01).shape == (2, 4)
    again = export_native("quadruped-c").live()
    assert again.step({"spring_force": np.ones(4)}, 0.01).shape == (2, 4)


def test_no_byte_of_a_file_can_be_lost_or_altered_unnoticed(exported, tmp_path):
    content, path = exported.read_bytes(), tmp_path / "leg.native"
    assert read_native(exported).code == compiled(vanilla()).code
    for place in (0, *range(3, len(content), 97), len(content) - 1):
        altered = bytes([content[place] ^ 0xFF])
        for damaged in (content[:place], content[:place] + altered + content[place + 1 :]):
            path.write_bytes(damaged)
            refused(r"leg\.native.* (truncated|damaged)", LiveController.load, path)


def test_a_file_of_another_version_is_refused(exported, tmp_path):
    path = tmp_path / "leg.native"
    path.write_bytes(exported.read_bytes().replace(b"controller 3", b"controller 2"))
    refused("of another version", LiveController.load, path)


def leg() -> tuple:
    """A pretended leg: what is read, and what was written."""
    written: list[float] = []

    def read() -> dict[str, float]:
        return {"spring_force": 3.0, "height_m": 1.0 + 0.001 * len(written)}

    return read, lambda command: written.append(float(command[0])), written


def columns_of(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as recorded:
        return dict(recorded)


def driven(live, read, write, **options):
    """A loop for a minute, with -1 N as its safe command."""
    options = {"duration_s": 60.0, "safe": -1.0, "watchdog_s": 30.0, **options}
    return drive_hardware(live, read, write, **options)


def test_a_loop_records_what_measure_reads_and_ends_safe(tmp_path, exported, clock):
    read, write, written = leg()
    path = tmp_path / "run.npz"
    live = LiveController.load(exported)
    report = driven(live, read, write, rate_hz=500.0, duration_s=0.2, recording=path)
    assert report.stopped == "duration"
    assert report.ticks == 100
    assert len(report.late_s) == report.ticks
    assert written[-1] == -1.0
    columns = columns_of(path)
    assert {"time_s", "height_m", "spring_force", "phase_rad", "force_n"} <= set(columns)
    assert columns["force_n"].tolist() == pytest.approx(written[:-1])
    assert (np.diff(columns["time_s"]) > 0.0).all()
    assert "99.9 %" in str(report)


def test_a_period_that_is_missed_is_left_out(exported, clock, tmp_path):
    _, write, written = leg()

    def read() -> dict[str, float]:
        clock.sleep(0.0105 if len(written) == 3 else 0.0)
        return {"spring_force": 0.0}

    live = LiveController.load(exported)
    path = tmp_path / "run.npz"
    report = driven(live, read, write, rate_hz=500.0, duration_s=0.2, recording=path)
    assert report.ticks == 95
    assert report.late_s.max() < 0.0005
    columns = columns_of(path)
    turned = np.unwrap(columns["phase_rad"]) - columns["phase_rad"][0]
    passed_s = columns["time_s"] - columns["time_s"][0]
    np.testing.assert_allclose(turned, 8.0 * passed_s, atol=1e-4)  # the time that really passed


def test_the_watchdog_writes_the_safe_command_while_a_read_hangs(exported, clock):
    _, write, written = leg()
    hangs = threading.Event()

    def read() -> dict[str, float]:
        if len(written) == 3:
            clock.sleep(1.0)
            assert hangs.wait(900.0), "the watchdog did not write"
        return {"spring_force": 3.0}

    def watched(command: np.ndarray) -> None:
        write(command)
        if written[-1] == -1.0:
            hangs.set()

    live = LiveController.load(exported)
    report = driven(live, read, watched, watchdog_s=0.3)
    assert report.stopped == "watchdog"
    assert report.ticks == 3
    assert written[3:] == [-1.0, -1.0]


def test_an_error_of_the_hardware_ends_safe_and_keeps_the_recording(tmp_path, exported, clock):
    read, write, written = leg()

    def failing() -> dict[str, float]:
        if len(written) == 5:
            raise OSError("the cable is out")
        return read()

    path = tmp_path / "run.npz"
    live = LiveController.load(exported)
    with pytest.raises(OSError, match="cable"):
        driven(live, failing, write, recording=path)
    assert written[-1] == -1.0
    assert len(columns_of(path)["time_s"]) == 5


@pytest.mark.parametrize("caught", [(), (KeyboardInterrupt,)], ids=["raised", "caught"])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_ends_safe_and_no_further_one_interrupts_that(
    name, caught, tmp_path, exported, clock
):
    number = getattr(signal, name)
    _, _, written = leg()
    default: list[int] = []

    def read() -> dict[str, float]:
        if len(written) == 5:
            with contextlib.suppress(*caught):
                signal.raise_signal(number)
        return {"spring_force": 3.0}

    def write(command: np.ndarray) -> None:
        if command[0] == -1.0:
            for further in (number, signal.SIGINT, signal.SIGTERM):
                signal.raise_signal(further)
        written.append(float(command[0]))

    previous = {entry: signal.getsignal(entry) for entry in (signal.SIGTERM, signal.SIGHUP)}
    for entry in previous:
        signal.signal(entry, lambda came, _: default.append(came))
    path = tmp_path / "run.npz"
    try:
        report = driven(LiveController.load(exported), read, write, recording=path)
    finally:
        for entry, handler in previous.items():
            signal.signal(entry, handler)
    assert report.stopped == "interrupted"
    assert report.ticks == 5
    assert written[5:] == [-1.0]
    assert len(columns_of(path)["time_s"]) == 5
    assert default == list(dict.fromkeys(x for x in (number, signal.SIGTERM) if x != signal.SIGINT))
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_process_that_is_asked_to_end_does_so_after_the_safe_command(tmp_path, exported):
    program = (
        "import signal\n"
        "from tegotae_robots.live import LiveController, drive_hardware\n"
        "written = []\n"
        "def read():\n"
        "    if len(written) == 3: signal.raise_signal(signal.SIGTERM)\n"
        "    return {'spring_force': 3.0}\n"
        "def write(command):\n"
        "    written.append(float(command[0]))\n"
        "    print(written[-1], flush=True)\n"
        f"drive_hardware(LiveController.load({str(exported)!r}), read, write, duration_s=60.0,\n"
        "    safe=-1.0, watchdog_s=60.0, recording='run.npz')\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert process.returncode == -signal.SIGTERM, process.stderr
    assert [float(x) for x in process.stdout.split()][3:] == [-1.0]
    assert len(columns_of(tmp_path / "run.npz")["time_s"]) == 3


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"rate_hz": 0.0}, "rate_hz is 0"),
        ({"watchdog_s": 0.0001}, "watchdog_s is 0.0001"),
        ({"recording": "run.csv"}, "must end in .npz"),
        ({"recording": f"{__file__}/run.npz"}, "cannot write to the folder"),
        ({"recording": "folder.npz"}, "it is a folder"),
        ({"recording": "kept.npz"}, "choose another name"),
        ({"safe": [0.0, 1.0]}, r"safe is \[0.0, 1.0\]; it must be a finite number"),
        ({"safe": np.nan}, "safe is nan"),
        ({"safe": "off"}, "safe is 'off'"),
        ({"safe": 1e39}, r"safe is 1e\+39"),
        ({"safe": 10**400}, "safe is 1000"),
        ({"safe": None}, "safe is None"),
        ({"rate_hz": 1e5, "duration_s": 86400.0}, "would need about .* of memory"),
    ],
)
def test_a_loop_that_cannot_be_is_refused_before_it_reads_or_moves_anything(
    options, reason, exported, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    Path("folder.npz").mkdir()
    Path("kept.npz").touch()
    _, write, written = leg()
    with pytest.raises(TegotaeError, match=reason):
        driven(LiveController.load(exported), lambda: pytest.fail("it was read"), write, **options)
    assert not written


@pytest.mark.parametrize(
    ("measured", "reason"),
    [
        (3.0, "read gave 3.0; it must give measurements by name, such as {'spring_force': 0.0}"),
        (None, "read gave None"),
        ({}, "the measurements lack 'spring_force'"),
        ({"spring_force": "off"}, "'off' for 'spring_force'; it must be a number"),
        ({"spring_force": [1.0, 2.0]}, "must be a number or one for each of 1 limbs"),
        ({"spring_force": 10**400}, "for 'spring_force'; it must be a number"),
        ({"spring_force": 3.0, "height_m": {}}, "{} for 'height_m'; it must be a number"),
        ({"spring_force": 3.0, "height_m": np.ones((2, 2))}, "for 'height_m'; it must be a number"),
        ({"spring_force": 3.0, "time_s": 0.0}, "named 'time_s'; .* time_s"),
        ({"spring_force": 3.0, "force_n": 0.0}, "named 'force_n'"),
        ({"spring_force": 3.0, 7: 0.0}, "named 7; it must be a printable text"),
        ({"spring_force": 3.0, "a\0b": 0.0}, "it must be a printable text"),
        ({"spring_force": 3.0, "\ud800": 0.0}, "it must be a printable text"),
        ({"spring_force": 3.0, "": 0.0}, "named ''; it must be a printable text"),
        ({"spring_force": 3.0, 70000 * "x": 0.0}, "of at most 100 characters"),
    ],
)
def test_what_is_no_measurement_is_refused_before_the_first_command(measured, reason, exported):
    _, write, written = leg()
    live = LiveController.load(exported)
    refused(reason, driven, live, lambda: measured, write)
    assert written == [-1.0]


def test_two_measurements_never_share_a_column(tmp_path, clock):
    live = live_of(walker())
    path = tmp_path / "run.npz"

    def measuring(**extra: object) -> None:
        measured = {"spring_force": np.arange(4.0), "height_m": 0.3, **extra}
        times = {"rate_hz": 500.0, "duration_s": 0.02}
        driven(live, lambda: measured, lambda command: None, recording=path, **times)

    for name in ("spring_force_0", "phase_rad_3", "foot_x"):
        refused(f"named '{name}'", measuring, **{name: 1.0})
    measuring(temperature=20.0, file=1.0, allow_pickle=2.0)
    columns = columns_of(path)
    assert {"spring_force_0", "phase_rad_3", "foot_z_2", "temperature", "time_s"} <= set(columns)
    assert (columns["file"] == 1.0).all()
    assert (columns["allow_pickle"] == 2.0).all()
    assert (columns["spring_force_3"] == 3.0).all()


def test_a_measurement_that_changes_its_shape_ends_safe_and_keeps_the_recording(
    tmp_path, exported, clock
):
    read, write, written = leg()
    path = tmp_path / "run.npz"

    def changing() -> dict[str, object]:
        return read() | ({"height_m": [1.0, 2.0]} if len(written) == 3 else {})

    with pytest.raises(TegotaeError, match="for 'height_m' at step 3, and a number before"):
        driven(LiveController.load(exported), changing, write, recording=path)
    assert written[-1] == -1.0
    assert len(columns_of(path)["time_s"]) == 3


def test_steps_do_not_grow_memory():
    live = live_of(learned("ART"))
    import tracemalloc

    measured = {"spring_force": 3.0}
    for _ in range(100):
        live.step(measured, 0.001)
    tracemalloc.start()
    previous = tracemalloc.get_traced_memory()[0]
    for _ in range(5000):
        live.step(measured, 0.001)
    grown = tracemalloc.get_traced_memory()[0] - previous
    tracemalloc.stop()
    assert grown < 4096
