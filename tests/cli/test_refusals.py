"""Commands refuse what they cannot do in one line, before any work, and leave nothing behind."""

import os
import shlex

import pytest

from places import TESTS
from tegotae import Rollout

USERS = TESTS / "users" / "my_parts.py"
NEEDED = {"--env": "mujoco", "fit-template": "mujoco", "suggest": "mujoco"}
"""Packages of extras that a refusal needs, by a word of its line."""
# Words that make no command, with what was meant.
MISTYPED = {
    "simulate --sgima 2": "no option of paper is called '--sgima'; did you mean --sigma",
    "simulate --duration-s long": "--duration-s is 'long'; write --duration-s FLOAT",
    "simulate --duration-s": "--duration-s has no value; write --duration-s FLOAT",
    "simulate paper --extra": "no option of paper is called '--extra'",
    "simulate --duration-s 4 paper": "'paper' after --duration-s is unexpected; names come before",
    "simulate --phases 0 0.5": "no option of paper is called '--phases'; did you mean --phase-rad",
    "simulate --work=kinetic": "--work is 'kinetic'; write --work {absolute,positive,net}",
    "gait sweep bar-light --levels 1": "--levels has 1 values of 2; write --levels FLOAT FLOAT",
    "gait sweep bar-light --levels 1 b": "--levels is '1 b'; write --levels FLOAT FLOAT",
    "gait sweep": "names come first: tegotae gait sweep NAME",
    "robustness": "names come first: tegotae robustness NAME",
    "models --zoo ART": "'ART' after --zoo is unexpected; names come before the options",
    "models --json true false": "'true' after --json is unexpected",
    "doctor x": "unexpected argument 'x'; tegotae doctor takes no name",
    "train": "names come first: tegotae train NAME [OPTIONS]",
    "train ART --seeds 1.5": "--seeds is '1.5'; write --seeds INT",
    "train ART --episodes 10": "no option of ART-rF-tphif-w8 is called '--episodes'",
    "train AR --algorithm sac --population 8": "no option of AR-rF-reflex-w8 is called",
    "train ART@quadruped-c --work net": "no option of ART-rF-tphif@quadruped-c is called '--work'",
    "evaluate --json": "names come first: tegotae evaluate NAME [OPTIONS]",
    "evaluate bar-light --drop-m 0.1": "no option of bar-light is called '--drop-m'",
    "evaluate paper --starts 3": "no option of paper is called '--starts'",
    "evaluate paper --omega 4 5": "'5' after --omega is unexpected",
    "compare": "names come first: tegotae compare NAME [OPTIONS]",
    "figure --foo": "tegotae figure has no option '--foo'; tegotae figure takes one of",
    "figure basin bar-light --resolution 9 --out b.png": "for others there is tegotae gait basin",
    "figure basin paper --starts 9 --out b.png": "no option of paper is called '--starts'",
    "completion fish": "SHELL is 'fish'; write SHELL {bash,zsh}",
    "benchmarks --lanes 1e3": "--lanes is '1e3'; write --lanes INT",
    f"models {'x' * 999} {'y' * 999}": "models takes one name; xxx",
    f"simulate {'x' * 999}": "has 999 bytes; the name of a file has 255 at most",
    f"simulate {'x' * 300}.py:f": "has 303 bytes",
    f"simulate --csv {'x' * 300}.csv": "has 304 bytes",
    f"benchmark run {'x' * 300}.zip": "has 304 bytes",
    f"figure surface --policy {'x' * 300}.onnx": "has 305 bytes",
    f"simulate {'a' * 5000}": "an argument has 5000 characters; it must have at most 1000",
    "--parts tests models": "there is no module tests; for a file write FILE",
}
# Names of nothing, or of what cannot answer.
UNKNOWN = {
    "simulat": "no command of tegotae is called 'simulat'; did you mean simulate",
    "figure surfac": "no command of tegotae figure is called 'surfac'; did you mean",
    "simulate papre": "no model or system is called 'papre'; did you mean paper",
    "simulate paper-refelx": "no actuation is called 'refelx'; did you mean reflex?",
    "simulate paper+hofp": "no oscillator is called 'hofp'; did you mean hopf",
    "simulate paper paper": "paper and paper hold the same runs",
    "simulate paper bar-light": "simulate takes one name; paper, bar-light are 2",
    "simulate no/such/file.json": "no controller file at no/such/file.json",
    "simulate zoo:AR-rF+range@no.toml": "there is no file no.toml",
    "wiring transfer quadruped-c@no.toml": "there is no file no.toml",
    "simulate ART": "no file was given; take zoo:ART-rF-tphif-w8, or train it: tegotae train",
    "simulate front:quadruped-c/0.4_0": "is no speed",
    "simulate {empty}:nothing": "is called 'nothing'; there is none",
    "evaluate runs/none": "no controller file at runs/none",
    "evaluate ART": "train it: tegotae train ART-rF-tphif-w8",
    "evaluate paper bar-light": "paper hops on one leg, and bar-light walks on several legs",
    "compare paper": "a comparison needs at least two sets of controllers; 1 found",
    "figure surface bar-light --out s.png": "several legs, and this figure is of one leg",
    "figure phase-locking paper-x --out p.png": "no actuation is called 'x'",
    "gait map paper --out m": "paper hops on one leg, and a gait is how several legs go",
    "gait stability bar-light --over nothing 0 1 --out new/map": "called 'nothing'",
    "robustness paper --conditions ''": "no condition is called ''; some that",
    "train art": "no model or system is called 'art'; did you mean ART",
    "train ART --algorithm pgp": "no algorithm is called 'pgp'; did you mean pgpe",
    "train AR --algorithm spo": "no algorithm is called 'spo'; did you mean ppo",
    "train AR --algorithm ppo --generations 8": "is called '--generations",
    "train AR --episodes 8": "is called '--episodes",
    "train V --algorithm sac": "sac has no meaning for V-reflex-w8",
    "models ART-rF-tphif-w9": "is called 'ART-rF-tphif-w9'; did you mean ART-rF-tphif-w",
    "models V-sectro-w4": "did you mean V-sector-w4",
    "models xyz --json": "no model is called 'xyz'; some that are: V-sector-w4",
    "models ''": "no model is called ''",
    "models X@nowhere": "no recipe is called",
    "metrics uprigt": "no metric is called 'uprigt'; did you mean upright",
    "evaluate paper --metric cot_invers": "called 'cot_invers'; did you mean cot_inverse",
    "evaluate paper --metric no_such_file.py:metric": "there is no file no_such_file.py",
    "evaluate paper --metric peak_force:nothing": "no object of peak_force is called",
    "evaluate paper --metric peak_force:_peak_force": "is no metric",
    "evaluate quadruped-x": "no model or system is called 'quadruped-x'; did you mean quadruped-",
    **{
        f"{command} AR@quadruped-c": "first: tegotae train AR-rF@quadruped-c --out FOLDER"
        for command in ("evaluate", "robustness", "simulate")
    },
    "explain bar-light": "hops in place",
    "explain zoo:ART-rF-tphi-w8/all": "name one of them",
    "explain ART-rF-tphi-w8": "take zoo:ART-rF-tphi-w8",
    "figure surface paper --policy math:cos --out x.png": "paper is a controller, and policy names",
    "figure surface --policy math:cos --sigma 2 --out x.png": "is called '--sigma",
    "figure surface paper --acts feedback --out x.png": "is called '--acts",
    "train ART@nowhere": "no legged system is called",
    "train nowhere.py:experiment": "there is no file nowhere.py",
    "train no_such_module:experiment": "there is no module no_such_module",
    f"train {USERS}:experimnt": "did you mean experiment",
    f"train {USERS}:Height": "is no controller or experiment: it is a Height, no ",
    f"train {USERS}:experiment --body {USERS}:Height": "is no body: ",
    f"train ART --algorithm {USERS}:Height": "is no algorithm: ",
    "train --parts": "--parts names no file",
    "train ARTT --env hopper": "did you mean ART",
    "train ART --env hoper": "no environment is called 'hoper'; did you mean hopper",
    "train ART --env my_robot.py": "my_robot.py:FUNCTION",
    f"train ART --env {TESTS / 'helpers' / 'wired_env.py'}:Scales": "no wiring is given",
    "train ART --env hopper --fitness speed": "no fitness is called 'speed'",
    "train ART --env hopper --settings mass": "is no NAME=VALUE",
    "train ART --env hopper --settings mass=3": "no setting of a MuJoCo model is called 'mass'",
    "train ART --env hopper --episodes 4": "is called '--episodes",
    "train ART --env hopper --mass-kg 2": "is called '--mass-kg",
    **{
        f"{command} robot.urdf": "robot.urdf is URDF; convert it to MJCF"
        for command in ("wiring suggest", "fit-template", "train AR@quadruped-c --env")
    },
    "benchmark run papre": "did you mean paper",
    "benchmark run quadruped-c": "the entry senses spring_force[0]; here are spring_force",
    "benchmark run zoo:T-Fv/9": "the entry senses velocity; here are spring_force",
    "benchmark run none.onnx": "there is no file",
    "reproduction run --dir s --scale smoke --models 'V-*' 'W-*'": "'W-*'",
    "reproduction readings run --scale huge --dir new": "no scale is called 'huge'",
    "reproduction readings status --dir new": "holds no study",
    "reproduction readings export --dir new --out out": "holds no study",
}
# Values that cannot be.
UNUSABLE = {
    **{
        f"simulate --{option}={value}": f"is {float(value):g}"
        for options, values in (
            (
                "mass-kg stiffness-n-per-m rest-length-m gravity-m-per-s2 max-force-n tick-s",
                "-1 0 nan inf",
            ),
            (
                "damping-ns-per-m flight-damping-ns-per-m measure-from-s drop-time-s",
                "-1 nan inf",
            ),
            ("omega sigma velocity-m-per-s phase-rad drop-m height-m", "nan inf -inf"),
            ("duration-s", "0 -1 nan inf"),
        )
        for option in options.split()
        for value in values.split()
    },
    "simulate --duration-s 0.001": "it must be at least one frame",
    "simulate --duration-s 1e9": "it must be at most 16777.2",
    "simulate --omega=-1 --plot new/a.png --csv new/a.csv": "omega is -1",
    "simulate --omega 1e39": "omega is 1e+39; it must be at most 1000",
    "simulate --height-m 0": "height_m is 0; it must be greater than 0",
    "simulate --height-m 1e300": "height_m is 1e+300; it must be at most 1000",
    "simulate --velocity-m-per-s=-1e9": "velocity_m_per_s is -1e+09; it must be at least -1000",
    "simulate --drop-m 1e9": "drop_m is 1e+09; it must be at most 1000",
    "simulate --mass-kg 1e300": "mass_kg is 1e+300; it must be at most 3.40282e+38",
    "simulate --mass-kg 1e-300": "the control tick of 0.001 s is too long",
    "simulate --damping-ns-per-m 1e6": "the control tick of 0.001 s is too long",
    "simulate --sigma 1e300": "sigma is 1e+300; it must be at most 1e+06",
    "simulate --tick-s 1": "the control tick of 1 s is too long for this hopper",
    "simulate --tick-s 1e-9": "at 1e-09 s per control tick it must be at most",
    "simulate --tick-s 5e-324": "per control tick it must be at most",
    "simulate --measure-from-s 20": "begins at 20 s, but the rollout ends at 20 s",
    "simulate --drop-m 0.2 --drop-time-s 20": "to drop at 20 s, but the rollout ends at 20 s",
    "simulate --drop-m 0.2 --duration-s 5": "to drop at 10 s, but the rollout ends at 5 s",
    "evaluate paper --work kinetic": "work is 'kinetic'",
    "evaluate paper --undisturbed-s nan": "undisturbed_s is nan",
    "evaluate paper --omega 1e39": "omega_t is 1e+39; it must be at most 1000",
    "evaluate paper --drop-m 1e308": "drop_m is 1e+308; it must be at most 1000",
    "evaluate quadruped-c --omega nan": "omega is nan; it must be finite",
    "compare paper paper-reflex --drop-m=-1": "drop_m is -1",
    "explain paper --releases 0": "releases is 0",
    "explain paper --releases 1": "releases is 1; it must be at least 2",
    "explain paper --seed=-1": "seed is -1",
    "explain paper --duration-s 0": "must be at least 1",
    "explain paper --retune=-1": "retune is -1",
    "explain paper --retune-seeds 0": "retune_seeds is 0",
    **{
        f"export native paper --max-force-n={force} --out leg.native": f"force_n is {said}"
        for force, said in (("nan", "nan"), ("-1", "-1"), ("0", "0"), ("inf", "inf"), ("1e39", ""))
    },
    "export native paper --max-force-n 3 --out leg.native": "its largest force already",
    "train ART --population 7": "population is 7; PGPE samples pairs, so it must be even",
    "train ART --population 0": "population is 0; it must be a whole number of at least 2",
    "train ART --population 1000000000000": "seeds and 96 weights, would need about",
    "train ART --seeds 0": "seeds is 0; it must be a whole number of at least 1",
    "train ART --seeds 1000000000": "seeds is 1000000000; it must be at most 100000",
    "train ART --first-seed=-1": "first_seed is -1; it must be a whole number of at least 0",
    "train ART --first-seed 2147483647 --seeds 2": "it must be at most 2147483645",
    "train ART --generations 0": "generations is 0; it must be a whole number of at least 1",
    "train AR --algorithm sac --episodes 0": "episodes is 0",
    "train ART --budget 5": "budget is 5, too small",
    "train V --budget 0": "budget is 0",
    "train ART --budget 1000000000": "budget is 1000000000; it must be at most 1000000",
    "train ART --duration-s 4.5": "of 4.5 s leaves less than 1 s after settling for 12 s",
    "train V --duration-s 4.5": "of 4.5 s leaves less than 1 s after settling for 12 s",
    "train ART --duration-s nan": "duration_s is nan",
    "train ART --duration-s 1e9": "duration_s is 1e+09; at 0.002 s per control tick it must be",
    "train ART --settle-s=-1": "settle_s is -1",
    "train ART --tick-s 0": "tick_s is 0",
    "train ART --tick-s 0.003": "frame_s is 0.02; it must be a whole multiple of tick_s (0.003)",
    "train ART --vary mass_kg=0.0_8:0.1": "is no condition",
    "train ARGT@hexapod --budget 9": "too small",
    f"train {USERS}:experiment --budget 20": "--budget sizes the networks of the paper's",
    f"train {USERS}:experiment --cot-only": "cot_only belongs to the paper's fitness",
    **{
        f"train ART --{option}": "belongs to environments; give env, too"
        for option in ("wiring leg.toml", "omega 8", "workers 0")
    },
    **{
        f"train ART --env hopper --{option} 4": "the 4 episodes on hopper would be alike"
        for option in ("episodes-per-candidate", "evaluation-episodes")
    },
    "train ART --env hopper --workers=-1": "workers is -1; it must be a whole number of at least 0",
    "train ART --env hopper --workers 99999": "workers is 99999; on this machine of",
    "train ART --env hopper --settings duration_s=9": "the experiment's duration_s is 24",
    "train ART --env hopper --algorithm SAC": "take a model without, such as AR",
    "train ART --env hopper --work positive": "the wiring does not say work_positive",
    "train ART --env hopper --fitness return --cot-only": "cot_only belongs to the fitness hop",
    "robustness paper --conditions delay=0.0_1/0.02": "has no levels",
    **{
        f"robustness paper --out new --conditions {name}={level}": f"of {name} is {level:g}"
        for name in ("delay", "lag", "noise", "mass", "omega", "blow")
        for level in (1e308, -1e308, float("nan"))
    },
    "robustness paper --out new --conditions delay=1000": "is 500000 control ticks; 128 are",
    "models ART --budget 5": "budget is 5, too small: ART-rF-tphi has at least 12 weights",
    "models --budget=-3": "budget is -3; it must be a whole number of at least 1",
    "models ART --zoo --budget 20": "budget sizes controllers that are not trained",
    "gait map bar-light --x sigma 1 2 --y sigma 1 2 --out new/map": "a map is over two",
    "gait front quadruped-c --walkers 10000000000": "must be at most 1000000",
    "figure basin bar-light --out b.txt": "b.txt",
    "figure basin --height-m -1 2 --out b.png": "height_m (low end) is -1; it must be greater",
    "figure basin --resolution 1000000000 --out b.png": "it must be at most 2000",
    "figure phase-locking --cut 1e300 --out p.png": "cut is 1e+300",
    "figure poincare --nudge 1e300 --out p.png": "nudge is 1e+300; it must be at most 1",
    "figure poincare --turns 99999999 --out p.png": "turns is 99999999; it must be at most",
    "figure phase-response --points 1000000000 --out p.png": "points is 1000000000",
    "figure phase-response --push 1e300 --out p.png": "push is 1e+300; it must be at most",
    "figure surface paper --omega=-1 --out new/a.png": "omega is -1",
    "figure surface --spring-force-n 1e30 --out s.png": "spring_force_n is 1e+30; it must be at",
    "figure surface --resolution 1000000000 --out s.png": "it must be at most 2000",
    "simulate bar-light --animate walk.avi": "use .gif, .webp, .mp4 or .webm",
    "benchmarks --lanes 0": "lanes is 0; it must be a whole number of at least 1",
    "benchmarks --lanes 1000000000000": "1000000000000 lanes would need about 2.86e+06 GiB",
    "reproduction optimum-table --starts 0": "starts is 0; it must be a whole",
    "reproduction run --dir s --workers 0": "workers is 0; it must be a whole number",
    "reproduction run --dir s --workers 99999": "workers is 99999; on this machine of",
    "reproduction readings run --dir s --readings 0": "readings is 0",
    "reproduction readings run --dir s --readings 999999999": "readings is 999999999",
    "reproduction gain-map --omega 0 1e308 --out g.png": "omega (high end) is 1e+308",
    "reproduction gain-map --sigma 0 1e30 --out g.png": "sigma (high end) is 1e+30",
    "reproduction gain-map --resolution 99999999999999 --out g.png": "it must be at most 2000",
}
REFUSED = {**MISTYPED, **UNKNOWN, **UNUSABLE}


