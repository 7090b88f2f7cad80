"""A model suggests a wiring: the one that people wrote by hand, each entry with its reason."""

import dataclasses
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

from refusals import refused
from tegotae.cli import main
from tegotae.envs import check_wiring, load_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.env import ModelEnv
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import PACKAGED, ModelSettings, model_files
from tegotae_robots.models.suggesting import suggest_wiring

LEG = model_files()["leg"]
GEOM_FOOT = LEG.replace(
    '<geom type="sphere" size="0.018"', '<geom name="sole" type="sphere" size="0.018"'
)
UNSTABLE = LEG.replace("0.001", "0.03", 1).replace("implicitfast", "Euler").replace('"8"', '"8e7"')


def keyframe(number):
    """The leg with a keyframe of this number."""
    key = f'<keyframe><key qpos="0 {number} 0 0"/></keyframe>'
    return LEG.replace("</mujoco>", f"{key}</mujoco>")


@pytest.fixture(scope="module")
def leg():
    return suggest_wiring(ModelSettings(model="leg"))


@pytest.fixture
def model_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my_leg.xml").write_text(LEG)
    return Path("my_leg.xml")


def test_the_papers_hopper_gets_the_papers_numbers():
    wiring = suggest_wiring(PACKAGED["hopper"]).wiring
    by_hand = load_wiring("hopper")
    (limb,) = wiring.limbs
    assert (limb.drives, limb.senses["spring_force"]) == ("leg", "leg_spring")
    assert limb.push == pytest.approx(4.0, rel=0.05)
    assert wiring.omega == pytest.approx(8.0, rel=0.05)
    assert wiring.rest_length_m == pytest.approx(1.0, abs=0.01)
    assert {n: wiring.scales[n] for n in by_hand.scales} == pytest.approx(by_hand.scales, rel=0.01)


def test_of_a_leg_feet_joints_directions_and_rest_length_are_found(leg):
    wiring = leg.wiring
    assert wiring.contact_bodies == ("foot",)
    assert wiring.rest_length_m == pytest.approx(0.386, abs=0.002)
    pushes = {limb.drives: limb.push for limb in wiring.limbs}
    assert pushes.keys() == {"hip", "knee"}
    assert pushes["knee"] < 0.0 < pushes["hip"]  # stretches the leg, and goes forward
    assert all(limb.senses["spring_force"] == "foot_force" for limb in wiring.limbs)


def test_every_entry_that_is_found_has_its_reason(leg):
    assert {"rest_length_m", "omega", "contact_bodies", "scales.velocity"} < leg.reasons.keys()
    assert {f"limbs[{i}].push" for i in range(2)} < leg.reasons.keys()
    assert leg.remarks == ()


def test_nothing_is_missing_of_what_is_suggested(leg):
    env = EnvSpec(env="leg").for_wiring(leg.wiring).make()
    assert check_wiring(env, leg.wiring, steps=100) == []
    assert env.get_wrapper_attr("dt") == leg.wiring.step_s


def test_a_push_is_within_the_actuators_limits_and_says_so():
    weak = LEG.replace('ctrlrange="-6 6"', 'ctrlrange="-0.1111 0.1111"')
    result = suggest_wiring(ModelSettings(model=weak))
    assert result.wiring.limbs[1].push == pytest.approx(-0.1111)
    assert "the actuator's limit" in result.reasons["limbs[1].push"]


def test_a_geom_can_be_a_foot_and_feels_what_its_body_does():
    step = [ModelEnv(model=GEOM_FOOT, feet=[foot], control_s=0.005) for foot in ("sole", "foot")]
    observed = []
    for env in step:
        observation, _ = env.reset()
        for _ in range(40):
            observation = env.step(np.zeros(2))[0]
        observed.append(observation[env.observation_names.index(env.contact_names[0])])
    assert observed[0] == pytest.approx(observed[1])
    assert observed[0] > 5.0


def test_a_body_without_a_name_is_named_by_its_geom():
    nameless = GEOM_FOOT.replace('<body name="foot"', "<body")
    assert suggest_wiring(ModelSettings(model=nameless)).wiring.contact_bodies == ("sole",)


def test_an_actuator_and_a_foot_may_have_one_name():
    equal = LEG.replace('<motor name="knee"', '<motor name="foot"')
    assert sensing(ModelSettings(model=equal, feet=["foot"])).contacts == ("foot_contact_force",)


@pytest.mark.parametrize(
    ("model", "feet", "said"),
    [
        (LEG.replace("<actuator>", "<!--").replace("</actuator>", "-->"), (), "no actuator moves"),
        (re.sub('<geom name="ground".*?/>', "", LEG), (), "takes a floor: --settings ground=true"),
        (LEG.replace('size="0.018"', 'size="0.018" contype="0" conaffinity="0"'), (), "--feet"),
        (LEG.replace('<body name="foot"', "<body"), (), "the foot on shank has no name"),
        (
            LEG.replace('mass="0.02"/>', 'mass="0.02"/><site name="tip"/>'),
            ("tip",),
            "tip is a site, which touches nothing; name its body, foot",
        ),
        (LEG.replace('timestep="0.001"', 'timestep="1e-9"'), (), r"is 1e-09; it must be at least"),
        (LEG.replace('timestep="0.001"', 'timestep="10"'), (), r"is 10; it must be at most 0\.1"),
        (keyframe("nan"), (), "starts with qpos at nan; .* check its first keyframe"),
        (keyframe("1e30"), (), r"starts with qpos at 1e\+30; .* check its first keyframe"),
        (LEG.replace("-9.81", "nan"), (), "starts with qacc at nan; .* check its positions, mass"),
        (LEG.replace('<body name="trunk"', "<body"), (), "the first body .* has no name"),
        (UNSTABLE, (), r"unstable: .* its time step of 0\.03 s must be smaller"),
    ],
)
@pytest.mark.filterwarnings("ignore:MuJoCo")
def test_a_model_that_cannot_be_wired_so_is_refused_with_the_way_on(model, feet, said):
    refused(said, lambda: suggest_wiring(ModelSettings(model=model, feet=feet)))


