"""A sketch for Arduino and PlatformIO: the controller in a loop of its own period."""

from __future__ import annotations

from tegotae.export.c.plan import Export, member
from tegotae.export.c.wired import limbs


def sketch(export: Export) -> str:
    """The text of control_loop.ino: setup and loop, and two functions for a robot's author."""
    prefix = export.prefix
    one = export.limbs == 1
    at = "" if one else "[leg]"
    legs = f"for (int leg = 0; leg < {prefix.upper()}_LIMBS; ++leg) "
    measured = " ".join(f"in.{member(name)}{at} = 0.0f;" for name in export.senses)
    sent = " ".join(f"(void)out.{member(name)}{at};" for name in export.commands)
    if not one:
        measured, sent = (f"{legs}{{ {line} }}" for line in (measured, sent))
    phases = ""
    start = f"{prefix}_init(&state);"
    if export.tracer.state_names:
        start = f"{prefix}_init(&state, {'0.0f' if one else 'phases'});"
        if not one:
            phases = f"  static const float phases[{prefix.upper()}_LIMBS] = {{0.0f}};\n"
    air = ""
    if export.commands == ("force",) and not limbs(export):
        air = " Send 0 while the foot is in the air."
    return f"""\
// control_loop.ino: a step of {prefix}.h every {export.tick_s:g} s.
// measure() and command() are yours: they know your sensors and actuators.
#include <Arduino.h>
#include <{prefix}.h>

static const uint32_t PERIOD_US = {round(1e6 * export.tick_s)};
static {prefix}_state state;
static {prefix}_inputs in;
static {prefix}_outputs out;
static uint32_t due_us;

// Put what the robot measures now into `in`, in the units of {prefix}.h.
static void measure() {{
  {measured}
}}

// Send `out` to the actuators.{air}
static void command() {{
  {sent}
}}

void setup() {{
{phases}  {start}
  due_us = micros();
}}

void loop() {{
  if ((int32_t)(micros() - due_us) < 0) {{
    return;
  }}
  due_us += PERIOD_US;
  measure();
  {prefix}_step(&state, &in, &out);
  command();
}}
"""
