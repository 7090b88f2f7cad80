"""A controller on a page: what is said of it, and what cannot be explained."""

import dataclasses
import re

import numpy as np
import pytest

import tegotae as tg
from tegotae import SavedController
from tegotae.analysis import controller_page, short_forms
from tegotae.analysis.explanation import (
    Evaluated,
    Visits,
    action_fits,
    arcs,
    mean_feedback,
    parking,
    pushing,
    reaction_fits,
    without_feedback,
)
from tegotae.parts import oscillators, terms
from tegotae.systems.term_sets import LAWS
from tegotae.systems.vanilla import PRESETS

SHORT = {"duration_s": 12.0, "releases": 3, "retune": 0}


def visited(phase, load, force=None, rate=None, action=None, reaction=None, f=None) -> Visits:
    one, nothing = np.ones_like(phase), np.zeros_like(phase)
    given = (action, reaction)
    action, reaction = (one if x is None else x for x in given)
    force, rate, f = (nothing if x is None else x for x in (force, rate, f))
    return Visits(phase, load, load, rate, f, force, action, reaction, one)


def scored(merit, rate=None, sound=None) -> Evaluated:
    """Return an evaluation with these merits, [releases, frequencies], at ω = 1, 2, ... rad/s."""
    merit = np.array(merit, float)
    rate = np.full_like(merit, np.nan) if rate is None else np.array(rate, float)
    sound = np.full(merit.shape, True) if sound is None else np.array(sound)
    omega = 1.0 + np.arange(merit.shape[1])
    return Evaluated(omega, merit, rate, sound, np.full_like(merit, np.nan))


PHASE = np.linspace(0.0, 2.0 * np.pi, 1201)[:-1]
LOAD = np.maximum(0.0, np.sin(PHASE)) * 3.0


def test_a_clock_is_called_one():
    clock = SavedController.from_weights(
        tg.recipe("V-sector-w8").controller(), [0.0], 8.0, name="clock"
    )
    page = tg.load(clock).explain(**SHORT).raw
    assert page.evaluated["cut"].mean == page.evaluated["whole"].mean
    assert any("a clock with a sector" in note for note in page.sentences())


@pytest.fixture(scope="module")
def vanilla():
    return tg.load("V-sector-w8").explain(**SHORT).raw


def test_a_vanilla_controller_has_the_curves_that_it_is_made_of(vanilla):
    (v,) = vanilla.visited
    assert action_fits(v)[0].explained == pytest.approx(1.0)
    assert action_fits(v)[0].numbers == pytest.approx((0.0, -1.0, 0.0), abs=1e-6)
    assert reaction_fits(v)["load"].explained == pytest.approx(1.0)


def test_a_page_has_scores_with_and_without_feedback_of_every_release(vanilla):
    frame = vanilla.table
    assert len(frame) == 3 * 3 * 5
    assert list(vanilla.scores.index) == ["whole", "cut", "frozen"]
    assert "Cutting the feedback changes the score" in vanilla.markdown()


def test_equal_seeds_give_equal_pages_and_others_do_not(vanilla):
    again, other = (tg.load("V-sector-w8").explain(seed=seed, **SHORT).raw for seed in (0, 1))
    assert again.markdown() == vanilla.markdown()
    assert not np.array_equal(other.released.release.height_m, vanilla.released.release.height_m)


def test_a_folder_holds_the_page_its_figures_and_its_numbers(tmp_path):
    answer = tg.load("V-sector-w8").explain(**SHORT)
    names = {path.name for path in answer.save(tmp_path / "page")}
    assert names == {"page.md", "curves.png", "numbers.csv", "numbers.json"}
    assert "curves.png" in (tmp_path / "page" / "page.md").read_text()


def test_one_network_without_feedback_says_so():
    page = tg.load("zoo:T-Fv").explain(**SHORT).raw
    assert [*page.evaluated] == ["whole"]
    assert any("no feedback that could be cut" in note for note in page.sentences())
    assert any("no command to follow" in note for note in page.sentences())


