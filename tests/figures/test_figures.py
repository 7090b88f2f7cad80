"""Figures by what they show: the data drawn, the data written beside them, and their commands."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from places import ROOT
from programs import main
from refusals import refused
from research.reproduction.figures.gain_map import gain_map_figure, gain_map_tables
from research.reproduction.ridge import find_ridge, one_to_one_ridge
from tegotae import Rollout, Scenario, Timing
from tegotae.analysis.gaits.sweep import GaitSweep
from tegotae.analysis.maps import GainSweep, HopperBasin, Outcome
from tegotae.analysis.orbit import Orbit
from tegotae.analysis.poincare import Poincare
from tegotae.analysis.surface import Surface
from tegotae.figures.cycles import (
    phase_response_figure,
    poincare_figure,
    poincare_tables,
    portrait_figure,
    predicted,
    surface_figure,
    surface_tables,
)
from tegotae.figures.gaits.lags import sweep_figure
from tegotae.figures.maps import (
    basin_figure,
    phase_locking_figure,
    phase_locking_table,
)
from tegotae.figures.style import (
    COLUMN_IN,
    PAGE_IN,
    figure_file,
    long_table,
    save_figure,
    write_tables,
)
from tegotae.measures.hopping.metrics import AT_REST, FAILED, LIMIT_CYCLE, REGIMES, UNSETTLED
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import legged_system


def outcome() -> Outcome:
    """Three gains by four frequencies: a failure, a rest, an unsettled gait, and limit cycles."""
    regime = np.full((3, 4), LIMIT_CYCLE)
    regime[0, :3] = FAILED, AT_REST, UNSETTLED
    settled = regime == LIMIT_CYCLE
    cot = np.where(settled, np.arange(12.0).reshape(3, 4) / 10.0, np.nan)
    cot[0, 1] = 0.0
    return Outcome(
        regime=regime,
        limit_cycle_period=np.where(settled, 1.0, np.nan),
        cot_inverse=cot,
        cot_inverse_total=2.0 * cot,
        apex_height_m=np.where(settled, 1.3, np.nan),
        hop_rate=np.where(regime >= UNSETTLED, 5.0, np.nan),
        phase_rate=np.where(regime == FAILED, np.nan, np.linspace(5.0, 10.0, 4)),
    )


SWEEP = GainSweep(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0, 7.0]), outcome())
ORBIT = Orbit(
    hops=1,
    period_s=0.5,
    apex_height_m=np.array([1.2]),
    apex_phase_rad=np.array([2.0]),
    time_s=np.linspace(0.0, 0.5, 50, endpoint=False),
    height_m=1.0 + 0.2 * np.cos(np.linspace(0.0, 2 * np.pi, 50, endpoint=False)),
    velocity_m_per_s=-np.sin(np.linspace(0.0, 2 * np.pi, 50, endpoint=False)),
    phase_rad=np.linspace(2.0, 2.0 + 2 * np.pi, 50, endpoint=False) % (2 * np.pi),
    spring_force_n=np.linspace(0.0, 1.0, 50),
    feedback_rad_per_s=np.linspace(-1.0, 0.0, 50),
    actuator_force_n=np.linspace(0.0, 2.0, 50),
)


def meshes(figure: Figure, panel: int) -> list[np.ndarray]:
    """The masked arrays of a panel's colour meshes, in the order of drawing."""
    drawn = [c for c in figure.axes[panel].collections if isinstance(c, QuadMesh)]
    return [np.ma.asarray(mesh.get_array()) for mesh in drawn]


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as stream:
        return list(csv.DictReader(stream))


# The data beside a figure.


def test_tables_are_written_beside_the_figure_with_undefined_values_empty(tmp_path):
    tables = {
        "": {"x": np.array([1.0, np.nan]), "name": np.array(["p", "q"])},
        "more": {"z": [1 / 3]},
    }
    files = write_tables(tmp_path / "map.pdf", tables)
    assert [path.name for path in files] == ["map.csv", "map.more.csv"]
    assert rows(files[0]) == [{"x": "1", "name": "p"}, {"x": "", "name": "q"}]
    assert float(rows(files[1])[0]["z"]) == pytest.approx(1 / 3, rel=1e-8)


# What is drawn.


