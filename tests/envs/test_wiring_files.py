"""Wirings as files, with scales from the model, and from a controller's file."""

import dataclasses
import json
import math
import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from refusals import refused  # noqa: E402
from tegotae import Hopper, TegotaeError  # noqa: E402
from tegotae.envs import (  # noqa: E402
    Limb,
    TegotaeWrapper,
    Wiring,
    WiringWarning,
    check_wiring,
    load_wiring,
    model_scales,
    save_wiring,
)
from tegotae.envs.contact import contact_names  # noqa: E402
from tegotae.envs.wires import remarks  # noqa: E402
from tegotae.systems import controller_file  # noqa: E402
from tegotae.systems.controller_file import SavedController  # noqa: E402
from tegotae.systems.recipe import recipe  # noqa: E402
from tegotae.systems.resolve import resolve  # noqa: E402
from wired_env import Scales  # noqa: E402

WIRING = Wiring(
    limbs=(
        Limb(senses={"spring_force": "load", "velocity": "-height"}, drives="action[0]", rest=0.0),
    ),
    scales={"spring_force": 2.5, "velocity": 0.1, "feedback": 3.0},
    max_force=3.0,
    step_s=0.02,
    height="height",
    work="work",
    rest_length_m=1.0,
)


@pytest.mark.parametrize("name", ["leg.toml", "leg.json"])
def test_a_wiring_that_is_written_is_read_back(tmp_path, name):
    save_wiring(WIRING, tmp_path / name)
    assert load_wiring(tmp_path / name) == WIRING


@pytest.mark.parametrize("name", ["hopper", "leg", "quadruped"])
def test_wirings_of_the_packages_models_can_be_read_written_and_fit(tmp_path, name):
    pytest.importorskip("mujoco")
    from tegotae.envs.mujoco.env import ModelEnv

    wiring = load_wiring(name)
    save_wiring(wiring, tmp_path / "again.toml")
    assert load_wiring(tmp_path / "again.toml") == wiring
    if name == "quadruped":
        from tegotae.systems.vanilla import legged_named

        wiring = wiring.reading(legged_named("quadruped-a").controller)
    else:
        wiring = wiring.reading(recipe("V-sector-w8").controller())
    assert check_wiring(ModelEnv(model=name), wiring, steps=0) == []


TOML = 'format = "tegotae wiring"\n[[limbs]]\ndrives = "action[0]"\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TOML, r"it has no entry 'limbs\[0\]\.senses'"),
        (TOML + 'senses = "load"', r"its limbs\[0\]\.senses is 'load'; it must be an object"),
        (TOML + "[limbs.senses]\nspring_force = 3", "must be a text"),
        (TOML.replace("wiring", "walking") + "senses = {}", "its format is 'tegotae walking'"),
        ("max_force = 4.0", "it has no entry 'limbs'"),
        ("limbs = [", "it is no TOML"),
        ("limbs = []\nspeed = 3", "speed"),
        ("limbs = []\nomega = nan", "its omega is nan; it must be above 0"),
        ('limbs = []\nscales = {spring_force = "heavy"}', "must be a number"),
    ],
)
def test_a_file_that_is_no_wiring_is_refused_in_one_line(tmp_path, text, said):
    path = tmp_path / "leg.toml"
    path.write_text(text)
    with pytest.raises(TegotaeError, match=said) as raised:
        load_wiring(path)
    assert str(raised.value).startswith(f"{path} is no wiring: ")
    assert "\n" not in str(raised.value)


def test_a_file_that_is_not_there_or_of_another_kind_is_refused(tmp_path):
    refused("No such file", load_wiring, tmp_path / "leg.toml")
    refused(r"must end in \.toml or \.json", load_wiring, tmp_path / "leg.yaml")
    refused("no wiring is called 'legs'; did you mean leg", load_wiring, "legs")
    refused(r"must end in \.toml or \.json", save_wiring, WIRING, tmp_path / "leg.yaml")


def saved_hopper(path, model: str = "AR-rF-sector-w8"):
    controller = recipe(model).controller()
    weights = np.random.default_rng(0).normal(size=controller.n_weights)
    controller_file.save(
        SavedController.from_weights(controller, weights, 8.0, Hopper(max_force_n=3.5)), path
    )
    return controller, weights