@pytest.mark.thorough
def test_legs_are_judged_by_their_cost_of_transport_and_speed():
    page = tg.load("quadruped-c").explain(duration_s=60.0, releases=2, retune=0).raw
    whole = page.evaluated["whole"]
    assert whole.sound.all()
    assert (whole.speed_m_per_s > 0.0).all()
    assert "speed [m/s]" in page.scores
    assert 0.7 < whole.following < 1.3


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("latch", (2.0, -1.0)),
        ("decay", (2.0, 1.0)),
        ("saturating", (2.0, -1.0, 0.5)),
    ],
)
def test_a_formula_finds_its_own_numbers(name, numbers):
    of = {
        "latch": 2.0 - LOAD,
        "decay": 2.0 * np.exp(-LOAD),
        "saturating": 2.0 - LOAD / (1.0 + 0.5 * LOAD),
    }
    found = reaction_fits(visited(PHASE, LOAD, reaction=of[name]))[name]
    assert found.explained > 0.99
    assert found.numbers == pytest.approx(numbers, rel=0.2)


def test_a_constant_curve_explains_nothing():
    assert np.isnan(action_fits(visited(PHASE, LOAD))[0].explained)


def test_waiting_and_pushing_have_their_places():
    waits = (PHASE > 4.0) & (PHASE < 5.0)
    v = visited(PHASE, LOAD, force=4.0 * (PHASE < 1.0), rate=np.where(waits, 0.1, 4.0))
    share, (place,) = parking(v, 4.0)["flight"]
    assert share == pytest.approx(1.0 / (2.0 * np.pi), abs=0.01)
    assert (place.start_rad, place.width_rad) == pytest.approx((4.0, 1.0), abs=0.11)
    assert parking(v, 4.0)["stance"][0] == 0.0
    share, (place,) = pushing(v, 4.0)
    assert share == pytest.approx(1.0 / np.pi, abs=0.01)
    assert place.width_rad == pytest.approx(1.0, abs=0.06)


def test_an_interval_may_pass_zero_and_what_is_not_visited():
    phase = PHASE[(PHASE < 5.5) | (PHASE > 6.0)]
    (place,) = arcs(phase, phase > -1.0, (phase > 5.0) | (phase < 0.5))
    assert place.start_rad == pytest.approx(5.0, abs=0.06)
    assert place.width_rad == pytest.approx(0.5 + 2.0 * np.pi - 5.0, abs=0.1)
    assert arcs(phase, phase > -1.0, phase > 7.0) == []


SECTOR = PRESETS["paper"].system("sector")


def law(name: str, weights) -> SavedController:
    return SavedController.from_weights(
        LAWS[name].controller(SECTOR), np.array(weights), 4.0, name=name
    )


def test_a_form_starts_from_the_curves_that_it_would_have():
    numbers = {"latch": [0.3, 2.0, 5.0, 1.0, 1.0], "decay": [0.3, 1.0, 5.0, 1.0, 1.0]}
    reactions = {"latch": 1.0 - 2.0 * LOAD, "decay": np.exp(-LOAD)}
    for name, expected in numbers.items():
        force = 4.0 * ((PHASE > 1.0) & (PHASE < 2.0))
        action, reaction = -(np.cos(PHASE) + 0.3), 5.0 * reactions[name]
        v = visited(PHASE, LOAD, force=force, action=action, reaction=reaction)
        _, start = short_forms.starting_forms(law(name, expected), [v])[name]
        assert start == pytest.approx(expected, rel=0.1, abs=0.06)


def test_the_place_of_the_action_moves_the_push_with_it():
    force = 4.0 * ((PHASE > 1.0) & (PHASE < 2.0))
    v = visited(PHASE, LOAD, force=force, action=-np.cos(PHASE - 0.5), reaction=LOAD)
    _, start = short_forms.starting_forms(law("offset", [0.0, 1.0, 1.0, 1.0]), [v])["offset"]
    assert start[2] == pytest.approx(0.5, abs=0.06)


def test_the_shortest_form_that_keeps_a_share_is_taken_and_of_several_the_best():
    def tried(name: str, chosen_by: float, numbers: int) -> short_forms.TriedForm:
        saved = law("clock", [1.0, 1.0])
        saved = dataclasses.replace(saved, weights=np.zeros(numbers))
        return short_forms.TriedForm(name, saved, None, None, chosen_by, 0.0)  # type: ignore[arg-type]

    forms = [tried("a", 0.5, 2), tried("b", 0.9, 4), tried("c", 0.97, 4), tried("d", 1.0, 5)]
    assert [short_forms.shortest(forms, x).name for x in (0.5, 0.8, 0.95, 0.99)] == [*"accd"]  # type: ignore[union-attr]
    assert short_forms.shortest(forms, 1.1) is None