def test_the_gain_map_draws_a_number_only_where_there_is_a_limit_cycle():
    ridges = {"sector": one_to_one_ridge(SWEEP)}
    figure = gain_map_figure({"sector": SWEEP}, ridges)
    assert figure.get_figwidth() == COLUMN_IN
    for panel, value in ((0, SWEEP.outcome.cot_inverse), (1, SWEEP.outcome.cot_inverse_total)):
        *layers, numbers = meshes(figure, panel)
        settled = SWEEP.outcome.regime == LIMIT_CYCLE
        assert (~np.ma.getmaskarray(numbers) == settled).all()
        assert numbers.compressed().tolist() == value[settled].tolist()
        # Each cell without has a colour of its own, and exactly one.
        covers = sum((~np.ma.getmaskarray(layer)).astype(int) for layer in layers)
        assert (covers == ~settled).all()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"at rest", "no limit cycle", "failed"} <= set(labels)
    assert "[m/J]" in "".join(axes.get_xlabel() for axes in figure.axes)


def test_best_gains_at_the_edge_of_the_map_stand_out_and_are_counted():
    hill = np.array([[0.1, 0.1, 0.1, 0.9], [0.9, 0.9, 0.1, 0.1], [0.1, 0.1, 0.9, 0.1]])
    ridge = find_ridge(SWEEP.sigma, SWEEP.omega, hill)
    assert ridge.sigma.tolist() == [2.0, 2.0, 3.0, 1.0]
    figure = gain_map_figure({"sector": SWEEP}, {"sector": ridge})
    lines = {line.get_marker(): line for line in figure.axes[0].lines}
    assert lines["."].get_ydata().tolist() == ridge.sigma[:2].tolist()
    assert lines["o"].get_ydata().tolist() == ridge.sigma[2:].tolist()
    labels = " ".join(text.get_text() for text in figure.legends[0].get_texts())
    assert "at the map's edge, not fitted\n(sector 2 frequencies)" in labels
    table = gain_map_tables({"sector": SWEEP}, {"sector": ridge})["ridge"]
    assert table["censored"].tolist() == [0, 0, 1, 1]


def test_the_gain_map_of_a_body_that_never_hops_is_drawn_without_a_ridge():
    never = outcome()._replace(
        regime=np.full((3, 4), AT_REST),
        cot_inverse=np.zeros((3, 4)),
        cot_inverse_total=np.zeros((3, 4)),
    )
    sweep = GainSweep(SWEEP.sigma, SWEEP.omega, never)
    figure = gain_map_figure({"reflex": sweep}, {"reflex": one_to_one_ridge(sweep)})
    assert meshes(figure, 0)[-1].count() == 0
    assert len(figure.legends[0].get_texts()) == 3  # two of the ridge, and at rest


def test_the_gain_map_tables_hold_every_cell_and_the_ridge():
    ridges = {"sector": one_to_one_ridge(SWEEP), "reflex": one_to_one_ridge(SWEEP)}
    tables = gain_map_tables({"sector": SWEEP, "reflex": SWEEP}, ridges)
    cells = tables[""]
    assert len(cells["actuation"]) == 2 * 12
    assert cells["regime"][:4].tolist() == ["failed", "at rest", "no limit cycle", "limit cycle"]
    best = [*ridges["sector"].sigma, *ridges["reflex"].sigma]
    assert tables["ridge"]["best_sigma_rad_per_s_n"].tolist() == best


def test_the_phase_locking_map_names_its_ratios_and_shows_the_nearest_cut():
    figure = phase_locking_figure(SWEEP, 2.2)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[:2] == ["1:1 turns : hops", "2:1 turns : hops"]
    assert "σ = 2" in figure.axes[1].get_ylabel()
    by_label = {line.get_label(): line for line in figure.axes[1].lines}
    phase_rate = by_label["mean phase rate"].get_ydata()
    np.testing.assert_allclose(phase_rate, SWEEP.outcome.phase_rate[1])
    np.testing.assert_allclose(by_label["hopping frequency"].get_ydata(), SWEEP.outcome.hop_rate[1])
    table = phase_locking_table(SWEEP)
    assert table["turns_to_hops"][:5].tolist() == ["", "", "", "2:1", "1:1"]
    assert table["sigma_rad_per_s_n"][::4].tolist() == SWEEP.sigma.tolist()


def surface_of(phase: bool) -> Surface:
    columns = np.linspace(0.0, 2 * np.pi, 4) if phase else np.linspace(-1.0, 1.0, 4)
    force = np.arange(12.0).reshape(3, 4)
    return Surface(
        phase_rad=columns if phase else None,
        velocity_m_per_s=np.array([0.5]) if phase else columns,
        spring_force_n=np.array([0.0, 0.5, 1.0]),
        actuator_force_n=force,
        feedback_rad_per_s=-force,
    )


