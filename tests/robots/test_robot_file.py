"""A robot is a file: written with a first wiring, read, trained upon, and refused with a line."""

import re
import shutil
from pathlib import Path

import pytest

from places import ROOT
from programs import main
from tegotae.systems.env_documents import is_robot_file
from tegotae.systems.resolve import law_on_robot, resolve

pytest.importorskip("mujoco")
from refusals import refused
from tegotae.envs import load_wiring
from tegotae.envs.mujoco.settings import model_files
from tegotae.envs.robot_file import load_robot

FEET = ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
SHORT = ["--duration-s", "0.5", "--population", "4", "--generations", "2", "--seeds", "1"]


@pytest.fixture(scope="module")
def suggested(tmp_path_factory):
    """The folder of a robot whose joints are driven: its file, beside its model."""
    folder = tmp_path_factory.mktemp("robots")
    (folder / "leg.xml").write_text(model_files()["leg"], encoding="utf-8")
    words = ["--settings", "noise=0.01", 'start={"knee": -0.5}']
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert not main(["wiring", "suggest", "leg.xml", *words, "--out", "leg.toml"])
    return folder


@pytest.fixture
def leg(suggested, tmp_path, monkeypatch):
    """A copy of that file, in the folder `robots`."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(suggested, "robots"), "leg.toml")


@pytest.fixture(scope="module")
def legged(tmp_path_factory):
    """The file of a robot whose feet are commanded to places."""
    file = tmp_path_factory.mktemp("legged") / "dog.toml"
    model = str(ROOT / "src" / "tegotae_robots" / "examples" / "servo_quadruped.xml")
    words = ["--feet", *FEET, "--settings", "legs=true", "--out", str(file)]
    assert not main(["wiring", "suggest", model, *words])
    return file


def test_a_suggested_robot_has_model_settings_and_wiring_and_reads_back(leg):
    spec, wiring = load_robot(leg)
    settings = dict(spec.settings)
    assert spec.env == "robots/leg.xml"
    assert (settings["noise"], settings["start"], settings["feet"]) == (
        0.01,
        {"knee": -0.5},
        ["foot"],
    )
    assert dict(load_robot(leg, {"noise": 0.02})[0].settings) == {**settings, "noise": 0.02}
    assert wiring == load_wiring(leg)
    assert 'env = "leg.xml"' in leg.read_text(encoding="utf-8")
    assert is_robot_file(leg)
    assert not is_robot_file("a" * 5000 + ".toml")


def test_a_law_of_feet_is_refused_where_joints_are_driven(leg):
    refused(
        f"zoo:raibert commands feet, and the wiring of {leg} drives joints",
        lambda: resolve(f"zoo:raibert@{leg}"),
    )


def test_a_robot_is_found_beside_its_file_from_any_folder(leg, monkeypatch):
    monkeypatch.chdir("robots")
    assert load_robot("leg.toml")[0].env == "leg.xml"


def test_a_law_is_trained_on_a_robot_by_one_name_and_evaluated(leg, capsys):
    words = ["AR@robots/leg.toml", "--fitness", "return", "--budget", "12", *SHORT]
    assert not main(["train", *words, "--out", "runs"])
    (file,) = Path("runs").glob("*-seed0.json")
    task = resolve(str(file)).controller().task
    assert task is not None
    assert (task.env, task.settings["noise"]) == ("robots/leg.xml", 0.01)
    assert not main(["evaluate", str(file), "--starts", "1"])
    words = ["--frequencies", "17", "--duration-s", "0.5", "--fitness", "return"]
    assert not main(["wiring", "baseline", str(leg), *words, "--out", "vanilla"])
    assert "best: σ" in capsys.readouterr().out


def test_a_walkers_law_is_a_controller_on_a_robot_by_name_for_every_command(legged, tmp_path):
    name = f"quadruped-c@{legged}"
    assert law_on_robot(f"clock-b@{legged}") == ("clock-b@quadruped-c", str(legged))
    assert law_on_robot(f"zoo:AR@{legged}") == ("zoo:AR@quadruped-c", str(legged))
    saved = resolve(name).controller()
    assert saved.task is not None
    assert saved.system.body.limbs == 4
    target = str(tmp_path / "there.json")
    assert not main(["wiring", "transfer", name, "--out", target])
    assert resolve(target).controller().system == saved.system
    assert not main(["simulate", name, "--duration-s", "0.3"])
    assert not main(["export", "c", name, "--out", str(tmp_path / "c")])


def test_a_template_is_fitted_to_a_robot(legged, tmp_path):
    out = tmp_path / "walker.toml"
    assert not main(["fit-template", str(legged), "--out", str(out)])
    assert resolve(str(out)).legs().body.limbs == 4


@pytest.mark.parametrize("file", ["go1.toml", "go1-legs.toml", "dm-quadruped.toml"])
def test_robots_of_other_packages_are_files_of_the_examples(file):
    spec, wiring = load_robot(ROOT / "examples" / "wirings" / file)
    assert spec.is_model
    assert len(wiring.limbs) in (4, 8)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            r'sha256 = "\w+"',
            'sha256 = "0"',
            r'leg.xml has changed .* accept the model by sha256 = "',
        ),
        (r'env = "leg.xml"', 'env = "log.xml"', "there is no file log.xml"),
        (r'env = "leg.xml"', 'env = "evil.py:make"', "refers to code, 'evil.py:make'"),
        ("noise =", "nois =", "no setting of a MuJoCo model is called 'nois'; did you mean noise"),
        ("omega =", "omga =", "no entry is called 'omga'; did you mean omega"),
        ("sha256 =", "sha =", "no entry of model is called 'sha'; did you mean sha256"),
        ("push =", "pusch =", r"no entry of limbs\[0\] is called 'pusch'; did you mean push"),
        (r"limbs\]\]", "limbs]", "it is no TOML"),
    ],
)
def test_a_damaged_robot_is_refused_with_a_line_on_what_and_its_cure(leg, old, new, message):
    text = leg.read_text(encoding="utf-8")
    assert re.search(old, text)
    leg.write_text(re.sub(old, new, text, count=1), encoding="utf-8")
    refused(f"^(robots/)?leg.toml.*{message}", load_robot, leg)


def test_a_missing_foot_is_refused_before_a_training(leg, one_line_error):
    leg.write_text(
        leg.read_text(encoding="utf-8").replace('["foot"]', '["foto"]'), encoding="utf-8"
    )
    message = one_line_error("train", f"AR@{leg}", "--fitness", "return")
    assert "'foto'; did you mean foot" in message


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["simulate", "ROBOT"], "leg.toml is a robot, without a law; name one on it, such as ART@"),
        (
            ["evaluate", "AR@ROBOT"],
            "has weights to train .* tegotae train AR@robots/leg.toml --out",
        ),
        (["train", "ART", "--env", "ROBOT", "--wiring", "leg"], "has a wiring; leave --wiring out"),
        (["train", "ARTT@ROBOT"], "did you mean ART"),
    ],
)
def test_a_name_without_a_law_or_weights_is_refused(leg, one_line_error, words, message):
    text = one_line_error(*(word.replace("ROBOT", str(leg)) for word in words))
    assert re.search(message, text)
