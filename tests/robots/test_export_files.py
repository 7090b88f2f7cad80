"""An export on disk: complete, checked by its own program, or refused before it is written."""

import dataclasses
import hashlib
import json
import re
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from springs import Hertz

import tegotae as tg
from compiled import FLAGS, SANITIZERS, Compiled, needs_gcc
from refusals import refused
from tegotae import Hopper, Timing, cli
from tegotae.parts.bodies import Bar
from tegotae.parts.fields import replace
from tegotae.parts.terms import Signals, Term
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae_robots.c import Export, package_texts
from tegotae_robots.c.cost import COMPILER, EMULATOR
from tegotae_robots.c.source import source

needs_cpp = pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
CODE = {"leg.json", "README.md"}
SKETCH = "examples/control_loop/control_loop.ino"
FILES = {
    "flat": CODE | {"leg.h", "leg.c", "test_leg.c", "golden.csv", "CMakeLists.txt"},
    "platformio": CODE
    | {"include/leg.h", "src/leg.c", "test/test_leg.c", "test/golden.csv", "library.json", SKETCH},
    "arduino": CODE
    | {"src/leg.h", "src/leg.c", "extras/test_leg.c", "extras/golden.csv", SKETCH}
    | {"library.properties"},
}


def saved(name: str = "ART-rF-tphif-w8", **entries) -> SavedController:
    """A controller with random weights."""
    model = recipe(name)
    controller = model.controller(30)
    weights = np.asarray(controller.initial(jax.random.key(1)))
    return SavedController.from_weights(controller, weights, model.omega_t, name=name, **entries)


def trained(tick_s: float, name: str = "ART-rF-tphif-w8") -> SavedController:
    """A controller that was trained at this control period."""
    timing = Timing(duration_s=24.0, tick_s=tick_s)
    experiment = recipe(name).experiment(budget=30, timing=timing)
    return dataclasses.replace(saved(name), system=experiment.system, experiment=experiment)


def with_action(term: Term) -> SavedController:
    """The vanilla controller with another action."""
    controller = recipe("V-reflex-w8").controller()
    law = dataclasses.replace(controller.tegotae, action=term)
    return SavedController.from_weights(
        dataclasses.replace(controller, tegotae=law), np.array([2.0]), 8.0, Hopper()
    )


