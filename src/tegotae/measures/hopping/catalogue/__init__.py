"""The package's metrics, a module a family; here the order in which tables show them."""

from tegotae.measures.hopping.catalogue import cycle, efficiency, oscillator, spectrum

METRICS = (
    efficiency.COT_INVERSE,
    efficiency.OPTIMUM_SHARE,
    efficiency.COT_INVERSE_TOTAL,
    cycle.T0,
    cycle.T1,
    spectrum.DELTA_OMEGA,
    spectrum.DELTA_W,
    oscillator.CPGU,
    cycle.LIMIT_CYCLE_PERIOD,
    cycle.LIMIT_CYCLE_SHARE,
    cycle.RECOVERY_SHARE,
    cycle.FAILED_SHARE,
    cycle.AT_REST_SHARE,
    efficiency.SMOOTHNESS,
    spectrum.W_PEAK,
    spectrum.A_PEAK,
    cycle.HOP_RATE,
    oscillator.FEEDBACK_SHARE,
    oscillator.PHASE_SHARE,
    oscillator.FEEDBACK_WHILE_PUSHING,
)
