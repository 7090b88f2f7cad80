"""Measure exported controllers on microcontrollers: size, and instructions in emulation."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae_robots.c.golden import golden, put, vector_initialiser
from tegotae_robots.c.package import header
from tegotae_robots.c.plan import Export, facts, usual_tick_s
from tegotae_robots.c.source import source
from tegotae_robots.c.text import filled_c, template_text

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
    """Cost of a controller on a core."""

    model: str
    weights: int
    core: str
    flash_bytes: int
    """Bytes that it adds to a program: code, weights, and its functions of the C library."""
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


def systems(models: Sequence[str]) -> list[Export]:
    """Return exports of controllers: of files, and of models of the paper with random weights.

    Raises:
        TegotaeError: for an unknown model, or a file that is no controller.
    """
    return [_export_of(name) for name in models]


def _export_of(name: str) -> Export:
    if Path(name).is_file():
        saved = resolve(name).controller()
        return Export(saved, tick_s=usual_tick_s(saved))
    model = recipe(name)
    controller = model.controller()
    weights = np.asarray(controller.initial(jax.random.key(0)))
    return Export(SavedController.from_weights(controller, weights, model.omega_t, name=model.name))


def costs(export: Export) -> Iterator[Cost]:
    """Compile a controller for each core, and count the cost of its ticks.

    Raises:
        TegotaeError: if the tools are missing, or fail.
    """
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_program(export, folder)
        for core in CORES:
            yield cost_on(export, core, folder)


def cost_on(export: Export, core: Core, folder: Path) -> Cost:
    """Measure the cost on a core of the program that `write_program` wrote to a folder.

    Raises:
        TegotaeError: if the tools are missing, or fail.
    """
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


def write_program(export: Export, folder: Path) -> None:
    """Write the controller, ticks of its golden run, and the program that counts them."""
    prefix = export.prefix
    (folder / f"{prefix}.c").write_text(source(export))
    (folder / f"{prefix}.h").write_text(header(export))
    vectors, limbs = golden(export), export.limbs
    columns = (len(export.state_names) + len(export.senses)) * limbs
    rows = vectors.rows[:: max(1, len(vectors.rows) // TICKS)][:TICKS, :columns]
    phases = ", 0.0f" if limbs == 1 else f", (const float[{limbs}]){{0.0f}}"
    entries = {
        **facts(export),
        "ticks": len(rows),
        "phases": phases if export.state_names else "",
        "columns_count": columns,
        "rows": vector_initialiser(rows),
        "put": put(export, "state->", "in->"),
    }
    (folder / "vectors.h").write_text(filled_c("vectors.h", entries))
    for name in ("firmware.c", "firmware.ld"):
        (folder / name).write_text(template_text(name), encoding="utf-8")


def _compiled(folder: Path, core: Core, with_step: bool) -> Path:
    (controller,) = [path.name for path in folder.glob("*.c") if path.name != "firmware.c"]
    target = "with_step.elf" if with_step else "without.elf"
    _run(
        f"{COMPILER} {' '.join(core.flags)} -std=c99 -O2 -ffunction-sections -fdata-sections "
        f"-DWITH_STEP={int(with_step)} -nostartfiles --specs=nosys.specs -Wl,--gc-sections "
        f"-T firmware.ld firmware.c {controller} -lm -o {target}",
        folder,
    )
    return folder / target


def _flash(program: Path) -> int:
    """Return the size of code and constants in a program [bytes]."""
    line = _run(f"arm-none-eabi-size {program.name}", program.parent).splitlines()[1]
    text, data = map(int, line.split()[:2])
    return text + data


def _run(line: str, folder: Path) -> str:
    command = line.split()
    try:
        process = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=_PATIENCE_S
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise TegotaeError(f"{command[0]} did not run: {error}") from None
    if process.returncode:
        lines = (process.stderr or process.stdout).strip().splitlines() or ["no reason given"]
        raise TegotaeError(f"{command[0]} failed: {lines[0][:300]}")
    return process.stdout + process.stderr if command[0] == EMULATOR else process.stdout
