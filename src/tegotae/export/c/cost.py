"""What exported controllers cost on microcontrollers: size, and instructions in emulation."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import jax
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.export.c.golden import golden
from tegotae.export.c.header import header
from tegotae.export.c.lower import number
from tegotae.export.c.plan import Export, member
from tegotae.export.c.source import source
from tegotae.systems.controller_file import SavedController
from tegotae.systems.models import find

CLOCK_HZ = 64e6
"""The clock for which the share is reported."""
TICKS = 200
"""Ticks of the golden run that are counted."""
COMPILER, EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"
PACKAGES = "gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm"
"""The Debian packages of the tools."""
_NS_PER_SYSTICK = 40
"""The emulated boards count at 25 MHz, and an instruction takes 1 ns there by `-icount shift=0`."""
_PATIENCE_S = 120.0


@dataclass(frozen=True)
class Core:
    """A kind of microcontroller, and the emulated board that stands for it."""

    name: str
    flags: tuple[str, ...]
    board: str


CORES = (
    # The instructions of an M0+ are a part of an M3's: the same program executes as many.
    Core("Cortex-M0+", ("-mcpu=cortex-m0plus", "-mthumb", "-mfloat-abi=soft"), "mps2-an385"),
    Core(
        "Cortex-M4F",
        ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"),
        "mps2-an386",
    ),
    Core(
        "Cortex-M7",
        ("-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"),
        "mps2-an500",
    ),
)


@dataclass(frozen=True)
class Cost:
    """What a controller costs on a core."""

    model: str
    weights: int
    core: str
    flash_bytes: int
    """What it adds to a program: code, weights, and what it calls of the C library."""
    ram_bytes: int
    """State, inputs and outputs."""
    stack_bytes: int
    """The deepest that its stack was seen."""
    instructions: float
    """Executed per tick, on average over a closed-loop run."""

    def share(self, clock_hz: float, rate_hz: float = 1000.0) -> float:
        """Share of a clock that ticks at a rate take, at one instruction a cycle."""
        return self.instructions * rate_hz / clock_hz


def require_tools() -> None:
    """Raise `TegotaeError` if the compiler or the emulator is missing."""
    for tool in (COMPILER, EMULATOR):
        if shutil.which(tool) is None:
            raise TegotaeError(f"{tool} is not installed; apt-get install {PACKAGES}")


def systems(models: Sequence[str], seed: int = 0) -> list[Export]:
    """Exports of models of the paper, with random weights.

    Raises:
        TegotaeError: for an unknown model.
    """
    exports = []
    for name in models:
        model = find(name)
        controller = model.controller()
        weights = np.asarray(controller.initial(jax.random.key(seed)))
        saved = SavedController.of(controller, weights, model.omega_t, name=model.name)
        exports.append(Export(saved))
    return exports


def costs(export: Export, cores: Sequence[Core] = CORES) -> Iterator[Cost]:
    """Compile a controller for each core, and count what its ticks take.

    Raises:
        TegotaeError: if the tools are missing, or fail.
    """
    require_tools()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        _write(export, folder)
        for core in cores:
            yield _cost(export, core, folder)


def _cost(export: Export, core: Core, folder: Path) -> Cost:
    """The cost on a core of what was written to a folder."""
    sizes = [_flash(_compiled(folder, core, with_step)) for with_step in (True, False)]
    ran = _run(
        f"{EMULATOR} -M {core.board} -nographic -icount shift=0 -semihosting -monitor none "
        "-serial none -kernel with_step.elf",
        folder,
    )
    try:
        ticks, with_step, without, ram, stack = map(int, ran.split())
    except ValueError:
        raise TegotaeError(f"{EMULATOR} gave {ran[:200]!r} instead of five numbers") from None
    return Cost(
        export.saved.name or "controller",
        export.saved.controller.n_weights,
        core.name,
        sizes[0] - sizes[1],
        ram,
        stack,
        _NS_PER_SYSTICK * (with_step - without) / ticks,
    )


def _write(export: Export, folder: Path) -> None:
    prefix = export.prefix
    (folder / f"{prefix}.c").write_text(source(export))
    (folder / f"{prefix}.h").write_text(header(export))
    vectors = golden(export)
    n_state = len(export.tracer.state_names) * export.limbs
    n_inputs = len(export.senses) * export.limbs
    chosen = vectors.rows[:: max(1, len(vectors.rows) // TICKS)][:TICKS, : n_state + n_inputs]
    rows = ",\n".join("{" + ", ".join(number(x, "float")[0] for x in row) + "}" for row in chosen)
    at = "" if export.limbs == 1 else "[i]"
    put = [f"state->oscillator{at}.{name} = row[k++];" for name in export.tracer.state_names]
    put += [f"in->{member(name)}{at} = row[k++];" for name in export.senses]
    loops = "".join(f"    for (int i = 0; i < {export.limbs}; ++i) {{ {x} }}\n" for x in put)
    phases = f", (const float[{export.limbs}]){{0.0f}}" if at else ", 0.0f"
    (folder / "vectors.h").write_text(
        f'#include "{prefix}.h"\n'
        f"#define NAME(x) {prefix}_ ## x\n"
        f"#define TICKS {len(chosen)}\n"
        f"#define INIT(s) {prefix}_init(s{phases if export.tracer.state_names else ''})\n"
        f"static const float ROWS[TICKS][{n_state + n_inputs}] = {{\n{rows}\n}};\n"
        f"static void put({prefix}_state *state, {prefix}_inputs *in, const float *row)\n"
        f"{{\n    int k = 0;\n    (void)state; (void)in;\n{loops}}}\n"
    )
    own = resources.files("tegotae.export.c")
    for name in ("firmware.c", "firmware.ld"):
        (folder / name).write_text(own.joinpath(name).read_text(encoding="utf-8"))


def _compiled(folder: Path, core: Core, with_step: bool) -> Path:
    (own,) = [path.name for path in folder.glob("*.c") if path.name != "firmware.c"]
    target = "with_step.elf" if with_step else "without.elf"
    _run(
        f"{COMPILER} {' '.join(core.flags)} -std=c99 -O2 -ffunction-sections -fdata-sections "
        f"-DWITH_STEP={int(with_step)} -nostartfiles --specs=nosys.specs -Wl,--gc-sections "
        f"-T firmware.ld firmware.c {own} -lm -o {target}",
        folder,
    )
    return folder / target


def _flash(program: Path) -> int:
    """Bytes of code and constants in a program."""
    line = _run(f"arm-none-eabi-size {program.name}", program.parent).splitlines()[1]
    text, data = map(int, line.split()[:2])
    return text + data


def _run(line: str, folder: Path) -> str:
    command = line.split()
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=_PATIENCE_S
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise TegotaeError(f"{command[0]} did not run: {error}") from None
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines() or ["no reason given"]
        raise TegotaeError(f"{command[0]} failed: {said[0][:300]}")
    return done.stdout + done.stderr if command[0] == EMULATOR else done.stdout
