"""Conditions of a lane: bodies that differ from lane to lane, and changes during a rollout."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Bar, Plate, Sensors, Walker
from tegotae.parts.parameters import traceable
from tegotae.simulation.draws import check_scenario
from tegotae.simulation.schedules import (
    Chain,
    Constant,
    Ramp,
    Schedule,
    SecondClock,
    Staircase,
    Step,
    TickClock,
)
from tegotae.simulation.world import with_changes
from tegotae.systems.recipe import recipe

ROLLOUT = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=4.0))
MASSES = [0.08, 0.1, 0.12]


def run(body=None, **scenario):
    return ROLLOUT.run([2.0], Scenario(omega=8.0, **scenario), body, dtype="float64")


def test_a_field_that_differs_from_lane_to_lane_gives_each_lane_its_own_body():
    together = run(changes={"mass_kg": MASSES})
    for lane, mass in enumerate(MASSES):
        alone = run(Hopper(mass_kg=mass))
        np.testing.assert_allclose(together.height_m[:, lane], alone.height_m[:, 0], rtol=1e-12)
        np.testing.assert_allclose(together.energy_j[:, lane], alone.energy_j[:, 0], rtol=1e-12)


def test_a_step_changes_nothing_before_its_time_and_everything_after():
    path = run(changes={"mass_kg": Step([0.1, 0.15, 0.15], from_s=[0.0, 2.0, 0.0])})
    baseline, late, heavy = path.height_m.T
    early = path.time_s[:, 0] <= 2.0
    np.testing.assert_array_equal(late[early], baseline[early])
    assert not np.allclose(late[~early], baseline[~early])
    np.testing.assert_allclose(heavy, run(Hopper(mass_kg=0.15)).height_m[:, 0], rtol=1e-12)


def test_a_step_ends():
    path = run(changes={"stiffness_n_per_m": Step([5.0, 9.0], from_s=1.0, until_s=2.0)})
    baseline, pulsed = path.energy_j.T
    time = path.time_s[:, 0]
    assert not np.allclose(
        baseline[(time > 1.0) & (time < 2.0)], pulsed[(time > 1.0) & (time < 2.0)]
    )
    # The energy of a leg that is as stiff as before is that of the height and speed alone.
    body, end = Hopper(), np.flatnonzero(time > 2.5)[0]
    pressed = max(0.0, 1.0 - path.height_m[end, 1])
    energy = 0.05 * path.velocity_m_per_s[end, 1] ** 2 + body.weight_n * path.height_m[end, 1]
    assert pulsed[end] == pytest.approx(energy + 2.5 * pressed**2, rel=1e-9)


def test_a_staircase_leads_the_frequency_up():
    changes = {"omega": Staircase(step=[0.0, 2.0], dwell_s=1.0, levels=3)}
    path = Rollout(
        controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=4.0)
    ).run([0.0], Scenario(omega=5.0, changes=changes), dtype="float64")
    turns = np.diff(np.unwrap(path.phase_rad, axis=0), axis=0) / 0.02
    np.testing.assert_allclose(turns[:, 0], 5.0, rtol=1e-6)
    for level, rate in enumerate((5.0, 7.0, 9.0, 9.0)):
        middle = turns[50 * level + 5 : 50 * level + 45, 1]
        np.testing.assert_allclose(middle, rate, rtol=1e-6)


def test_a_ramp_leads_the_frequency_to_its_value_and_stays():
    changes = {"omega": Ramp([5.0, 9.0, 9.0], from_s=[1.0, 1.0, np.inf], until_s=3.0)}
    path = ROLLOUT.run([0.0], Scenario(omega=5.0, changes=changes), dtype="float64")
    turns = np.diff(np.unwrap(path.phase_rad, axis=0), axis=0) / 0.02
    middle_s = path.time_s[1:, 0] - 0.01
    steady, rising, never = turns.T
    np.testing.assert_allclose(steady, 5.0, rtol=1e-6)
    np.testing.assert_array_equal(never, steady)
    np.testing.assert_allclose(rising, np.interp(middle_s, [1.0, 3.0], [5.0, 9.0]), atol=0.02)


@pytest.mark.parametrize(
    "schedule",
    [
        Constant(2.0),
        Step(2.0, from_s=0.5, until_s=1.2),
        Ramp(2.0, from_s=0.5, until_s=1.5),
        Staircase(0.5, dwell_s=0.4, levels=4),
        Chain((Step(2.0, from_s=0.5), Staircase(0.5, dwell_s=0.4, levels=4))),
    ],
)
def test_a_schedule_means_the_same_in_a_rollout_and_in_another_simulator(schedule):
    for tick in range(0, 20):
        of_tick = schedule.at(TickClock(jnp.asarray(tick), 0.1), 1.0)
        assert float(of_tick) == pytest.approx(schedule.at(SecondClock(tick * 0.1 + 1e-9), 1.0))
    assert schedule.neutral(1.0).at(SecondClock(1.1), 1.0) == 1.0


@traceable
@dataclasses.dataclass(frozen=True)
class Gust(Schedule):
    """A user's schedule: a gust that comes and goes smoothly."""

    value: LaneNumbers
    from_s: LaneNumbers
    lasts_s: LaneNumbers

    def at(self, clock, nominal):
        share = clock.xp.clip(clock.since_s(self.from_s) / self.lasts_s, 0.0, 1.0)
        return nominal + 0.5 * (1.0 - clock.xp.cos(2.0 * np.pi * share)) * (self.value - nominal)

    def corners(self, duration_s):
        return (self.from_s + 0.5 * self.lasts_s,)

    def neutral(self, nominal):
        return dataclasses.replace(self, value=nominal)