@pytest.mark.parametrize(
    ("force_n", "top_n", "words"),
    [
        (4.0, 4.0, "up to α = 4 N"),
        (0.5, 0.5, "at most 0.5, α = 4 N"),
        (0.001, 4.0, "next to none, α = 4 N"),
        (0.0, 4.0, "next to none, α = 4 N"),
    ],
)
def test_colours_span_the_forces_that_there_are_and_name_alpha(force_n, top_n, words):
    shape = surface_of(True)
    surface = dataclasses.replace(shape, actuator_force_n=shape.actuator_force_n / 11.0 * force_n)
    figure = surface_figure(surface, None, max_force_n=4.0)
    mesh = next(c for c in figure.axes[0].collections if isinstance(c, QuadMesh))
    assert mesh.get_clim() == (0.0, pytest.approx(top_n))
    assert words in figure.axes[1].get_xlabel()


def test_a_feedback_that_is_next_to_nothing_looks_like_it():
    orbit = dataclasses.replace(ORBIT, feedback_rad_per_s=np.linspace(-1e-4, 1e-4, 50))
    axes = surface_figure(surface_of(True), orbit, max_force_n=11.0).axes[-1]
    assert axes.get_ylabel() == "feedback f [rad/s]"
    low, high = axes.get_ylim()
    assert low <= -0.1 < 0.1 <= high


@pytest.mark.parametrize("phase", [True, False], ids=("phase", "velocity"))
def test_the_surface_is_drawn_with_the_limit_cycle_on_it(phase):
    figure = surface_figure(surface_of(phase), ORBIT, max_force_n=11.0, note="title")
    top, below, *_ = figure.axes
    np.testing.assert_array_equal(meshes(figure, 0)[0], surface_of(phase).actuator_force_n)
    np.testing.assert_array_equal(top.lines[0].get_ydata(), ORBIT.spring_force_n)
    np.testing.assert_array_equal(below.lines[0].get_ydata(), ORBIT.actuator_force_n)
    assert top.get_xlabel() == ("phase φ [rad]" if phase else "velocity ẏ [m/s]")
    tables = surface_tables(surface_of(phase), ORBIT)
    assert tables[""]["actuator_force_n"].tolist() == list(range(12))
    assert tables["cycle"]["feedback_rad_per_s"].tolist() == ORBIT.feedback_rad_per_s.tolist()
    if phase:  # where it wraps the path does not cross the panel
        x = top.lines[0].get_xdata()
        assert np.isnan(x).sum() == 1
        assert np.nanmax(np.abs(np.diff(x))) < 1.0
    alone = surface_figure(surface_of(phase), None, max_force_n=11.0)
    assert len(alone.axes[0].lines) == 0
    assert list(surface_tables(surface_of(phase), None)) == [""]


def phase_response(pushes, *shifts):
    """A response at five points of the cycle, of which the second and third are in stance."""
    cycle = np.linspace(0.0, 2 * np.pi, 5, endpoint=False)
    return pd.concat(
        pd.DataFrame(
            {
                "push_ns": push,
                "cycle_phase_rad": cycle,
                "stance": [False, True, True, False, False],
                "shift_rad": shift,
            }
        )
        for push, shift in zip(pushes, shifts, strict=True)
    )


def test_the_phase_response_is_drawn_per_push_with_gaps_where_it_wraps():
    shifts = [0.1, 3.1, -3.1, np.nan, 0.0], [0.0, 0.1, 0.2, 0.1, 0.0]
    response = phase_response([0.01, -0.01], *shifts)
    figure = phase_response_figure(response)
    lines = [line for line in figure.axes[0].lines if "push" in str(line.get_label())]
    assert len(lines) == 2
    np.testing.assert_array_equal(lines[1].get_ydata(), shifts[1])
    assert np.isnan(lines[0].get_ydata()[[2, 3]]).all()


@pytest.mark.parametrize(
    ("largest", "words"),
    [
        (0.0006, "negligible response: at most 0.0006 rad,\n0.0001 of a period"),
        (0.02, ""),
        (np.nan, "the gait never returns to its limit cycle"),
    ],
)
def test_a_response_that_is_negligible_looks_flat_and_is_called_so(largest, words):
    response = phase_response([0.01], [largest * x for x in (0.0, 1.0, -1.0, 0.5, 0.0)])
    axes = phase_response_figure(response).axes[0]
    assert " ".join(text.get_text() for text in axes.texts) == words
    low, high = axes.get_ylim()
    assert low <= -0.02 < 0.02 <= high