@pytest.fixture
def no_work(monkeypatch):
    """Makes any rollout, training or search fail the test."""

    def begin(*_, **__):
        raise AssertionError("work was started before the input was checked")

    monkeypatch.setattr(Rollout, "run", begin)
    monkeypatch.setattr(Rollout, "run_lanes", begin)
    for name in ("start", "evolve"):
        monkeypatch.setattr(f"tegotae.training.evolution.Evolution.{name}", begin)


@pytest.mark.parametrize("line", REFUSED, ids=lambda line: line[:60])
def test_what_cannot_be_done_is_refused_in_one_line_before_any_work(
    line, no_work, one_line_error, tmp_path, monkeypatch
):
    for word in NEEDED.keys() & set(line.split()):
        pytest.importorskip(NEEDED[word])
    empty = tmp_path / "nothing_in_it.py"
    empty.touch()
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    said = one_line_error(*shlex.split(line.replace("{empty}", str(empty))))
    assert REFUSED[line] in said
    assert len(said) < 640
    assert os.listdir() == []


def test_without_a_command_they_are_listed(one_line_error):
    assert "simulate, models, train" in one_line_error()


@pytest.mark.parametrize("columns", ["20", None])
def test_the_width_of_the_terminal_changes_no_line(one_line_error, monkeypatch, columns):
    if columns:
        monkeypatch.setenv("COLUMNS", columns)
    else:
        monkeypatch.delenv("COLUMNS", raising=False)
    said = one_line_error("simulate", "--sgima", "2")
    assert MISTYPED["simulate --sgima 2"] in said
    assert os.environ.get("COLUMNS") == columns