def test_a_form_is_chosen_by_half_of_the_releases_as_retuned_and_judged_by_the_others(monkeypatch):
    """Its first weight is the merit at the releases 0, 2, ..., its second that at the others."""
    saved = law("clock", [1.0, 1.0])

    class Released:
        def evaluated(self, controller, weights) -> Evaluated:
            return scored([[x] for x in (*weights, *weights)])

    released = Released()
    released.saved = saved  # type: ignore[attr-defined]
    starts = {"clock": (saved.controller, np.array([0.1, 0.2]))}
    monkeypatch.setattr(short_forms, "starting_forms", lambda *_: starts)
    found = np.array([[0.3, 0.2], [0.9, 0.6], [0.4, 0.4]]), np.array([1.0, 3.0, 2.0])
    monkeypatch.setattr(short_forms, "retuned", lambda *_: found)
    whole = scored(np.ones((4, 1)))
    (form,) = short_forms.tried_forms(released, whole, [], generations=1, seeds=range(3))  # type: ignore[arg-type]
    assert (form.chosen_by, form.kept) == pytest.approx((0.9, 0.6))
    assert form.cloned.mean.mean == pytest.approx(0.15)


def test_a_form_is_written_as_a_formula_as_terms_and_as_c():
    latch = law("latch", [0.04, 2.78, 6.25, 1.74, 0.75])
    assert short_forms.latex(latch) == (
        r"\dot\phi = \omega - 6.25\, (1 - 2.78 N)\, (\cos\phi + 0.04),\quad "
        r"F = \alpha\, [\phi \in (1.74, 2.49)]"
    )
    assert short_forms.plain_law(latch) == (
        "φ̇ = ω - 6.25 (1 - 2.78 N) (cos φ + 0.04), with full force at φ = 1.74 ... 2.49 rad"
    )
    assert "-6.25f * (1.0f - 2.78f * load) * (cosf(phase) + 0.04f)" in short_forms.c_line(latch)
    known = {**vars(terms), **vars(oscillators), **vars(tg.parts.controller)}
    known |= {"SavedController": SavedController}
    again = eval(short_forms.python(latch), known)
    assert again.controller == latch.controller
    assert again.weights == pytest.approx(latch.weights)


@pytest.mark.parametrize("name", short_forms.forms_of_a_leg())
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_form_is_written_with_two_signs_in_a_row(name, sign):
    controller = short_forms.forms_of_a_leg()[name].controller(SECTOR)
    form = SavedController.from_weights(controller, np.full(controller.n_weights, sign * 0.5), 4.0)
    for written in (short_forms.plain_law(form), short_forms.latex(form), short_forms.c_line(form)):
        assert not re.search(r"[+-] ?[+-]", written)


def test_a_sector_and_a_reflex_add_up_to_no_more_than_the_largest_force():
    lines = short_forms.c_line(law("tuned", [2.0, 1.0, 1.0, 3.0]))
    assert "fminf(max_force, fmaxf(0.0f, (pushes ? max_force : 0.0f) + reflex))" in lines


def test_a_sector_through_zero_is_left_and_entered_in_one_turn():
    through, apart = (law("clock", [start, 1.0]) for start in (6.0, 1.0))
    assert "phase >= 6.0f || phase < 0.716815f" in short_forms.c_line(through)
    assert "phase >= 1.0f && phase < 2.0f" in short_forms.c_line(apart)


def test_a_reflex_starts_and_is_written_with_its_scale():
    """Outside of its sector this leg pushes with 1.5 N per rad/s of falling feedback."""
    inside = (PHASE > 1.0) & (PHASE < 2.0)
    falls = (LOAD > 0.0) & (PHASE > 2.5)
    force = np.where(inside, 9.0, np.where(falls, 3.0, 0.0))
    v = visited(PHASE, LOAD, force=force, action=-np.cos(PHASE), f=np.where(falls, -2.0, 0.0))
    controller, start = short_forms.starting_forms(law("clock", [1.0, 1.0]), [v])["latch+reflex"]
    assert start[-1] == pytest.approx(1.5)
    form = SavedController.from_weights(controller, start, 4.0)
    assert "and 1.5 max(0, -f) N besides" in short_forms.plain_law(form)
    assert r"+ 1.5 \max(0, -f)" in short_forms.latex(form)
    assert "float reflex = 1.5f * fmaxf(0.0f, -feedback);" in short_forms.c_line(form)


