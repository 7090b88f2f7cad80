"""The playground's engine does what the package does, and learns as it learns."""

import dataclasses
import gzip
import json
import re

import jax
import jax.numpy as jnp
import my_parts
import numpy as np
import pytest
from springs import Hertz

import tegotae
from apps.playground import (
    ControllerChoice,
    Page,
    compiler,
    engine_cache as shelf,
    standard,
)
from apps.playground.bodies import STANDARD
from apps.playground.page import DEFINITIONS
from apps.playground.scripts import bundle_scripts, modules, read_source
from places import ROOT
from played import (
    Case,
    all_that_can_happen,
    assert_same,
    in_node,
    needs_node,
    played_in_node,
    wasm_of,
)
from programs import main
from refusals import refused
from tegotae import Rollout, Scenario, Timing
from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.hopping import whole_hops
from tegotae.measures.objectives.fitness import EPISODE, SETTLE_S, Fitness
from tegotae.parts.bodies import Hopper, Plate, Walker
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import Clamped, PhaseOscillator
from tegotae.parts.terms import ConstantGain, Reflex, VanillaReaction
from tegotae.simulation.schedules import Step
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.recipe import recipe
from tegotae.training.algorithms import PGPE

needs_compiler = pytest.mark.skipif(
    not compiler.has_compiler(), reason="needs ziglang: pip install 'tegotae[playground]'"
)
CHOICES = {choice.saved.name: choice.saved for choice in standard()}
ART, VANILLA = CHOICES["ART-rF-tphif-w8"], CHOICES["V-sector-w8"]


def a_quadruped_that_loses_a_leg() -> Case:
    """Four legs at other phases, tilted; the plate grows heavier to turn, and then a leg is cut."""
    changes = {
        "pitch_inertia_ratio": Step(1.4, from_s=1.0),
        "present": Step(np.array([[1.0], [1.0], [1.0], [0.0]]), from_s=2.0),
    }
    phases = np.array([[0.0], [1.0], [2.5], [4.0]])
    initial_pose = {"pitch_rad": 0.05}
    return Case(
        dataclasses.replace(VANILLA.controller, limbs=4),
        VANILLA.weights,
        STANDARD["quadruped"],
        Scenario(omega=8.0, phase_rad=phases, initial_pose=initial_pose, changes=changes),
        ((1.0, "body.pitch_inertia_ratio", 1.4), (2.0, "body.present", [1.0, 1.0, 1.0, 0.0])),
        4.0,
    )


@needs_node
@pytest.mark.parametrize("case", [all_that_can_happen, a_quadruped_that_loses_a_leg])
def test_the_engine_of_a_page_moves_as_the_package_does_whatever_happens(case, tmp_path):
    run = case()
    expected = run.by_the_package()
    assert np.ptp(expected["height_m"]) > 0.2
    assert_same(played_in_node(run, tmp_path), expected)


@needs_node
def test_a_frozen_oscillator_is_a_clamped_one(tmp_path):
    still = Case(
        VANILLA.controller,
        VANILLA.weights,
        Hopper(),
        Scenario(omega=8.0, phase_rad=1.0),
        duration_s=3.0,
        given={"moving": 0.0},
    )
    clamped = dataclasses.replace(VANILLA.controller, oscillator=Clamped(PhaseOscillator()))
    result = played_in_node(still, tmp_path)
    assert_same(result, still.by_the_package(clamped))
    assert np.ptp(result["phase_rad"]) == 0.0


@needs_node
@needs_compiler
def test_a_term_of_ones_own_is_compiled_and_does_what_it_does_in_the_package(tmp_path):
    for part in (my_parts.DriftingPhase, my_parts.HarmonicAction):
        tegotae.register(part)
    controller = Controller(
        Reflex(),
        my_parts.DriftingPhase(),
        Tegotae(my_parts.HarmonicAction(), VanillaReaction(), ConstantGain()),
    )
    assert not shelf.has(controller, Hopper())
    weights = np.asarray(controller.initial(jax.random.key(1)))
    run = Case(controller, weights, Hopper(), Scenario(omega=8.0), duration_s=4.0)
    assert_same(played_in_node(run, tmp_path), run.by_the_package())


@needs_compiler
@pytest.mark.parametrize("name", ["V-sector-w8", "ART-rF-tphif-w8"])
def test_engines_that_come_with_the_package_are_those_of_its_present_code(name):
    stored = shelf.cached_engine(CHOICES[name].controller, Hopper())
    if stored.made_by != shelf.makers():
        pytest.skip(f"the engines were made by {stored.made_by}, and here is {shelf.makers()}")
    compiled = shelf.compile_engine(CHOICES[name].controller, Hopper())
    assert stored.layout == compiled.layout
    is_equal = gzip.decompress(stored.wasm) == gzip.decompress(compiled.wasm)
    assert is_equal, "run python -m apps.playground.make"


