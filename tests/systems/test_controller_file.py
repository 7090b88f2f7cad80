"""A controller file is read back as it was written, or refused in one line."""

import copy
import dataclasses
import json
import math
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from controller_files import example, text
from places import TESTS
from refusals import refused
from tegotae import TegotaeError, Timing
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.objectives.walking import Walking
from tegotae.parts.bodies import Bar, Interface, Walker
from tegotae.parts.couplings import LearnedCoupling
from tegotae.parts.fields import replace
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.simulation.integrators import Hold
from tegotae.simulation.world import Uniform
from tegotae.systems.controller_file import SavedController, load, save
from tegotae.systems.recipe import recipe, study_recipes
from tegotae.systems.system import Release


def assert_same(first: SavedController, second: SavedController) -> None:
    np.testing.assert_array_equal(np.asarray(first.weights, "float64"), second.weights)
    for field in dataclasses.fields(SavedController):
        if field.name != "weights":
            assert getattr(first, field.name) == getattr(second, field.name), field.name


# Written and read.


def test_every_model_is_read_back_as_it_was_written(tmp_path):
    for name in study_recipes():
        saved = example(name)
        save(saved, tmp_path / "controller.json")
        assert_same(saved, load(tmp_path / "controller.json"))


def test_what_no_model_of_the_study_has_is_read_back_too(tmp_path):
    saved = example()
    assert saved.controller.tegotae is not None
    limited = dataclasses.replace(saved.controller.tegotae, limit_rad_per_s=4.0)
    floored = PhaseOscillator(slowest_rad_per_s=0.5)
    controller = dataclasses.replace(saved.controller, oscillator=floored, tegotae=limited)
    saved = dataclasses.replace(replace(saved, {"controller": controller}), name=None)
    save(saved, tmp_path / "controller.json")
    assert_same(saved, load(tmp_path / "controller.json"))


def test_weights_of_double_precision_lose_no_digit(tmp_path):
    saved = dataclasses.replace(
        example("V-sector-w4"), weights=np.array([math.nextafter(2.753, 3.0)])
    )
    save(saved, tmp_path / "controller.json")
    assert load(tmp_path / "controller.json").weights[0] == saved.weights[0]


def test_the_file_is_plain_json_that_says_what_it_is(tmp_path):
    save(example(), tmp_path / "controller.json")
    document = json.loads((tmp_path / "controller.json").read_text())
    assert (document["format"], document["version"]) == ("tegotae controller", 4)
    assert document["name"] == "ART-rFv-tphif-w8"
    assert document["system"]["omega"] == 8.0
    assert document["system"]["body"]["mass_kg"] == 0.2
    assert document["system"]["release"]["height_m"] == 1.2
    assert document["training"]["best_fitness"] == 1.25
    assert document["software"] == {"tegotae": "0.1.0"}
    neurons = document["weights"]["reaction"]["neuron"]
    assert list(neurons[0]) == ["spring_force", "velocity", "bias", "output"]


def test_weights_of_several_sets_and_a_coupling_come_back_in_their_order(tmp_path):
    controller = dataclasses.replace(
        recipe("V-reflex-w8").controller(), limbs=2, sharing=(0, 1), coupling=LearnedCoupling()
    )
    saved = SavedController.from_weights(controller, np.arange(6.0), 8.0, Bar())
    save(saved, tmp_path / "controller.json")
    document = json.loads((tmp_path / "controller.json").read_text())
    assert document["weights"] == {
        "set": [{"gain": {"sigma": 0.0}}, {"gain": {"sigma": 1.0}}],
        "coupling": {"pair": [{"a": 2.0, "b": 3.0}, {"a": 4.0, "b": 5.0}]},
    }
    assert_same(saved, load(tmp_path / "controller.json"))


def test_a_plain_list_of_weights_is_still_read(tmp_path):
    saved, path = example(), tmp_path / "controller.json"
    save(saved, path)
    document = json.loads(path.read_text())
    document.update(weights=saved.weights.tolist())
    path.write_text(json.dumps(document))
    assert_same(saved, load(path))


NAMED: dict[str, tuple[Callable[[dict], Any], str]] = {
    "one missing": (lambda w: w["gain"].pop("sigma"), r"its weights lack gain\.sigma$"),
    "one too many": (
        lambda w: w["gain"].update(tau=1.0),
        r"its weights have gain\.tau, which the controller has not$",
    ),
    "a text": (
        lambda w: w["action"]["neuron"][1].update(bias="1"),
        r"its weights\.action\.neuron\[1\]\.bias is '1'; it must be a number$",
    ),
}


@pytest.mark.parametrize("case", NAMED)
def test_weights_that_do_not_go_with_the_controller_are_refused_by_name(tmp_path, case):
    change, message = NAMED[case]
    save(example(), tmp_path / "controller.json")
    document = json.loads((tmp_path / "controller.json").read_text())
    change(document["weights"])
    (tmp_path / "controller.json").write_text(json.dumps(document))
    refused(message, load, tmp_path / "controller.json")


