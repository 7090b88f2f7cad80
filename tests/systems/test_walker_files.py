"""A walker in a file of its own is named as those of the package are."""

import pandas as pd
import pytest

from refusals import refused
from tegotae import TegotaeError, train
from tegotae.cli import main
from tegotae.parts.bodies import Sensors
from tegotae.systems.controller_file import load
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.systems.vanilla import legged_named

HEXAPOD = """
about = "a hexapod with the legs of set C"
sigma = 1.25
omega = 2.0

[foot]
stride_m = 0.2
lift_m = 0.12
press_m = 0.03
shift_rad = 0.4

[body]
hips_x_m = [0.85, 0.85, 0.0, 0.0, -0.85, -0.85]
hips_y_m = [0.44, -0.44, 0.44, -0.44, 0.44, -0.44]
"""


@pytest.fixture
def walker_file(tmp_path):
    file = tmp_path / "six.toml"
    file.write_text(HEXAPOD)
    return file


def test_a_file_and_an_entry_of_the_package_with_the_same_numbers_are_the_same(walker_file):
    assert legged_named(str(walker_file)) == legged_named("hexapod")
    assert resolve(walker_file).legs() == legged_named("hexapod")


def test_a_design_upon_it_has_the_name_of_the_file_without_its_folder(walker_file):
    learned = recipe(f"AR-w3@{walker_file}")
    assert learned.name == "AR-rF-w3@six"
    assert learned.experiment().system.body == legged_named("hexapod").body
    assert resolve(f"AR@{walker_file}").experiment().name == "AR-rF@six"
    with pytest.raises(TegotaeError, match=f"first: tegotae train AR@{walker_file} --out"):
        resolve(f"AR@{walker_file}").controller()


def test_its_senses_can_be_late_and_noisy(walker_file):
    walker_file.write_text(HEXAPOD + "\n[senses]\ndelay_s = 0.1\nnoise = 0.05\n")
    late = Sensors(body=legged_named("hexapod").body, delay_s=0.1, noise=0.05)
    assert legged_named(str(walker_file)).body == late
    walker_file.write_text(HEXAPOD + "\n[senses]\n")
    assert legged_named(str(walker_file)).body == Sensors(body=late.body)


@pytest.mark.thorough
def test_late_senses_of_a_file_are_those_of_the_options(walker_file):
    standard = legged_named(str(walker_file))
    numbers = {"duration_s": 20.0, "phases": (0.0, 0.1, 0.3, 0.4, 0.6, 0.9)}
    options_frame = load(str(walker_file)).simulate(**numbers, delay_s=0.1, noise=0.05).table
    walker_file.write_text(HEXAPOD + "\n[senses]\ndelay_s = 0.1\nnoise = 0.05\n")
    pd.testing.assert_frame_equal(load(str(walker_file)).simulate(**numbers).table, options_frame)
    none = load(str(walker_file)).simulate(**numbers, delay_s=0.0, noise=0.0)
    assert none.settings["body"] == standard.body


@pytest.mark.thorough
def test_a_training_varies_late_senses(walker_file, tmp_path):
    walker_file.write_text(HEXAPOD + "\n[senses]\ndelay_s = 0.1\n")
    amount = {"generations": 1, "population": 2, "seeds": 1, "duration": 32.0}
    train(f"AR@{walker_file}", vary=("delay_s=0:0.1",), out=tmp_path / "run", **amount)
    experiment = resolve(tmp_path / "run").controller().experiment
    assert experiment is not None
    assert [condition.name for condition in experiment.conditions] == ["delay_s"]


def test_a_command_takes_it_where_a_system_is_named(walker_file, capsys):
    main(["simulate", str(walker_file), "--duration-s", "4"])
    assert "cost of transport" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("sigma = 1.25", "", "it has no entry 'sigma'"),
        ("sigma = 1.25", "sigma = nan", "sigma is nan; it must be finite"),
        ("omega = 2.0", "omega = 0", "omega is 0; it must be greater than 0"),
        ("omega = 2.0", "omega = 2.0\nspeed = 1.0", "no entry is called 'speed'; did you mean"),
        ("lift_m = 0.12", "lift_m = -0.12", "lift_m is -0.12; it must be at least 0"),
        ("lift_m", "rise_m", "has no 'rise_m'"),
        ("[body]", "[body]\nfriction = 'low'", "its friction is 'low'; it must be a number"),
        ("0.85, 0.85, 0.0", "0.85, 0.0", "hips_x_m places 5 legs and hips_y_m 6"),
        ("[body]", "[body]\nstiffness_z_n_per_m = 0.1", "stiffness_z_n_per_m is 0.1: 6 legs give"),
        ("[body]", "[senses]\nbody = 1\n[body]", "body"),
        ("[body]", "[senses]\ndelay_s = -0.1\n[body]", "delay_s is -0.1; it must be at least 0"),
        ("[body]", "[senses]\ndelay_s = 9\n[body]", "delay_s is 9, which is 1125 control ticks"),
        ("[body]", "[body", "it is no TOML"),
    ],
)
def test_a_file_that_is_no_walker_is_refused_in_one_line(walker_file, old, new, message):
    walker_file.write_text(HEXAPOD.replace(old, new))
    with pytest.raises(TegotaeError, match="is no walker: ") as raised:
        legged_named(str(walker_file))
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_file_that_is_not_there_is_named():
    refused(r"there is no file nowhere\.toml", resolve, "AR@nowhere.toml")