def test_a_schedule_of_a_user_holds_in_a_rollout_and_is_checked_at_its_corners():
    path = run(changes={"mass_kg": Gust([0.1, 0.12], from_s=1.0, lasts_s=1.0)})
    early = path.time_s[:, 0] <= 1.0
    np.testing.assert_allclose(path.height_m[early, 1], path.height_m[early, 0], rtol=1e-12)
    assert abs(path.height_m[-1, 1] - path.height_m[-1, 0]) > 1e-6
    with pytest.raises(TegotaeError, match="mass_kg is -1; it must be greater than 0"):
        run(changes={"mass_kg": Gust(-1.0, from_s=1.0, lasts_s=1.0)})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"mas_kg": 0.1}, "no field of a Hopper is called 'mas_kg'; did you mean mass_kg, "),
        ({"mass_kg": [0.1, -0.1]}, "mass_kg is -0.1; it must be greater than 0"),
        ({"mass_kg": Step(0.0, from_s=1.0)}, "mass_kg is 0; it must be greater than 0"),
        ({"mass_kg": Step(0.1, from_s=np.nan)}, "the change of mass_kg, from_s, is nan"),
        ({"stiffness_n_per_m": [5.0, 5e4]}, "the control tick of 0.001 s is too long"),
        ({"mass_kg": Staircase(-0.06, 1.0)}, "mass_kg is -0.14; it must be greater"),
        ({"mass_kg": Staircase(0.1, 0.0)}, "the change of mass_kg, dwell_s, is 0; it must be at"),
        ({"mass_kg": Ramp(-0.1, 1.0, 2.0)}, "mass_kg is -0.1; it must be greater than 0"),
        ({"mass_kg": Ramp(0.1, 2.0, 1.0)}, "the change of mass_kg ends at 1.0 s and begins at 2.0"),
        ({"mass_kg": Chain((Step(0.1), Staircase(-0.06, 1.0)))}, "mass_kg is -0.14; it must be"),
        ({"mass_kg": Step(0.1, 2.0, 1.0)}, "the change of mass_kg ends at 1.0 s and begins at 2.0"),
        ({"mass_kg": [[0.1], [0.2]]}, "the change of mass_kg has value of shape"),
        ({"omega": Step(np.nan)}, "the change of omega is nan"),
        ({"omega": 4.0}, "the change of omega is 4.0; a frequency that holds"),
        ({"mass_kg": "much"}, "the change of mass_kg is 'much'; it must be a number"),
        ("mass_kg", "changes is 'mass_kg'; it must be numbers by name"),
    ],
)
def test_a_change_that_cannot_be_is_refused_in_one_line(changes, says):
    refused(says, run, changes=changes)