@pytest.mark.parametrize("name", ["V-sector-w8", "ART-rF-tphif-w8"])
def test_engines_that_come_with_the_package_are_of_the_c_that_it_writes_now(name):
    heavier = Hopper(mass_kg=0.2)
    assert shelf.is_present(CHOICES[name].controller, heavier), "run python -m apps.playground.make"


def test_every_standard_controller_has_an_engine_for_every_standard_body():
    for choice in standard():
        for body in STANDARD.values():
            fitted = dataclasses.replace(choice.saved.controller, limbs=body.limbs)
            assert shelf.has(fitted, body)


def test_every_number_that_the_page_names_is_in_an_engine():
    folder = ROOT / "apps" / "playground"
    scripts = "".join(path.read_text() for path in (folder / "web").rglob("*.js"))
    engines = [json.loads(path.read_text()) for path in (folder / "engines").glob("*.json")]
    known = {name for engine in engines for name in engine["layout"]}
    assert {*re.findall(r'"((?:body|release|channel|state)\.[\w.]*\w)"', scripts)} <= known


HEARD_CHANNELS = (
    *("time_s", "apex_time_s", "apex_height_m", "ground_m"),
    *("climb_flight_m", "work_absolute_j"),
)
JUDGED = """
const { Engine } = await web("engine.js");
const { episode } = await web("learn/fitness.js");
const lane = (await Engine.of(Buffer.from(data.wasm, "base64"), data.layout)).lane();
for (const [name, value] of Object.entries(data.given)) lane.set(name, value);
const result = data.weights.map((weights) => {
  lane.set("weights", weights);
  return episode(lane, data.timing, data.definitions);
});
"""


@needs_node
def test_an_episode_is_worth_in_the_page_what_it_is_worth_in_the_package(tmp_path):
    controller = VANILLA.controller
    weights = np.array([[1.0], [2.0], [0.0], [3.0], [-1.0]], "float32")
    rollout = Rollout(controller=controller, timing=EPISODE, summary=Fitness())
    expected = rollout.run(weights, Scenario(omega=8.0))
    data = {
        **wasm_of(shelf.cached_engine(controller, Hopper())),
        "given": Case(controller, [1.0], Hopper(), Scenario(omega=8.0)).task()["given"],
        "weights": weights.tolist(),
        "timing": {**dataclasses.asdict(EPISODE), "settle_s": SETTLE_S},
        "definitions": {**DEFINITIONS, "follow_omega": True},
    }
    outcomes = in_node(JUDGED, data, tmp_path)
    assert expected["cot_inverse"].max() > 0.3
    for name, key in (("cot_inverse", "cotInverse"), ("fitness", "fitness")):
        np.testing.assert_allclose(
            [outcome[key] for outcome in outcomes], expected[name], atol=5e-3
        )
    assert [outcome["failed"] for outcome in outcomes] == expected["failed"].tolist()


HEARD = """
const { Hops } = await web("measures.js");
const hops = new Hops(data.definitions);
const result = data.frames.map((frame) => {
  hops.hear({ get: (name) => frame[name] });
  return hops.cost();
});
"""


@needs_node
def test_the_cost_that_a_page_shows_is_over_whole_hops_and_none_of_a_gait_that_is_over(tmp_path):
    rollout = Rollout(controller=VANILLA.controller, timing=Timing(duration_s=10.0, tick_s=0.002))
    t = jax.tree.map(lambda x: x[:, 0], rollout.run([1.0], Scenario(omega=8.0)))
    # JSON has no NaN: no apex is one far below.
    columns = {f"channel.{name}": np.nan_to_num(getattr(t, name), nan=-1.0).astype(float)
            for name in HEARD_CHANNELS}  # fmt: skip
    frames = [dict(zip(columns, row, strict=True), **{"body.rest_length_m": 1.0})
              for row in np.array(list(columns.values())).T.tolist()]  # fmt: skip
    still = [dict(frames[-1], **{"channel.time_s": time_s, "channel.apex_height_m": -1.0})
             for time_s in (12.0, 13.5)]  # fmt: skip
    data = {"definitions": DEFINITIONS, "frames": [*frames, *still]}
    *costs, soon, late = in_node(HEARD, data, tmp_path)
    first = np.flatnonzero(t.apex_height_m >= 1.01)[-9]
    eight = whole_hops(t.apex_height_m[first:], t.ground_m[first:], 1.0)
    climb, work = (eight.over(x[first:]) for x in (t.climb_flight_m, t.work_absolute_j))
    assert int(eight.n_hops) == 8
    assert costs[-1] == soon == pytest.approx(float(climb / work), rel=1e-5)
    assert late == 0