def test_a_hoppers_controller_is_wired_by_a_file_of_limbs(tmp_path):
    controller, weights = saved_hopper(tmp_path / "hopper.json")
    save_wiring(WIRING, tmp_path / "leg.toml")
    wiring = Wiring.from_controller(tmp_path / "hopper.json", tmp_path / "leg.toml")
    assert (wiring.controller, wiring.omega, wiring.max_force) == (controller, 8.0, 3.5)
    np.testing.assert_array_equal(wiring.weights, weights)
    # What this controller does not read is left out.
    assert wiring.limbs[0].senses == {"spring_force": "load"}
    assert check_wiring(Scales(), wiring, steps=0) == []
    second = Wiring.from_controller(tmp_path / "hopper.json", WIRING, omega=6.0)
    assert second.omega == 6.0


def test_a_controller_goes_on_seeing_what_it_senses_over_the_scales_it_was_trained_with(tmp_path):
    saved_hopper(tmp_path / "hopper.json", "AR-rFv-sector-w8")
    bare = dataclasses.replace(WIRING, scales={"velocity": 9.0})
    wiring = Wiring.from_controller(tmp_path / "hopper.json", bare)
    assert wiring.scales["velocity"] == 9.0  # what the wiring gives stands
    assert wiring.scales["spring_force"] == pytest.approx(0.1 * 9.81)
    assert wiring.scales["feedback"] == pytest.approx(math.sqrt(9.81))
    assert remarks(wiring) == []


def test_only_what_an_environment_calls_a_contact_force_is_told_as_one():
    pytest.importorskip("mujoco")
    from tegotae.envs.mujoco.env import ModelEnv

    env = ModelEnv(model="leg")
    assert contact_names(env) == ("foot_force",)
    assert contact_names(Scales()) == ()
    limb = load_wiring("leg").limbs[0]
    spring = dataclasses.replace(limb, senses={"spring_force": "knee_force"})
    basis = dataclasses.replace(load_wiring("leg"), weights=[1.0], omega=8.0)
    for felt, message in ((limb, 1), (spring, 0)):
        wiring = dataclasses.replace(basis, limbs=[felt]).reading(
            recipe("V-sector-w8").controller()
        )
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            TegotaeWrapper(env, wiring)
        assert len([entry for entry in caught if "contact force" in str(entry.message)]) == message
    env.close()


def test_a_frequency_is_kept_with_its_wiring(tmp_path):
    for name in ("leg.toml", "leg.json"):
        save_wiring(dataclasses.replace(WIRING, omega=9.0), tmp_path / name)
        assert load_wiring(tmp_path / name).omega == 9.0


@pytest.mark.parametrize("omega", [math.nan, -4.0, 0.0])
def test_a_frequency_that_is_none_is_told(omega):
    wiring = dataclasses.replace(WIRING.reading(recipe("V-sector-w8").controller()), omega=omega)
    (problem,) = check_wiring(Scales(), wiring, steps=0)
    assert problem.startswith("omega is ")


def test_a_wiring_file_may_name_its_controller(tmp_path):
    saved_hopper(tmp_path / "hopper.json")
    save_wiring(WIRING, tmp_path / "leg.json")
    document = json.loads((tmp_path / "leg.json").read_text())
    (tmp_path / "leg.json").write_text(json.dumps({**document, "controller": "hopper.json"}))
    assert load_wiring(tmp_path / "leg.json").omega == 8.0