@pytest.mark.parametrize("dimension", [1, 2])
def test_the_section_shows_the_decay_beside_that_of_the_linear_map(dimension):
    matrix = np.diag([0.5, 0.2][:dimension])
    star = np.array([1.2, 2.0])[:dimension]
    section = Poincare(
        fixed_point=star,
        refined=True,
        jacobian=matrix,
        multipliers=np.diag(matrix).astype(complex),
        hops=1,
        period_s=0.8,
        nudged=star + 0.01 * 0.5 ** np.arange(6)[:, None] * np.eye(dimension)[:1],
        distance=0.01 * 0.5 ** np.arange(6),
        observed=0.5,
    )
    np.testing.assert_allclose(predicted(section), section.distance)
    apexes = np.tile(star, (4, 1)) + np.array([0.1, 0.05, 0.01, 0.0])[:, None]
    figure = poincare_figure(section, apexes)
    assert figure.get_figwidth() == PAGE_IN
    _, decay, plane = figure.axes
    simulated = {line.get_label(): line for line in decay.lines}["simulated"]
    np.testing.assert_allclose(simulated.get_ydata(), section.distance)
    assert plane.lines[-1].get_xdata().tolist() == np.diag(matrix).tolist()
    tables = poincare_tables(section, apexes)
    assert tables["multipliers"]["modulus"].tolist() == np.diag(matrix).tolist()
    assert ("apex_phase_rad" in tables["transient"]) is (dimension == 2)


def basin_of(number: int) -> HopperBasin:
    cycles = {"hops": 1, "turns": 1, "apex_height_m": 1.1 + np.arange(number), "share": 1 / 12}
    regime = outcome().regime
    index = np.full((3, 4), -1)
    index[regime == LIMIT_CYCLE] = np.arange(9) % number
    frame = long_table(
        ("height_m", np.array([1.0, 1.1, 1.2])),
        ("phase_rad", np.linspace(0.0, 2 * np.pi, 4)),
        {"regime": np.asarray(REGIMES)[regime], "limit_cycle": index},
    )
    return HopperBasin(frame, pd.DataFrame(cycles))


def test_the_basin_colours_each_limit_cycle_and_tells_how_common_it_is():
    figure = basin_figure(basin_of(2))
    numbers = meshes(figure, 0)[-1]
    np.testing.assert_array_equal(numbers.compressed(), np.arange(9) % 2)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[0] == "1 hop, 1 turn, apex 1.10 m (8.3%)"


def test_limit_cycles_beyond_the_fifth_share_a_colour():
    figure = basin_figure(basin_of(8))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "3 other limit cycles (25.0%)" in labels
    assert meshes(figure, 0)[-1].max() == 5


# Files.


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_figures_are_written_in_formats_for_print(ending, tmp_path):
    path = save_figure(phase_locking_figure(SWEEP, 2.0), tmp_path / "new" / f"f.{ending}")
    begins = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[ending]
    assert path.read_bytes().startswith(begins)