def said_by(*command, **where) -> subprocess.CompletedProcess:
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, **where)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The folder of an export made by the command, and its controller."""
    folder = tmp_path_factory.mktemp("export")
    path, out = folder / "controller.json", folder / "out"
    single = trained(0.002)
    controller_file.save(single, path)
    arguments = ["export", "c", str(path), "--out", str(out), "--prefix", "leg"]
    assert cli.main(arguments) == 0
    return out, single


def test_the_manifest_tells_inputs_outputs_units_scales_and_what_happens_in_flight(written):
    out, single = written
    manifest = json.loads((out / "leg.json").read_text())
    (force,) = manifest["inputs"]
    assert (force["name"], force["unit"]) == ("spring_force_n", "N")
    assert force["scale"] == pytest.approx(0.981)
    assert manifest["outputs"][0] == {"name": "force_n", "range": [0.0, 4.0]}
    assert (manifest["tick_s"], manifest["trained_tick_s"]) == (0.001, 0.002)
    assert "air" in manifest["flight"]
    assert set(manifest["files"]) == FILES["flat"] == {path.name for path in out.iterdir()}
    weights = np.asarray(single.weights, "<f8").tobytes()
    assert manifest["weights_sha256"] == hashlib.sha256(weights).hexdigest()
    assert f'LEG_WEIGHTS_SHA256 "{manifest["weights_sha256"]}"' in (out / "leg.h").read_text()
    neuron = manifest["weights"]["reaction"]["neuron"][0]
    first = single.controller.layout["reaction"].start
    assert neuron["spring_force"] == pytest.approx(float(single.weights[first]))


def test_the_source_has_all_weights_by_name_no_double_no_memory_and_no_library_but_maths(written):
    out, single = written
    text = (out / "leg.c").read_text()
    for name in (".spring_force = ", ".sin_phase = ", ".bias = ", ".sigma = "):
        assert name in text
    for weight in np.asarray(single.weights, np.float32):
        assert f"{weight!s}f" in text
    included = {line for line in text.splitlines() if line.startswith("#include")}
    assert included == {'#include "leg.h"', "#include <float.h>", "#include <math.h>"}
    for word in ("double", "malloc", "printf", "goto", "@"):
        assert word not in text
    static = [line for line in text.splitlines() if line.startswith("static") and "(" not in line]
    assert all(line.startswith("static const") for line in static)


@needs_gcc
def test_the_golden_vectors_pass_under_sanitizers_and_find_another_controller(written, tmp_path):
    out, single = written
    program = tmp_path / "test_leg"
    command = ["gcc", *FLAGS, *SANITIZERS, "-O1", "leg.c", "test_leg.c", "-lm", "-o", program]
    subprocess.run(command, cwd=out, check=True)
    process = said_by(program)
    assert process.returncode == 0, process.stdout + process.stderr
    assert "1000 golden vectors" in process.stdout
    assert "bounded" in process.stdout
    for name in ("leg.h", "test_leg.c"):
        shutil.copy(out / name, tmp_path)
    second = dataclasses.replace(single, weights=np.asarray(single.weights) * 1.001)
    (tmp_path / "leg.c").write_text(source(Export(second, prefix="leg")))
    command = ["gcc", "-std=c99", "leg.c", "test_leg.c", "-lm", "-o", "test_leg"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert said_by(program).returncode == 1


@needs_cpp
def test_a_program_in_cpp_calls_it(written, tmp_path):
    out, _ = written
    sketch = tmp_path / "sketch.cpp"
    sketch.write_text(
        '#include "leg.h"\nint main() { leg_state s; leg_inputs in = {}; leg_outputs out;\n'
        "leg_init(&s, 1.0f); leg_step(&s, &in, &out); return out.fault ? 1 : 0; }\n"
    )
    subprocess.run(["gcc", "-c", out / "leg.c", "-o", tmp_path / "leg.o"], check=True)
    program = tmp_path / "sketch"
    flags = ("-Wall", "-Wextra", "-Werror", f"-I{out}")
    command = ["g++", *flags, sketch, tmp_path / "leg.o", "-lm", "-o", program]
    subprocess.run(command, check=True)
    assert subprocess.run([program]).returncode == 0


@needs_gcc
@pytest.mark.parametrize("limbs", [1, 2])
def test_a_start_keeps_any_finite_phase_and_counts_any_other_as_a_fault(tmp_path, limbs):
    single = saved("V-reflex-w8")
    body = Hopper() if limbs == 1 else Bar()
    single = replace(
        single, {"controller": dataclasses.replace(single.controller, limbs=limbs), "body": body}
    )
    leg = Compiled(Export(single), tmp_path)
    for phase in np.float32([0.0, 1.0, -1.0, 6.2831853, 100.0, -12345.678, 1e6, -3e37, 3.4e38]):
        leg.init(phase if limbs == 1 else [phase] * limbs)
        phases = leg.oscillators[:, 0]
        assert ((phases >= 0.0) & (phases < 2.0 * np.pi)).all()
        if abs(phase) < 1e7:
            difference = np.angle(np.exp(1j * (phases.astype(float) - float(phase))))
            np.testing.assert_allclose(difference, 0.0, atol=1e-6)
        assert leg.faults == 0
    for phase in (np.nan, np.inf, -np.inf):
        leg.init(phase if limbs == 1 else [0.5] * (limbs - 1) + [phase])
        assert leg.oscillators[-1, 0] == 0.0
        assert leg.faults == 1


@needs_gcc
@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not installed")
def test_cmake_builds_the_library_and_runs_the_check(written, tmp_path):
    out, _ = written
    for command in (
        ["cmake", "-S", out, "-B", tmp_path],
        ["cmake", "--build", tmp_path],
        ["ctest", "--test-dir", tmp_path],
    ):
        subprocess.run(command, check=True, capture_output=True)


ARDUINO = "#pragma once\n#include <stdint.h>\nuint32_t micros();\n"
BOARD = """\
#include <stdio.h>
#include <Arduino.h>
static uint32_t now_us = 4294960000u;  // soon begins at zero again
uint32_t micros() { return now_us += 100; }
extern "C" int steps;
void setup();
void loop();
int main() { setup(); for (int i = 0; i < 1000; ++i) loop(); printf("%d", steps); return 0; }
"""


@needs_cpp
@pytest.mark.parametrize("layout", ["platformio", "arduino"])
@pytest.mark.parametrize(
    "controller", [pytest.param("V-sector-w4", marks=pytest.mark.thorough), "quadruped-c"]
)
def test_a_library_for_arduino_compiles_and_its_sketch_keeps_the_period(
    tmp_path, layout, controller
):
    out = tmp_path / "leg"
    arguments = ["export", "c", controller, "--out", str(out), "--prefix", "leg"]
    assert cli.main([*arguments, "--layout", layout]) == 0
    files = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    assert set(json.loads((out / "leg.json").read_text())["files"]) == files == FILES[layout]
    # A board that counts the steps.
    (tmp_path / "Arduino.h").write_text(ARDUINO)
    (tmp_path / "board.cpp").write_text(BOARD)
    code = next(out.rglob("leg.c")).read_text()
    counted = "int steps = 0;\n" + re.sub(
        r"(\nvoid leg_step\([^)]*\)\s*\{)", r"\1\n    ++steps;", code
    )
    assert counted.count("++steps") == 1
    (tmp_path / "counted.c").write_text(counted)
    include = [f"-I{tmp_path}", f"-I{next(out.rglob('leg.h')).parent}"]
    for command in (
        ["gcc", *include, "-c", "counted.c"],
        ["g++", *include, "-Wall", "-Wextra", "-Werror", "-x", "c++", "-c", out / SKETCH],
        ["g++", *include, "-c", "board.cpp"],
        ["g++", "counted.o", "control_loop.o", "board.o", "-lm", "-o", "board"],
    ):
        subprocess.run(command, cwd=tmp_path, check=True)
    process = said_by(tmp_path / "board", check=True)
    assert int(process.stdout) == 101  # from 0 to 0.1 s, every 1 ms


@needs_gcc
def test_the_check_that_a_library_names_runs(tmp_path):
    answer = tg.robots.export_c("V-sector-w4", layout="platformio")
    answer.save(tmp_path)
    command = answer.title.splitlines()[1]
    assert command in (tmp_path / "README.md").read_text()
    process = said_by("sh", "-c", command, cwd=tmp_path)
    assert process.returncode == 0, process.stdout + process.stderr
    description = json.loads((tmp_path / "library.json").read_text())
    assert (description["name"], description["headers"]) == ("tegotae", "tegotae.h")


@pytest.mark.parametrize(("body", "written"), [(Hopper(), True), (Hertz(), False)])
def test_the_spring_is_written_out_in_c_where_it_is_linear(body, written):
    export = Export(
        SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([2.0]), 8.0, body)
    )
    header = next(text for name, text in package_texts(export).items() if str(name).endswith(".h"))
    assert ("STIFFNESS_N_PER_M" in header) is written


def test_a_tick_that_was_not_trained_is_warned_of():
    answer = tg.robots.export_c(trained(0.001, "V-reflex-w8"), tick_s=0.002)
    assert "warning: the controller was trained at a tick of 0.001 s" in answer.notes[0]
    assert "tegotae simulate FILE --hold --tick-s 0.002" in answer.notes[0]
    assert tg.robots.export_c(trained(0.001, "V-reflex-w8")).notes == []


@dataclass(frozen=True)
class Looping(Term):
    """An action that computes in a loop of unknown length."""

    @property
    def reads(self) -> tuple[str, ...]:
        return ("cos_phase",)

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        return jax.lax.while_loop(
            lambda x: (x < -0.5).all(), lambda x: 0.5 * x, signals["cos_phase"]
        )


@dataclass(frozen=True)
class Sorting(Term):
    """An action that sorts."""

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        return jnp.sort(signals["cos_phase"])


@dataclass(frozen=True)
class Elementary(Term):
    """An action of all sorts of elementary functions."""

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        x, y = signals["cos_phase"], signals["spring_force"]
        several = jnp.stack([jnp.exp(-(x**2)), jnp.tanh(y), jnp.arctan2(x, 1.0 + y), jnp.abs(x)])
        return jnp.where(x > 0.0, several.sum(axis=0), jnp.sqrt(several.max(axis=0)))


def test_elementary_functions_stand_in_c_by_their_names():
    text = source(Export(with_action(Elementary())))
    for function in ("expf(", "tanhf(", "atan2f(", "fabsf(", "sqrtf("):
        assert function in text


def over_all_limbs() -> SavedController:
    task = recipe("W-F@quadruped-c").experiment()
    weights = np.zeros(task.controller.n_weights)
    return SavedController.from_weights(task.controller, weights, task.omega, task.body)


@pytest.mark.parametrize(
    ("controller", "options", "reason"),
    [
        (lambda: with_action(Looping()), {}, r"^'while' \(test_export_files.*has no C: write it"),
        (lambda: with_action(Sorting()), {}, r"^'sort' \(test_export_files.*has no C"),
        (over_all_limbs, {}, "^a WholeBodyFoot cannot be exported: it is one network"),
        *((saved, {"prefix": x}, "no name in C") for x in ("2legs", "left leg", "float", "", "l;")),
        (saved, {"prefix": "x" * 40}, "which is no name in C"),
        *((saved, {"prefix": x}, "or one of its library") for x in ("math", "Math", "atomic")),
        *((saved, {"prefix": x}, "or one of its library") for x in ("printf", "class", "library")),
        *((saved, {"prefix": x}, "no name in C") for x in ("left__leg", "leg_")),
        (saved, {"tick_s": 0.0}, "tick is 0; it must be at least 1e-05"),
        (saved, {"tick_s": float("nan")}, "must be finite"),
        (saved, {"tick_s": 5.0}, "must be at most 1"),
        (saved, {"tick_s": 0.9}, "is too long"),
        (saved, {"max_force_n": 2.0}, "has its largest force already"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_a_line(controller, options, reason):
    refused(reason, lambda: package_texts(Export(controller(), **options)))


def test_what_is_no_controller_and_where_nothing_can_be_written_is_said_in_a_line(
    tmp_path, one_line_error
):
    path, taken = tmp_path / "controller.json", tmp_path / "taken"
    taken.write_text("")

    def said(out: str) -> str:
        return one_line_error("export", "c", str(path), "--out", str(tmp_path / out))

    assert "no controller file" in said("out")
    path.write_text("{}")
    assert "is not a controller file" in said("out")
    controller_file.save(saved("V-reflex-w8"), path)
    assert "it is a file" in said("taken")
    assert not (tmp_path / "out").exists()


def test_a_compiler_that_is_missing_is_said_with_what_to_install(monkeypatch):
    monkeypatch.setenv("PATH", "")
    refused(f"^{COMPILER} is not installed; apt-get install", tg.robots.export_cost, "V-reflex-w8")


@pytest.mark.skipif(
    None in (shutil.which(COMPILER), shutil.which(EMULATOR)),
    reason="the Arm compiler or QEMU is not installed",
)
def test_the_cost_of_a_controller_is_counted_on_every_core():
    small, middle, large = tg.robots.export_cost("V-reflex-w8").raw
    # Without a unit for floats every operation is a call.
    assert small.instructions > 5 * middle.instructions > 5 * 50
    assert 50 < large.instructions < 1000
    assert all(300 < cost.flash_bytes < 5000 for cost in (small, middle, large))
    assert middle.ram_bytes == 12 + 4 + 16  # state, inputs and outputs
    assert 0 < middle.stack_bytes < 500
    assert middle.share(64e6) == middle.instructions * 1e3 / 64e6