def test_changes_that_go_together_are_judged_together():
    # Each alone would be an inertia that no body has.
    body = Walker()
    together = {
        f"inertia_{axis}_kg_m2": Step(3.0 * getattr(body, f"inertia_{axis}_kg_m2"), from_s=1.0)
        for axis in "xyz"
    }
    check_scenario(Scenario(1.0, changes=together), body, None, Timing(tick_s=0.01))
    alone = {"inertia_z_kg_m2": together["inertia_z_kg_m2"]}
    with pytest.raises(TegotaeError, match="which no body has"):
        check_scenario(Scenario(1.0, changes=alone), body, None, Timing(tick_s=0.01))
    # One leg of soft springs does not bear what four bear, nor twice the weight.
    soft = {
        "present": Step([[1.0], [0.0], [0.0], [0.0]], from_s=1.0),
        "mass_kg": Step(6.5, from_s=2.0),
    }
    with pytest.raises(TegotaeError, match="1 legs give way"):
        check_scenario(Scenario(1.0, changes=soft), body, None, Timing(tick_s=0.01))


def test_what_belongs_to_the_legs_has_a_row_for_each():
    for legs in ([1.0, 1.0, 0.0, 1.0], [[1.0], [1.0]]):
        with pytest.raises(TegotaeError, match=r"write a row for each of them, \[4, lanes\]"):
            check_scenario(
                Scenario(1.0, changes={"present": legs}), Walker(), None, Timing(tick_s=0.01)
            )
    with pytest.raises(TegotaeError, match="twist_inertia_ratio of this Plate is None"):
        check_scenario(
            Scenario(1.0, changes={"twist_inertia_ratio": 0.6}), Plate(), None, Timing(tick_s=0.001)
        )


def test_late_times_are_whole_ticks_in_single_precision_too():
    for time in np.arange(300.0, 600.0, 0.37).round(2):
        tick = round(time / 0.01)
        heights = [
            float(Step(1.0, np.float32(time)).at(TickClock(jnp.asarray(t), jnp.float32(0.01)), 0.0))
            for t in (tick - 1, tick)
        ]
        assert heights == [0.0, 1.0], time


# Changes by name.


def test_a_change_by_name_goes_where_its_name_belongs():
    body = Sensors(body=Bar())
    met = with_changes(
        Scenario(omega=8.0),
        body,
        {
            "omega": Step(6.0, from_s=1.0),
            "height_m": 1.1,
            "pitch_rad": 0.1,
            "drop_m": Step(0.05, from_s=3.0),
            "ground_m": Staircase(-0.1, 1.0),
            "delay_s": 0.01,
            "body.inertia_ratio": 0.6,
        },
    )
    assert (met.omega, met.height_m, met.drop_m, met.drop_time_s) == (8.0, 1.1, 0.05, 3.0)
    assert met.initial_pose == {"pitch_rad": 0.1}
    assert set(met.changes) == {"omega", "ground_m", "delay_s", "body.inertia_ratio"}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"weight": 1.0}, "no field of a Bar is called 'weight'"),
        ({"height_m": Step(1.1)}, "height_m is of the release; it cannot change on the way"),
        ({"pitch_rad": Staircase(0.1, 1.0)}, "pitch_rad is of the release"),
        ({"drop_m": Step(0.1, 1.0, 2.0)}, "drop_m is for good; .* is a schedule of ground_m"),
        ({"ground_m": 0.1}, "for a drop name drop_m"),
    ],
)
def test_a_change_of_what_is_not_there_or_cannot_be_scheduled_is_refused(changes, says):
    refused(says, lambda: with_changes(Scenario(omega=8.0), Bar(), changes))