def test_a_figure_is_written_whole_or_not_at_all(tmp_path):
    path = tmp_path / "f.png"
    path.write_bytes(b"the figure before")

    class Halfway(Figure):
        def savefig(self, fname, **options):
            fname.write(b"half a figure")
            raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        save_figure(Halfway(), path)
    assert path.read_bytes() == b"the figure before"
    save_figure(Figure(), path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert [p.name for p in tmp_path.iterdir()] == ["f.png"]


@pytest.mark.parametrize("name", ["figure", "figure.xyz", "figure.csv"])
def test_a_figure_of_no_known_format_is_refused_before_any_work(name, tmp_path):
    refused(r"use an ending such as \.png, \.pdf or \.svg", figure_file, tmp_path / name)


# Commands.

REFLEX = "paper-reflex --omega 8 --sigma 2"
QUICK = {
    "reproduction gain-map": "--resolution 3 --duration 8",
    "figure phase-locking": "--resolution 3 --duration-s 8",
    "figure surface": f"{REFLEX} --resolution 5",
    "figure portrait": f"{REFLEX} --duration-s 2",
    "figure phase-response": f"{REFLEX} --points 4",
    "figure poincare": f"{REFLEX} --turns 5",
    "figure basin": f"{REFLEX} --resolution 2",
}
FILES = {
    "reproduction gain-map": {"f.csv", "f.ridge.csv", "f.resonance.csv", "f.loss.csv"},
    "figure phase-locking": {"f.csv"},
    "figure surface": {"f.csv", "f.cycle.csv"},
    "figure portrait": {"f.csv"},
    "figure phase-response": {"f.csv"},
    "figure poincare": {"f.csv", "f.transient.csv", "f.multipliers.csv"},
    "figure basin": {"f.csv", "f.cycles.csv"},
}


@pytest.mark.parametrize("name", QUICK)
def test_every_figure_command_writes_its_figure_and_its_data(name, tmp_path, capsys):
    out = tmp_path / "f.svg"
    assert main([*name.split(), *QUICK[name].split(), "--out", str(out)]) == 0
    document = {"f.json"} if name.startswith("figure") else set()
    assert {path.name for path in tmp_path.iterdir()} == {"f.svg", *FILES[name], *document}
    output, wrong = capsys.readouterr()
    assert wrong == ""
    assert output.splitlines()[-1].startswith(f"wrote {out}")
    for path in tmp_path.glob("*.csv"):
        table = rows(path)
        assert table
        assert all(len(row) == len(table[0]) for row in table)


@pytest.mark.thorough
def test_a_controller_file_is_drawn_like_options(tmp_path, capsys):
    saved = SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([2.0]), 8.0)
    controller_file.save(saved, tmp_path / "c.json")
    for out, source in (
        ("a.svg", [str(tmp_path / "c.json")]),
        ("b.svg", REFLEX.split()),
    ):
        arguments = [
            "figure",
            "surface",
            *source,
            "--resolution",
            "5",
            "--out",
            str(tmp_path / out),
        ]
        assert main(arguments) == 0
    assert (tmp_path / "a.csv").read_text() == (tmp_path / "b.csv").read_text()
    assert (tmp_path / "a.cycle.csv").read_text() == (tmp_path / "b.cycle.csv").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["reproduction", "gain-map", "--omega", "5", "4"], "omega goes from 5 to 4"),
        (["reproduction", "gain-map", "--resolution", "1"], "points along sigma is 1"),
        (["reproduction", "gain-map", "--work", "heat"], "work is 'heat'; it must be one of"),
        (["reproduction", "gain-map", "--mass", "-1"], "mass_kg is -1; it must be greater than 0"),
        (["figure", "phase-locking", "paper-refex"], "did you mean reflex"),
        (["figure", "phase-locking", "--cut", "nan"], "cut is nan"),
        (["figure", "surface", "nowhere.json"], "no controller file at nowhere.json"),
        (["figure", "surface", "--resolution", "0"], "resolution is 0"),
        (
            ["figure", "poincare", "paper-reflex", "--sigma", "0"],
            "has no limit cycle after 60 s",
        ),
        (["figure", "phase-response", "--sigma", "inf"], "sigma is inf"),
        (["figure", "basin", "--height-m", "2", "1"], "height_m goes from 2 to 1"),
    ],
    ids=lambda x: x[0] + " ".join(x[1:3]) if isinstance(x, list) else "",
)
def test_bad_input_is_one_line(arguments, message, tmp_path, capsys):
    assert main([*arguments, "--out", str(tmp_path / "f.png")]) == 2
    output = capsys.readouterr().err
    assert message in output
    assert len(output.splitlines()) == 1
    assert not (tmp_path / "f.png").exists()


def test_a_file_that_cannot_be_written_is_known_before_the_work(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(
        "tegotae.simulation.rollout.Rollout.run", lambda *_, **__: pytest.fail("worked first")
    )
    for name in QUICK:
        assert main([*name.split(), "--out", str(tmp_path / "f.xyz")]) == 2
        assert "use an ending such as .png" in capsys.readouterr().err


def test_a_sweep_has_its_hatches_in_the_key_and_a_cost_that_is_read_to_a_factor_of_two():
    frame = pd.read_csv(ROOT / "docs" / "_static" / "gaits" / "findings-sweep-g.csv")
    names, *_, cost = sweep_figure(GaitSweep(legged_system("quadruped-g"), frame)).axes
    drawn = {(patch.get_facecolor(), patch.get_hatch()) for patch in names.patches}
    key = names.get_legend().get_patches()
    assert drawn == {(patch.get_facecolor(), patch.get_hatch()) for patch in key}
    assert all(patch.get_edgecolor() != patch.get_facecolor() for patch in key)
    low, high = cost.get_ylim()
    assert sum(low <= tick <= high for tick in cost.get_yticks()) >= 4


def test_of_a_portrait_black_is_what_the_releases_settle_to_alone():
    rollout = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=2.0))
    paths = rollout.run([[2.0]] * 3, Scenario(omega=8.0, height_m=np.array([1.05, 1.2, 1.6])))
    labels = {
        line.get_label(): line.get_color()
        for line in portrait_figure(paths, rest_length_m=1.0).axes[0].lines
        if not line.get_label().startswith("_")
    }
    black = [label for label, colour in labels.items() if colour in ("black", "#000000")]
    assert black == ["settled"]
    assert len(set(labels.values())) == len(labels) == 4