@pytest.mark.parametrize("name", ["paper", "runs", "my_kept.py:kept"])
def test_a_wiring_file_names_its_controller_as_a_command_does(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    saved_hopper(tmp_path / "runs" / "mine.json")
    (tmp_path / "my_kept.py").write_text(
        "from tegotae.systems.controller_file import load\nkept = load('runs/mine.json')\n"
    )
    save_wiring(WIRING, tmp_path / "leg.json")
    document = json.loads((tmp_path / "leg.json").read_text())
    (tmp_path / "leg.json").write_text(json.dumps({**document, "controller": name}))
    meant = resolve(name).controller()  # which names the code that a wiring may refer to
    result = load_wiring(tmp_path / "leg.json")
    assert result.omega == meant.omega
    assert result.weights is not None
    (tmp_path / "leg.json").write_text(json.dumps({**document, "controller": "none.json"}))
    refused(r"no controller file at .*none\.json", load_wiring, tmp_path / "leg.json")


def test_a_hoppers_controller_without_a_wiring_is_refused(tmp_path):
    saved_hopper(tmp_path / "hopper.json")
    with pytest.raises(TegotaeError, match=r"was not trained on an environment.*; give a wiring"):
        Wiring.from_controller(tmp_path / "hopper.json")


def test_a_wiring_without_weights_lacks_nothing_but_cannot_drive():
    wiring = WIRING.reading(recipe("V-sector-w8").controller())
    assert check_wiring(Scales(), wiring, steps=20) == []
    refused("has no weights; train it", lambda: TegotaeWrapper(Scales(), wiring))
    with pytest.raises(TegotaeError, match="has weights but no frequency"):
        TegotaeWrapper(Scales(), dataclasses.replace(wiring, weights=[1.0]))


def test_scales_are_those_of_the_model():
    pytest.importorskip("mujoco")
    from tegotae.envs.mujoco.env import ModelEnv

    scales = model_scales(ModelEnv(model="hopper"), feet=["foot"])
    assert scales["spring_force"] == pytest.approx(0.1 * 9.81)
    assert scales["velocity"] == pytest.approx(math.sqrt(9.81), rel=2e-3)
    assert scales["feedback"] == pytest.approx(math.sqrt(9.81), rel=2e-3)
    refused("did you mean foot", lambda: model_scales(ModelEnv(model="hopper"), feet=["feet"]))
    refused("no MuJoCo model to take scales from", lambda: model_scales(Scales()))
    basis = load_wiring("hopper")
    original = dataclasses.replace(basis, scales={"velocity": 9.0}).with_scales(
        ModelEnv(model="hopper")
    )
    # What is given stands, and the packaged wiring's numbers are the model's.
    assert original.scales["velocity"] == 9.0
    for name, scale in basis.scales.items():
        assert scales[name] == pytest.approx(scale, rel=2e-3)


def test_a_scale_whose_name_has_a_slip_is_told_and_not_passed_over():
    pytest.importorskip("mujoco")
    from tegotae.envs.mujoco.env import ModelEnv

    scales = {"spring_force": 2.5, "velocty": 0.1, "pressure": 1.0}
    slip = dataclasses.replace(
        WIRING.reading(recipe("AR-rFv-sector-w8").controller()), scales=scales
    )
    message = "no signal is called 'velocty'; did you mean velocity?"
    assert [problem for problem in check_wiring(Scales(), slip, steps=0) if message in problem]
    with pytest.raises(TegotaeError, match="did you mean velocity"):
        dataclasses.replace(load_wiring("hopper"), scales=scales).with_scales(
            ModelEnv(model="hopper")
        )


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ({"push": math.nan}, "limb 0: push is nan; it must be finite"),
        ({"rest": math.inf}, "limb 0: rest is inf; it must be finite"),
    ],
)
def test_an_end_of_a_push_that_is_no_number_is_told(ends, said):
    wiring = WIRING.reading(recipe("V-sector-w8").controller())
    limb = dataclasses.replace(wiring.limbs[0], **ends)
    assert check_wiring(Scales(), dataclasses.replace(wiring, limbs=[limb]), steps=0) == [said]


@pytest.mark.parametrize("width_rad", [0.0, -1.0, 9.0, math.nan])
def test_a_sector_is_at_most_a_turn_wide(width_rad):
    refused("the width in sector_rad is", dataclasses.replace, WIRING, sector_rad=[0.0, width_rad])


def test_what_a_wiring_leaves_to_chance_is_told():
    learned = dataclasses.replace(
        WIRING.reading(recipe("AR-rFv-sector-w8").controller()), scales={"velocity": 1.0}
    )
    assert [remark[:38] for remark in remarks(learned)] == [
        "no scale is given for spring_force: ne"
    ]
    foot = Limb(senses={"spring_force": "foot_force"}, drives="action[0]")
    on_the_foot = dataclasses.replace(WIRING, limbs=[foot])
    (remark,) = remarks(on_the_foot, ["foot_force"])
    assert "stands in for F_k" in remark
    assert remarks(on_the_foot, ["toe_force"]) == []  # a spring's, whatever its name
    assert remarks(WIRING) == []
    wiring = dataclasses.replace(learned, weights=np.zeros(learned.controller.n_weights), omega=8.0)
    with pytest.warns(WiringWarning, match="no scale is given for spring_force"):
        TegotaeWrapper(Scales(), wiring)
    with warnings.catch_warnings():
        warnings.simplefilter("error", WiringWarning)
        TegotaeWrapper(Scales(), dataclasses.replace(wiring, scales=WIRING.scales))


def test_units_of_one_controller_may_share_weights_as_it_says():
    limbs = [dataclasses.replace(WIRING.limbs[0], senses={"spring_force": "load"})]
    shared = dataclasses.replace(recipe("V-sector-w8").controller(), limbs=2)
    wiring = Wiring(limbs=limbs, weights=[1.0], omega=5.0, controller=shared)
    assert check_wiring(Scales(), wiring, steps=0) == []
    free = dataclasses.replace(shared, sharing=(0, 1))
    wiring = dataclasses.replace(wiring, weights=[1.0, 1.0], controller=free)
    (problem,) = check_wiring(Scales(), wiring, steps=0)
    assert "the controller has 2 units and the wiring 1 limbs" in problem
