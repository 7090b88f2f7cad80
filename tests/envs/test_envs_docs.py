"""The page on environments prints what it says it prints."""

import re

import pytest

from places import ROOT

pytest.importorskip("gymnasium")
pytest.importorskip("stable_baselines3")

PAGE = ROOT / "docs" / "environments.md"


def blocks(language):
    fence = re.compile(rf"^```{language}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return fence.findall(PAGE.read_text(encoding="utf-8"))


def test_examples_run_in_their_order_and_print_what_the_page_shows(capsys):
    namespace: dict = {}
    for block in blocks("python"):
        exec(block, namespace)
    printed = capsys.readouterr().out.splitlines()
    # The output of the MuJoCo example is not shown by a block of the page's own.
    output = [line for block in blocks("text") for line in block.splitlines()]
    missing = [line for line in output if line not in printed]
    assert all(line.startswith(("no torque:", "Tegotae:")) for line in missing), missing
    assert len(output) - len(missing) == 4