# Not to be written.


@pytest.mark.parametrize(
    ("weights", "message"),
    [([1.0, 2.0], "has 1 weights"), ([[1.0]], "has 1 weights"), ([math.inf], "1 weights are not")],
)
def test_weights_that_could_not_be_read_back_are_not_written(tmp_path, weights, message):
    saved = dataclasses.replace(example("V-sector-w4"), weights=np.array(weights))
    refused(message, save, saved, tmp_path / "controller.json")
    assert not list(tmp_path.iterdir())


# Kept.

KEPT = TESTS / "kept" / "controllers"
"""Files of trainings of the engine, a search, an agent and an environment."""


def test_a_kept_training_is_the_experiment_that_it_was():
    saved = load(KEPT / "hopper.json")
    trained = saved.experiment
    assert trained is not None
    assert (saved.name, trained.name) == ("ART-rF-tphif-w8", "ART-rF-tphif-w8")
    assert trained.system == saved.system
    assert saved.system.release == Release(height_m=1.3)
    assert saved.system.timing == Timing(duration_s=3.0, tick_s=0.004)
    assert saved.system.integrator == Hold()
    assert trained.objective == Fitness(settle_s=1.0)
    assert trained.protocol.release_m == 1.3
    assert saved.training["algorithm"]["name"] == "pgpe"


def test_a_kept_walker_has_its_release_conditions_and_timing():
    saved = load(KEPT / "quadruped.json")
    assert isinstance(saved.body, Walker)
    assert len(saved.system.release.phase_rad) == 4
    assert saved.system.timing.duration_s == 31.0
    assert saved.experiment is not None
    assert saved.experiment.conditions == (Uniform("mass_kg", low=0.9, high=1.1),)
    assert isinstance(saved.experiment.objective, Walking)


def test_a_kept_agent_has_its_limit():
    agent = load(KEPT / "agent.json")
    assert agent.controller.tegotae is not None
    assert agent.controller.tegotae.limit_rad_per_s == 40.0
    assert agent.experiment is not None


def test_a_kept_training_on_an_environment_has_its_wiring():
    saved = load(KEPT / "environment.json")
    assert saved.experiment is None
    assert saved.task is not None
    assert (saved.task.env, saved.task.duration_s) == ("leg", 2.0)
    assert saved.task.objective == {"kind": "Hopping", "settle_s": 1.0, "follow_omega": True}
    assert [limb.drives for limb in saved.task.wiring.limbs] == ["knee", "hip"]
    assert saved.system.body == Interface(
        scales=(14.2,), limbs=2, max_force_n=4.0, rest_length_m=0.386, feedback_scale=5.2
    )
    with pytest.raises(TegotaeError, match="its body is not here"):
        _ = saved.body


@pytest.mark.parametrize("path", sorted(KEPT.glob("*.json")), ids=lambda path: path.stem)
def test_a_kept_file_is_written_again_to_the_letter(tmp_path, path):
    save(load(path), tmp_path / "controller.json")
    assert (tmp_path / "controller.json").read_text() == path.read_text()


# Not to be read.


def refusal(path) -> str:
    """Return the reason why a file is refused."""
    with pytest.raises(TegotaeError) as raised:
        load(path)
    assert "\n" not in str(raised.value)
    assert str(path) in str(raised.value)
    return str(raised.value)


def test_the_sound_file_is_sound(tmp_path):
    path = tmp_path / "controller.json"
    path.write_text(text())
    np.testing.assert_array_equal(load(path).weights, [0.5, -1.0, 2.0, 0.25, 3.0])


def test_a_file_cut_off_anywhere_is_refused(tmp_path):
    path = tmp_path / "controller.json"
    for length in range(len(text().rstrip())):
        path.write_text(text()[:length])
        message = refusal(path)
        if length > 200:
            assert message == f"{path} is damaged: it is cut short, or no JSON"


def control(document: dict) -> dict:
    return document["system"]["controller"]


def law(document: dict) -> dict:
    return control(document)["tegotae"]


def body(document: dict) -> dict:
    return document["system"]["body"]