@needs_node
def test_a_search_moves_in_the_page_as_in_the_package(tmp_path):
    settings = PGPE(population=6, std=0.2, std_lr=0.24, learning_rate=0.379, max_speed=0.676)
    strategy, parameters = settings.strategy(3), settings.parameters(3)
    state = settings.start(jax.random.key(0), jnp.array([0.5, -0.2, 0.1]))
    tell = jax.jit(strategy.tell)
    rounds, means, stds = [], [], []
    for generation in range(4):
        noise = np.random.default_rng(generation).normal(size=(3, 3)) * np.asarray(state.std)
        samples = np.float32(np.asarray(state.mean) + np.concatenate([noise, -noise]))
        fitness = -np.sum((samples - 1.0) ** 2, axis=1).round(1)  # some of them alike
        rounds.append({"samples": samples.tolist(), "fitness": fitness.tolist()})
        state, _ = tell(jax.random.key(9), samples, -fitness, state, parameters)
        means.append(np.asarray(state.mean))
        stds.append(np.asarray(state.std))
    script = """
    const { Search } = await web("learn/pgpe.js");
    const search = new Search(data.start, data.settings);
    const result = data.rounds.map(({ samples, fitness }) => {
      search.tell(samples, fitness);
      return [Array.from(search.mean), Array.from(search.std)];
    });
    """
    start = {"start": [0.5, -0.2, 0.1], "settings": dataclasses.asdict(settings), "rounds": rounds}
    moments = np.array(in_node(script, start, tmp_path))
    np.testing.assert_allclose(moments[:, 0], means, atol=1e-5)
    np.testing.assert_allclose(moments[:, 1], stds, atol=1e-5)
    assert np.abs(means[-1] - means[0]).max() > 0.1


@needs_node
def test_a_gait_is_learned_from_random_weights_by_the_pages_own_learner(tmp_path):
    page = Page([ControllerChoice("ART", ART)]).document()
    (controller,) = page["controllers"]
    task = {
        **wasm_of(shelf.cached_engine(ART.controller, Hopper())),
        "given": Case(ART.controller, ART.weights, Hopper(), Scenario(omega=8.0)).task()["given"],
        "weights": controller["starts"][0],
        "settings": page["learning"]["settings"],
        "timing": {"duration_s": 8.0, "tick_s": 0.002, "frame_s": 0.02, "settle_s": 4.0},
        "definitions": {**DEFINITIONS, "follow_omega": False},
        "seed": 1,
        "generations": 12,
    }
    script = """
    const { learn } = await web("learn/worker.js");
    const result = [];
    const task = { ...data, wasm: Buffer.from(data.wasm, "base64") };
    await learn(task, (told) => result.push(told));
    """
    reports = in_node(script, task, tmp_path)
    assert [report["generation"] for report in reports] == list(range(12))
    best = [report["best"]["fitness"] for report in reports]
    assert best == sorted(best)
    assert best[-1] > best[0] + 0.1
    assert len(reports[-1]["best"]["weights"]) == ART.controller.n_weights


def test_a_page_is_one_file_that_needs_nothing_else():
    html = Page([ControllerChoice("V", VANILLA)]).html()
    assert "<!--" not in html
    assert not [word for word in ("http://", "https://", "src=", "import(") if word in html]
    assert len(html.encode()) < 400_000


@pytest.mark.parametrize(
    "name", ["<!--WORKER-->.json", "<!--<script>.json", "</script>.json", "a\u2028&lt;.json"]
)
def test_no_name_of_a_file_is_taken_for_a_part_of_the_page(name):
    html = Page([ControllerChoice(name, VANILLA)]).html()
    plain = Page([ControllerChoice("V", VANILLA)]).html()
    assert data_of(html)["controllers"][0]["label"] == name
    for tag in ("<!--", "<script", "</script"):
        assert html.count(tag) == plain.count(tag)


def test_modules_are_joined_each_once_after_what_they_import():
    order = modules("main.js")
    assert order[-1] == "main.js"
    assert len(order) == len(set(order))
    assert order.index("engine.js") < order.index("learner.js") < order.index("main.js")
    script = bundle_scripts("main.js")
    assert "\nimport " not in script
    assert "\nexport " not in script


def test_no_two_modules_of_a_script_give_a_name_away_twice():
    for entry in ("main.js", "learn/worker.js"):
        names = [
            name
            for module in modules(entry)
            for name in re.findall(
                r"^(?:export )?(?:async )?(?:function|class|const|let) (\w+)",
                read_source(module),
                re.M,
            )
        ]
        assert sorted(names) == sorted(set(names))