def test_numbers_of_a_form_on_legs_are_those_of_its_feedback():
    legs = tg.load("zoo:legs:ART-rF-t+phif+range@quadruped-c", tg.WalkerController).saved
    controller = short_forms.forms_of_legs()["decay"].controller(legs.system, 1000)
    saved = SavedController.from_weights(controller, np.zeros(controller.n_weights), 2.0, legs.body)
    form = short_forms.TriedForm("decay", saved, None, None, 1.0, 1.0)  # type: ignore[arg-type]
    assert (form.numbers, form.of_feet) == (4, legs.controller.actuation.n_weights)


@pytest.mark.thorough
def test_feet_without_feedback_have_no_short_form():
    page = (
        tg.load("zoo:legs:W+phi-F+range@quadruped-c")
        .explain(duration_s=30.0, releases=2, retune=1)
        .raw
    )
    assert not page.forms
    assert any("one network commands the feet" in note for note in page.sentences())


def with_rates(page, rates):
    whole = page.evaluated["whole"]
    rates = np.broadcast_to(rates, whole.merit.shape)
    sound = np.ones_like(whole.sound)
    whole = dataclasses.replace(whole, rate_rad_per_s=rates, sound=sound)
    return dataclasses.replace(page, evaluated={**page.evaluated, "whole": whole})


def test_rates_that_jump_are_not_called_following(vanilla):
    omega = vanilla.evaluated["whole"].omega
    said = [
        " ".join(with_rates(vanilla, x).sentences())
        for x in (omega, omega + np.array([0, 6, 6, 6, 0]))
    ]
    assert ["It follows its command" in text for text in said] == [True, False]
    assert "Its rate is no line over its command" in said[1]
    assert ["times in a turn of its phase" in text for text in said] == [False, True]


def test_a_slope_whose_interval_has_two_words_has_both(vanilla):
    omega = vanilla.evaluated["whole"].omega
    slopes = np.array([[0.7], [0.8], [0.9]])
    (said,) = [x for x in with_rates(vanilla, slopes * omega).sentences() if "slope" in x]
    assert said.startswith("It weakly follows or follows its command: it hops at")
    assert re.search(r"\(mean slope of the releases 0\.8 \[0\.55\d*, 1\.05\d*\]\)\.$", said)


def test_the_slope_of_the_table_is_that_of_the_sentence(vanilla):
    """One release of three settles at two frequencies only, and weighs as much as the others."""
    omega = vanilla.evaluated["whole"].omega
    rates = np.array([[0.1], [0.2], [0.9]]) * omega
    rates[2, 2:] = np.nan
    page = with_rates(vanilla, rates)
    (sentence,) = [x for x in page.sentences() if "slope" in x]
    assert page.scores.loc["whole", "following"] == "0.4"
    assert "mean slope of the releases 0.4 [" in sentence


def with_merits(page, **merits):
    variants = {
        name: dataclasses.replace(page.evaluated[name], merit=np.broadcast_to(x, (8, 5)))
        for name, x in merits.items()
    }
    return dataclasses.replace(page, evaluated={**page.evaluated, **variants})


NOISE = np.array([-1.0, 1.0] * 4)[:, None] * 0.05


@pytest.mark.parametrize(
    ("cut", "frozen", "said"),
    [
        (0.12 + NOISE, 0.1, "its feedback is worth is too small to tell"),
        (0.128, 0.1, "this controller is a clock with a sector"),
        (0.2, 0.1, "its feedback costs more than it gains"),
        (0.05, 0.12 + NOISE, "its changes within a cycle are worth is too small to tell"),
        (0.05, 0.128, "a clock with a sector of another frequency"),
        (0.05, 0.05 + NOISE, "make part of the score"),
        (0.05, 0.05, "make most of the score"),
    ],
)
def test_a_word_on_the_feedback_has_the_paired_interval_behind_it(vanilla, cut, frozen, said):
    (note,) = with_merits(vanilla, whole=0.128, cut=cut, frozen=frozen)._feedback_section()
    assert said in note


def test_one_release_tells_nothing_of_the_feedback():
    page = tg.load("V-sector-w8").explain(duration_s=12.0, releases=1, retune=0).raw
    page = with_merits(page, whole=0.0)
    one = {name: scored([[0.1, 0.1]]) for name in ("whole", "cut", "frozen")}
    page = dataclasses.replace(page, evaluated=one)
    assert "too small to tell" in " ".join(page._feedback_section())