CHANGES: dict[str, tuple[Callable[[dict], Any], str]] = {
    "an earlier version": (
        lambda d: d.update(version=3),
        "is of version 3; this program reads version 4$",
    ),
    "no version": (lambda d: d.pop("version"), "is of version None"),
    "of another program": (lambda d: d.update(format="other"), "is not a controller file"),
    "too few weights": (lambda d: d["weights"].pop(), "has 5 weights, not shape \\(4,\\)"),
    "no weights": (lambda d: d.update(weights=None), "its weights is None"),
    "a weight that is text": (
        lambda d: d["weights"].__setitem__(0, "1"),
        "its weights\\[0\\] is '1'; it must be a number",
    ),
    "a weight that is NaN": (lambda d: d["weights"].__setitem__(0, math.nan), "not finite"),
    "a weight beyond all floats": (lambda d: d["weights"].__setitem__(0, 10**400), "too large"),
    "no controller": (lambda d: d["system"].pop("controller"), "no entry 'controller'"),
    "a controller that is a list": (
        lambda d: d["system"].update(controller=[]),
        "its controller is \\[\\]",
    ),
    "half the feedback": (lambda d: law(d).pop("gain"), "no entry 'gain'"),
    "a term that is null": (lambda d: law(d).update(action=None), "its action is None"),
    "a term of no kind": (lambda d: law(d)["action"].pop("kind"), "no entry 'kind'"),
    "a term that nobody knows": (
        lambda d: law(d)["action"].update(kind="Magic"),
        r"needs your part Magic \(action\): add --parts FILE.py",
    ),
    "a body for a term": (
        lambda d: law(d).update(action=body(d)),
        "its action is a 'Hopper', which is no term",
    ),
    "half a neuron": (lambda d: law(d)["action"].update(hidden=1.5), "its hidden is 1.5"),
    "an input that nothing provides": (
        lambda d: law(d)["action"].update(inputs=["phase", "smell"]),
        "reads 'smell'",
    ),
    "a setting that no term has": (
        lambda d: law(d)["reaction"].update(colour=1),
        "a VanillaReaction has no 'colour'",
    ),
    "a limit that is negative": (
        lambda d: law(d).update(limit_rad_per_s=-1.0),
        "limit_rad_per_s is -1",
    ),
    "an infinite frequency": (
        lambda d: d["system"].update(omega=math.inf),
        "omega is inf; it must be finite",
    ),
    "a mass that is text": (lambda d: body(d).update(mass_kg="0.1"), "its mass_kg is '0.1'"),
    "a training that is null": (lambda d: d.update(training=None), "its training is None"),
    "no software": (lambda d: d.pop("software"), "no entry 'software'"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_file_with_a_wrong_entry_is_refused_with_what_is_wrong(tmp_path, change, one_line_error):
    alter, message = CHANGES[change]
    document = json.loads(text())
    alter(document)
    path = tmp_path / "controller.json"
    path.write_text(json.dumps(document))
    refused(message, load, path)
    assert refusal(path) in one_line_error("simulate", str(path))


BYTES = {
    "empty": b"",
    "binary": bytes(range(256)) * 4,
    "a pickle": pickle.dumps({"format": "tegotae controller", "version": 1}),
    "in another encoding": text().encode("utf-16"),
    "a list": b"[]",
    "nested too deep": b"[" * 100_000,
    "a table": b"generation,seed\n0,0\n",
}


@pytest.mark.parametrize("name", BYTES)
def test_what_is_no_controller_file_is_called_none(tmp_path, name, one_line_error):
    path = tmp_path / "controller.json"
    path.write_bytes(BYTES[name])
    assert refusal(path) == f"{path} is not a controller file of tegotae"
    assert refusal(path) in one_line_error("simulate", str(path))


def test_a_missing_file_is_called_missing(tmp_path, one_line_error):
    path = tmp_path / "controller.json"
    assert refusal(path) == f"no controller file at {path}"
    assert refusal(path) in one_line_error("simulate", str(path))


def test_what_cannot_be_read_is_refused(tmp_path, one_line_error):
    (tmp_path / "file").touch()
    for path in (tmp_path, tmp_path / "file" / "controller.json"):
        assert refusal(path).startswith(f"cannot read {path}: ")
    assert refusal(path) in one_line_error("simulate", str(path))
    message = f"{tmp_path} holds no controller files"
    assert message in one_line_error("simulate", str(tmp_path))


def places(value: Any, path: tuple = ()) -> Iterator[tuple]:
    """Yield the paths of a document at which something could be wrong."""
    yield path
    if isinstance(value, (dict, list)):
        for key, entry in value.items() if isinstance(value, dict) else enumerate(value):
            yield from places(entry, (*path, key))


JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["Network", "Sector", "Hopper", "phase", 10**400]),
    lambda children: (
        st.lists(children, max_size=3)
        | st.dictionaries(st.sampled_from(["kind", "inputs", "hidden", "x"]), children, max_size=3)
    ),
    max_leaves=5,
)


@given(st.sampled_from(list(places(json.loads(text())))), JSON)
def test_whatever_stands_in_a_file_it_is_read_or_refused_in_one_line(tmp_path_factory, keys, value):
    document = {"": copy.deepcopy(json.loads(text()))}
    inside: Any = document
    for key in ("", *keys)[:-1]:
        inside = inside[key]
    inside[("", *keys)[-1]] = value
    path = tmp_path_factory.mktemp("any") / "controller.json"
    path.write_text(json.dumps(document[""]))
    try:
        saved = load(path)
    except TegotaeError:
        assert refusal(path)
    else:
        assert np.isfinite(saved.weights).all()