def saved_at(path, controller=None, body=None, omega=8.0):
    controller = recipe("V-sector-w8").controller() if controller is None else controller
    weights = np.full(controller.n_weights, 1.0)
    save(SavedController.from_weights(controller, weights, omega, body or Hopper()), path)
    return path


def test_a_controller_of_ones_own_comes_first_with_its_bodys_numbers(tmp_path, capsys):
    path = saved_at(tmp_path / "mine.json", body=Hopper(mass_kg=0.2))
    page = tmp_path / "page.html"
    assert main(["playground", str(path), "--out", str(page)]) == 0
    assert str(page) in capsys.readouterr().out
    data = data_of(page.read_text(encoding="utf-8"))
    assert [entry["label"] for entry in data["controllers"]] == ["mine", "V: nothing learned"]
    assert data["bodies"][0]["numbers"]["mass_kg"] == 0.2
    assert set(data["controllers"][0]["engines"]) == set(STANDARD)


def data_of(html: str) -> dict:
    """Return the data that the scripts of a page read."""
    text = html.split('id="data">')[1].split("</script>")[0]
    return json.loads(text.replace("<\\/", "</"))


def test_a_controller_for_several_legs_is_offered_on_its_own_body_alone():
    body = Plate(pitch_inertia_ratio=1.6)
    legs = dataclasses.replace(VANILLA.controller, limbs=4)
    four = SavedController.from_weights(legs, VANILLA.weights, 8.0, body)
    data = data_of(Page([ControllerChoice("four", four), ControllerChoice("V", VANILLA)]).html())
    first, vanilla = data["controllers"]
    assert list(first["engines"]) == ["quadruped"]
    assert first["engines"]["quadruped"] == vanilla["engines"]["quadruped"]
    assert first["starts"] == []
    (quadruped,) = (entry for entry in data["bodies"] if entry["name"] == "quadruped")
    assert quadruped["numbers"]["pitch_inertia_ratio"] == 1.6
    assert quadruped["legs"] == ["LF", "RF", "LH", "RH"]


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        saved_at(tmp_path / folder / "mine.json")
    paths = [str(tmp_path / folder / "mine.json") for folder in ("a", "b")]
    page = tmp_path / "page.html"
    assert main(["playground", *paths, "--out", str(page)]) == 0
    data = data_of(page.read_text(encoding="utf-8"))
    assert [entry["label"] for entry in data["controllers"]] == [*paths, "V: nothing learned"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{}", "not a controller file"),
        ("no JSON", "not a controller file"),
        (None, "no controller"),
    ],
)
def test_what_is_no_controller_is_refused_in_one_line_before_anything_is_written(
    text, message, tmp_path, capsys
):
    path = tmp_path / "other.json"
    if text is not None:
        path.write_text(text)
    page = tmp_path / "page.html"
    assert main(["playground", str(path), "--out", str(page)]) == 2
    error = capsys.readouterr().err.strip()
    assert message in error
    assert "\n" not in error
    assert not page.exists()


def test_a_file_that_cannot_be_written_is_told_before_the_page_is_made(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["playground", "--out", str(tmp_path / "file" / "page.html")]) == 2
    assert "cannot write" in capsys.readouterr().err


def test_a_page_of_another_ending_which_no_browser_shows_is_refused(tmp_path, capsys):
    assert main(["playground", "--out", str(tmp_path / "page.txt")]) == 2
    assert "its name ends in .html" in capsys.readouterr().err


def test_without_a_compiler_one_line_says_what_to_install(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(compiler, "has_compiler", lambda: False)
    path = saved_at(tmp_path / "mine.json", recipe("V-reflex-w8").controller())
    assert main(["playground", str(path), "--out", str(tmp_path / "page.html")]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert "mine: no engine comes with the package" in error
    assert "pip install 'tegotae[playground]'" in error


def test_a_body_that_a_page_cannot_draw_is_refused_by_its_name():
    from tegotae.parts.terms.foot import EllipticFoot

    feet = Controller(EllipticFoot(), PhaseOscillator(), VANILLA.controller.tegotae, limbs=4)
    walking = SavedController.from_weights(feet, np.ones(1), 2.0, Walker())
    on_spheres = SavedController.from_weights(VANILLA.controller, VANILLA.weights, 4.0, Hertz())
    for saved, name in ((walking, "Walker"), (on_spheres, "Hertz")):
        with pytest.raises(TegotaeError, match=f"cannot draw a {name}"):
            Page([ControllerChoice("walk", saved)])


def test_a_page_without_controllers_is_refused():
    refused("no controllers were given", Page, [])
