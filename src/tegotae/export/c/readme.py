"""What a robot's author reads first, and how the files are compiled."""

from __future__ import annotations

from tegotae.export.c.header import has_action, has_spring, limbs
from tegotae.export.c.layouts import ExportLayout
from tegotae.export.c.names import WHAT, plain
from tegotae.export.c.plan import Export, member, unit_of

_CMAKE = "cmake -B build && cmake --build build && ctest --test-dir build   # or so\n"
_EXAMPLE = "the loop in `examples/control_loop/` is where to begin.\n"
_LIBRARY = {
    "platformio": f"**PlatformIO**: this folder is a library. Put it into `lib/`; {_EXAMPLE}",
    "arduino": f"**Arduino**: this folder is a library. Put it into `libraries/`; {_EXAMPLE}",
}


def readme(export: Export, layout: ExportLayout) -> str:
    """The text of README.md."""
    prefix, saved = export.prefix, export.saved
    force = export.commands == ("force",)
    one = export.limbs == 1
    phases = "phase_rad" if one else "phases_rad"
    start = f", {phases}" if export.tracer.state_names else ""
    rows = [
        f"| in | `{member(name)}` | {unit_of(name)[1]} | {WHAT.get(name, plain(name))} |"
        for name in export.senses
    ]
    what = "force, in [0, α]" if force else "place of the foot from that at rest"
    rows += [
        f"| out | `{member(name)}` | {unit_of(name)[1]} | {what} |" for name in export.commands
    ]
    measured = "".join(
        f"    in.{member(name)}{'' if one else '[leg]'} = ...;\n" for name in export.senses
    )
    at = "" if one else "[leg]"
    command = f"{at} and out.".join(map(member, export.commands))
    of_all = "" if one else ", for every leg"
    sections = [
        f"# {saved.name or 'A Tegotae controller'} as C\n",
        f"Call `{prefix}_step` every {export.tick_s:g} s. No other period will do: it is compiled "
        "in.\n",
        "```c\n"
        f'#include "{prefix}.h"\n\n'
        f"static {prefix}_state state;\n\n"
        f"{prefix}_init(&state{start});\n"
        f"for (;;) {{                         /* every {export.tick_s:g} s */\n"
        f"    {prefix}_inputs in;\n    {prefix}_outputs out;\n"
        f"    /* Measure now{of_all}. */\n{measured}"
        f"    {prefix}_step(&state, &in, &out);\n"
        f"    /* Send out.{command}{at}{of_all}, and hold it until the next tick. */\n"
        "}\n```\n",
        "| | name | unit | what |\n|---|---|---|---|\n" + "\n".join(rows) + "\n",
    ]
    if limbs(export):
        sections.append(_wired(export))
    elif force:
        sections.append(
            "**In the air** the simulated actuator acts on nothing, and the controller commands "
            f"on. Send 0 instead of `{command}` while the foot is off the ground.\n"
        )
    if has_spring(export):
        sections.append(
            f"**The spring's force** is not the force under the foot. From a load cell: "
            f"`{prefix}_spring_force(contact, velocity, actuator)`, `F_k = F_contact + c v - F_a`, "
            f"F_a being what acts now (the last output, 0 in the air). From the leg's length: "
            f"`{prefix}_spring_force_of_length(length)`, `k (l0 - l)`. Use the numbers of your own "
            "leg if they are others than those in the header.\n"
        )
    if export.tracer.state_names:
        sections.append(
            "**Phase at start** may be any: the oscillator locks to the body within a few hops or "
            "steps, if it does at all. It counts modulo 2π; one that is no finite number counts as "
            "0, and `state.faults` is 1. `state.omega_rad_per_s` may be changed between two "
            "steps.\n"
        )
    sections += [
        "**Inputs that are no finite numbers** count as 0, and an oscillator that would leave the "
        "finite numbers stays as it is. Either sets `out.fault` and counts in `state.faults`; "
        f"{'the force is in [0, α]' if force else 'commands are finite'} all the same.\n",
        f"**From C++**, an Arduino sketch too, include `{prefix}.h`; `{prefix}.c` stays C.\n",
        *([_LIBRARY[layout.name]] if layout.library else []),
        f"**Check it**, on the desk and on the target:\n\n```sh\n{layout.check(prefix)}\n"
        + ("" if layout.library else _CMAKE)
        + "```\n",
        f"It runs the {'ticks' if one else 'ticks of all legs'} in "
        f"`{layout.place('golden.csv')}`, which the simulator made {_made(export)}. Compile "
        "without `-ffast-math`: it makes no check for what is no number.\n",
    ]
    return "\n".join(sections)


def _made(export: Export) -> str:
    """How the golden vectors came about."""
    if limbs(export):
        return "of drawn senses, as it drives the environment of the training"
    return "in closed loop with the controller held at this period"


def _wired(export: Export) -> str:
    """What the limbs sense and drive in the environment of the training."""
    prefix = export.prefix
    rows = "".join(
        f"| {k} | {', '.join(f'{name}: `{at}`' for name, at in limb.senses.items())} | "
        f"`{limb.drives}` |\n"
        for k, limb in enumerate(limbs(export))
    )
    limb = "" if export.limbs == 1 else "limb, "
    action = (
        f"`{prefix}_action({limb}force)` is the action of a limb at a force. "
        if has_action(export)
        else ""
    )
    return (
        f"**Limbs** are wired as in training, and begin at `{prefix.upper()}_PHASE_RAD`. {action}A "
        "sense with a minus has the other sign; a load below zero is to be given as zero.\n\n"
        f"| limb | senses | drives |\n|---|---|---|\n{rows}"
    )


def cmake(export: Export) -> str:
    """The text of CMakeLists.txt."""
    prefix = export.prefix
    return f"""\
cmake_minimum_required(VERSION 3.13)
project({prefix} C)

set(CMAKE_C_STANDARD 99)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

add_library({prefix} STATIC {prefix}.c)
target_include_directories({prefix} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})
target_link_libraries({prefix} PUBLIC m)

enable_testing()
add_executable(test_{prefix} test_{prefix}.c)
target_link_libraries(test_{prefix} PRIVATE {prefix})
add_test(NAME golden COMMAND test_{prefix})
"""