def test_warnings_of_mujoco_are_a_line_of_a_kind_and_leave_no_log(tmp_path):
    (tmp_path / "my_leg.xml").write_text(UNSTABLE)
    process = subprocess.run(
        [sys.executable, "-m", "tegotae", "wiring", "suggest", "my_leg.xml"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    *warned, message = process.stderr.splitlines()
    assert process.returncode == 2
    assert message.startswith("tegotae: the MuJoCo model is unstable")
    assert len(warned) <= 3
    assert warned[0].endswith("value in QACC. The simulation is unstable.")
    assert [file.name for file in tmp_path.iterdir()] == ["my_leg.xml"]


def test_a_leg_that_gives_way_is_pointed_at_springs_and_servos():
    limp = LEG.replace('stiffness="8"', "").replace('stiffness="10"', "")
    (remark,) = suggest_wiring(ModelSettings(model=limp)).remarks
    assert "give the joints springs, or servos" in remark


def test_the_command_writes_a_file_with_reasons_that_reads_back(model_file, leg, capsys):
    assert main(["wiring", "suggest", str(model_file)]) == 0
    printed = capsys.readouterr().out
    assert "train ART@my_leg.toml --fitness return\n" in printed
    assert "# height at touchdown in a drop test" in Path("my_leg.toml").read_text()
    read = load_wiring("my_leg.toml")
    assert dataclasses.replace(read, controller=leg.wiring.controller).limbs == leg.wiring.limbs
    assert (read.omega, read.scales) == (leg.wiring.omega, leg.wiring.scales)


def test_a_wiring_that_is_there_is_not_overwritten(model_file, capsys):
    Path("my_leg.toml").write_text("mine")
    assert main(["wiring", "suggest", str(model_file)]) == 2
    message = capsys.readouterr()
    assert "name another file with --out" in message.err
    assert not message.out
    assert Path("my_leg.toml").read_text() == "mine"


def test_who_trains_a_model_without_a_wiring_is_pointed_at_the_suggestion(
    model_file, one_line_error
):
    message = one_line_error("train", "ART", "--env", str(model_file))
    assert "tegotae wiring suggest my_leg.xml" in message


def test_a_control_period_that_is_not_the_wirings_is_refused(leg):
    spec = EnvSpec(env="leg", settings=(("control_s", 0.01),))
    refused(r"the wiring's step_s 0\.005 s; leave one of them out", spec.for_wiring, leg.wiring)


ON_RAIL = re.sub(r'<joint name="along".*?/>', "", LEG)
SLIDER = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="trunk" pos="0 0 0.5">
      <joint type="slide" axis="0 0 1"/>
      <geom type="sphere" size="0.05" mass="1" contype="0" conaffinity="0"/>
      <body name="foot" pos="0 0 -0.4">
        <joint name="leg" type="slide" axis="0 0 1" stiffness="400" damping="2"/>
        <geom type="sphere" size="0.025" mass="0.1"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="leg" joint="leg" ctrlrange="-5 5" ctrllimited="true"/></actuator>
</mujoco>
"""
"""A leg on a slider, whose motor lifts less than half of its weight."""


def test_a_trunk_on_a_rail_is_to_hop_and_its_hip_does_not_sweep(model_file, capsys):
    model_file.write_text(ON_RAIL)
    assert main(["wiring", "suggest", str(model_file)]) == 0
    printed = capsys.readouterr().out
    assert "--fitness hopping\n" in printed
    assert "hip is left alone: the trunk is on a rail" in printed
    assert [limb.drives for limb in load_wiring("my_leg.toml").limbs] == ["knee"]
    assert not suggest_wiring(ModelSettings(model="leg")).on_rail


def test_a_leg_whose_pushes_lift_less_than_its_weight_is_told_so_before_and_after_training(
    model_file, capsys
):
    model_file.write_text(SLIDER)
    assert main(["wiring", "suggest", str(model_file)]) == 0
    assert "let the pushes lift 0.46 of the weight" in " ".join(capsys.readouterr().out.split())
    short = ["--population", "2", "--generations", "1", "--seeds", "1", "--out", "runs"]
    assert main(["train", "VG@my_leg.toml", "--duration-s", "4", *short]) == 0
    assert "The best run never leaves the ground; " in capsys.readouterr().out
    (file,) = Path("runs").glob("*-seed0.json")
    assert file.name == "VG-gF-reflex-w8@my_leg-seed0.json"
    assert main(["simulate", str(file)]) == 0
    assert "It never leaves the ground; " in capsys.readouterr().out
