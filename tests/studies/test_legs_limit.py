"""The limit of a walker's cost of transport: what is proved holds, and what was found is best."""

import dataclasses

import numpy as np
import pytest

from places import ROOT
from refusals import refused
from research.legs_limit.known import bound, limit, limit_share, limit_table, stance_loss_j
from tegotae._support.tables import read_csv
from tegotae.measures.fronts import front
from tegotae.parts.bodies import Walker
from tegotae.simulation.recorder import needing
from tegotae.systems.legged import random_phases
from tegotae.systems.vanilla import legged_named

K, D, STANCE = 14.0, 0.9, 1.3
TIME = (np.arange(4000) + 0.5) * STANCE / 4000


def borne(depth, rate):
    """Energy that a leg loses, and the impulse that it bears, by d(t) and ḋ(t)."""
    load = np.maximum(K * depth + D * rate, 0.0)
    step = STANCE / len(TIME)
    return (load * rate).sum() * step, load.sum() * step


def test_no_way_to_load_a_leg_loses_less_than_the_closed_form():
    rng = np.random.default_rng(0)
    shares = []
    for _ in range(300):
        waves = [np.sin(k * np.pi * TIME / STANCE + rng.uniform(0.0, 6.0)) / k for k in range(1, 5)]
        depth = np.abs(np.tensordot(rng.normal(size=4), waves, 1) * np.minimum(20.0 * TIME, 1.0))
        loss, impulse = borne(depth, np.gradient(depth, TIME))
        shares.append(loss / stance_loss_j(impulse, STANCE, K, D))
    assert min(shares) > 1.0


def test_the_parabola_loses_just_that():
    slow = 2.0 * D / K
    loss, impulse = borne(TIME * (STANCE + slow - TIME), STANCE + slow - 2.0 * TIME)
    assert loss == pytest.approx(stance_loss_j(impulse, STANCE, K, D), rel=1e-5)


def test_an_elastic_leg_need_not_lose_anything():
    assert stance_loss_j(1.0, STANCE, K, 0.0) == 0.0
    assert bound(Walker(damping_z_ns_per_m=0.0), 0.4, 1.0) == 0.0


def test_a_leg_that_is_a_damper_alone_loses_the_impulse_squared_over_its_damping_and_time():
    assert stance_loss_j(1.0, 0.5, 1e-4, D) == pytest.approx(1.0 / (D * 0.5), rel=1e-3)


@pytest.mark.parametrize("numbers", [(0.0, D), (K, -1.0)])
def test_a_leg_that_cannot_be_is_refused(numbers):
    refused(r"damping|stiffness", lambda: stance_loss_j(1.0, STANCE, *numbers))


@needing("work_absolute_j", "x_m", "y_m", "stance_time_s", "failed")
def _walk(path, scenario, body, timing):
    half = path.x_m.shape[0] // 2
    distance = [x[-1] - x[half] for x in (path.x_m, path.y_m)]
    return {
        "work": path.work_absolute_j[-1] - path.work_absolute_j[half],
        "way": (distance[0] ** 2 + distance[1] ** 2) ** 0.5,
        "stands": path.stance_time_s[half:],
        "failed": path.failed[-1],
    }


def test_walkers_of_any_gain_and_frequency_cost_more_than_is_proved():
    legged = legged_named("quadruped-c")
    lanes, rng = 64, np.random.default_rng(1)
    scenario = legged.scenario(random_phases(4, lanes))._replace(omega=rng.uniform(0.8, 5.0, lanes))
    timing = dataclasses.replace(legged.timing, duration_s=40.0, tick_s=0.0125, frame_s=0.05)
    rollout = legged.rollout(_walk, timing)
    results = rollout.run(rng.uniform(0.0, 3.0, (lanes, 1)), scenario, legged.body)
    walks = ~results["failed"] & (results["way"] > 1.0)
    assert walks.sum() > 40
    longest = np.array([longest_stance(results["stands"][:, :, k]) for k in range(lanes)])
    cost = (results["work"] / results["way"])[walks]
    speed = (results["way"] / 20.0)[walks]
    assert (cost > bound(legged.body, speed, longest[walks])).all()


def longest_stance(total):
    """The longest time of a foot on the ground, from totals at frames of 0.05."""
    on = np.diff(total, axis=0) > 0.0
    runs = np.zeros(on.shape[1])
    longest = runs.copy()
    for frame in on:
        runs = np.where(frame, runs + 0.05, 0.0)
        longest = np.maximum(longest, runs)
    return longest.max()


# What was found


def test_free_feet_cost_no_more_than_feet_on_the_ellipse_and_more_than_is_proved():
    table = limit_table()
    free = table["feet"] == "free"
    speed = table["speed"][free]
    assert (limit(speed) <= 1.001 * limit(speed, "ellipse"))[
        np.isfinite(limit(speed, "ellipse"))
    ].all()
    proved = bound(Walker(), table["speed"], table["longest_stance"])
    searched = table["source"] == "search"
    assert (table["cost_of_transport"] > proved)[searched].all()


def test_no_vanilla_walker_of_the_front_is_below_the_limit():
    curve = front("quadruped-c", "vanilla")
    share = limit_share(curve["speed"], curve["cost_of_transport"])
    assert np.isfinite(share).sum() > 10
    assert np.nanmax(share) < 1.0


def test_no_learned_walker_that_is_kept_is_below_the_limit_of_what_its_feet_may_do():
    table = read_csv(ROOT / "research" / "learned_legs" / "range.csv")
    cells = np.asarray(table["cell"], str)
    speed, cost = (
        np.array([float(c) if str(c) else np.nan for c in table[name]])
        for name in ("speed_m_per_s", "cost_of_transport")
    )
    mine = np.char.endswith(cells, "@quadruped-c") & np.isfinite(cost)
    assert mine.sum() > 50
    assert np.nanmax(limit_share(speed[mine], cost[mine])) < 1.0  # free feet
    ellipse = mine & ~np.char.startswith(cells, "W") & ~np.char.startswith(cells, "T-")
    ellipse &= np.array(["-t" not in cell for cell in cells])
    assert np.nanmax(limit_share(speed[ellipse], cost[ellipse], "ellipse")) <= 1.0 + 1e-3


def test_other_feet_are_refused_with_those_that_there_are():
    refused("kind of feet", limit, 0.3, "hooves")
