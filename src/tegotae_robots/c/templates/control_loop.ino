// control_loop.ino: a step of @prefix@.h every @tick@ s.
// measure() and command() are yours: they know your sensors and actuators.
#include <Arduino.h>
#include <@prefix@.h>

static const uint32_t PERIOD_US = @period_us@;
static @prefix@_state state;
static @prefix@_inputs in;
static @prefix@_outputs out;
static uint32_t due_us;

// Put what the robot measures now into `in`, in the units of @prefix@.h.
static void measure() {
  @measured@
}

% flies
// Send `out` to the actuators. Send 0 while the foot is in the air.
% end flies
% no flies
// Send `out` to the actuators.
% end flies
static void command() {
  @sent_to@
}

void setup() {
% starts_at_phases
  static const float phases[@PREFIX@_LIMBS] = {0.0f};
% end starts_at_phases
  @prefix@_init(&state@setup_phases@);
  due_us = micros();
}

void loop() {
  if ((int32_t)(micros() - due_us) < 0) {
    return;
  }
  due_us += PERIOD_US;
  measure();
  @prefix@_step(&state, &in, &out);
  command();
}