def test_a_fast_phase_is_counted_turn_by_turn():
    """At 200 rad/s the phase passes 4 rad in a frame of 20 ms."""
    clock = SavedController.from_weights(
        tg.recipe("V-sector-w8").controller(), [0.0], 200.0, name="fast clock"
    )
    (v,) = tg.load(clock).explain(**{**SHORT, "duration_s": 4.01, "releases": 2}).raw.visited
    assert v.rate_rad_per_s == pytest.approx(200.0, rel=1e-3)


def test_frozen_is_the_clock_of_the_frequency_that_the_mean_feedback_makes():
    clock = SavedController.from_weights(
        tg.recipe("V-sector-w8").controller(), [0.0], 6.0, name="clock"
    )
    released = tg.load(clock).explain(**SHORT).raw.released
    variants = without_feedback(released, np.full(len(released.omega), 2.0))
    faster = dataclasses.replace(released, omega=released.omega + 2.0)
    expected = faster.evaluated(clock.controller, clock.weights)
    assert variants["frozen"].merit == pytest.approx(expected.merit)
    assert not np.array_equal(variants["frozen"].merit, variants["cut"].merit)


def test_the_mean_feedback_and_the_following_are_those_of_settled_gaits():
    sound = np.array([[True, False], [True, True], [False, True]])
    feedback = np.array([[1.0, 90.0], [3.0, 4.0], [90.0, 6.0]])
    recorded = {"feedback_rad_per_s": np.broadcast_to(feedback, (5, 2, 3, 2))}
    whole = scored(np.ones((3, 2)), rate=[[1.0, 50.0], [1.0, 2.0], [50.0, 2.0]], sound=sound)
    assert mean_feedback(whole, recorded) == pytest.approx([2.0, 5.0])
    assert whole.following == pytest.approx(1.0)


def test_only_a_force_without_a_phase_is_said_to_follow_the_feedback_alone(vanilla):
    for inputs, alone in ((("feedback",), True), (("phase", "feedback"), False)):
        controller = dataclasses.replace(
            vanilla.released.saved.controller, actuation=terms.LearnedActuation(inputs, hidden=2)
        )
        saved = SavedController.from_weights(controller, np.zeros(controller.n_weights), 8.0)
        page = with_merits(vanilla, whole=0.1, cut=0.0, frozen=0.0)
        page = dataclasses.replace(page, released=dataclasses.replace(page.released, saved=saved))
        assert ("follows the feedback alone" in " ".join(page._feedback_section())) is alone


def test_of_a_folder_of_several_controllers_one_is_named_by_its_path(tmp_path, one_line_error):
    for seed in (0, 1):
        saved = SavedController.from_weights(
            tg.recipe("V-sector-w8").controller(), [1.0 + seed], 8.0, name="V"
        )
        tg.save(saved, tmp_path / f"V-seed{seed}.json")
    assert f"such as {tmp_path / 'V-seed0.json'}" in one_line_error("explain", str(tmp_path))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("V-reflex-w8", "follows the feedback alone"),
        ("zoo:AR-rFv-sector-w8", "G R reads the velocity, too"),
    ],
)
def test_what_cutting_and_a_formula_of_the_load_cannot_say_is_named(vanilla, name, said):
    assert said not in vanilla.markdown()
    assert said in tg.load(name).explain(**SHORT).page()


@pytest.mark.thorough
def test_forms_are_retuned_and_the_shortest_are_written_for_a_robot(tmp_path, monkeypatch):
    library = {name: LAWS[name] for name in ("clock", "load")}
    monkeypatch.setattr(short_forms, "forms_of_a_leg", lambda: library)
    for module in (short_forms, controller_page):
        monkeypatch.setattr(module, "SHARES", (0.0,))
    page = tg.load("V-sector-w8").explain(duration_s=20.0, releases=3, retune=2, retune_seeds=1)
    form = page.raw.chosen[0.0]
    assert [tried.name for tried in page.raw.forms] == ["clock"]  # it keeps all: no other is tried
    assert form is not None
    names = {str(path.relative_to(tmp_path)) for path in page.save(tmp_path)}
    assert {"clock.json", "clock-c/tegotae.c", "page.md", "forms.png"} <= names
    assert tg.load(tmp_path / "clock.json").weights == pytest.approx(form.saved.weights)
