"""A type checker finds a wrong keyword in a user's script."""

import json
import subprocess
import sys

import pytest

from places import ROOT

pytest.importorskip("pyright")

SCRIPT = """\
import tegotae as tg

run = tg.load("paper").simulate(drop_m=0.1, body={"mass_kg": 0.2})
rows = tg.load("zoo:ART", tg.HopperController).evaluate("paper", omega=4.0).table
gaits = tg.gaits.map("quadruped-c", x=("com_x_m", -0.3, 0.3), cells=(4, 4))
first = tg.load("paper").simulate(duration=4.0)
second = tg.plot.basin("paper", resolutoin=20)
third = tg.load("quadruped-c").simulate(drop_m=0.1)
fourth = tg.load("V-reflex-w8").simulate(sigmas=2.0)
fifth = tg.load("zoo:ART").simulate(drops_m=0.1)
vanilla = tg.load("V-reflex-w8").simulate(sigma=2.0, drop_m=0.2, drop_time_s=8.0)
preset = tg.load("pyTegotaeCPG-both").simulate(sigma=2.0)
run = tg.load("zoo:ART-rF-tphif-w8/3").simulate(drop_m=0.1)
slope = tg.gaits.basin("quadruped-c", starts=8, terrain=("slope",), tolerance=0.05, seed=3)
cycle = tg.plot.poincare("paper", turns=20, omega=6.0, body={"mass_kg": 0.2})
pair = tg.load("paper").compare("V-reflex-w8", metric=("cot_inverse",))
sixth = tg.gaits.basin("quadruped-c", delays_s=0.1)
seventh = tg.plot.poincare("paper", omegas=6.0)
eighth = tg.load("quadruped-c").compare("quadruped-g", start=4)
"""


def test_a_wrong_keyword_is_an_error_of_the_type_checker_and_a_right_one_is_none(tmp_path):
    (tmp_path / "user.py").write_text(SCRIPT)
    (tmp_path / "pyrightconfig.json").write_text(json.dumps({"extraPaths": [str(ROOT / "src")]}))
    words = ["--outputjson", "--pythonpath", sys.executable, "-p", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-m", "pyright", *words], capture_output=True, text=True, cwd=tmp_path
    )
    found = json.loads(done.stdout)["generalDiagnostics"]
    lines = [x["range"]["start"]["line"] for x in found if x["severity"] == "error"]
    assert lines == [5, 6, 7, 8, 9, 16, 17, 18]
    names = ("duration", "resolutoin", "drop_m", "sigmas", "drops_m", "delays_s", "omegas", "start")
    assert all(f'"{name}"' in x["message"] for name, x in zip(names, found, strict=True))
