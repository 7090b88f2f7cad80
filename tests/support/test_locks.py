"""One program at a time in a folder, and a lock that harms nothing."""

import os
import signal
import subprocess
import sys

import pytest

from tegotae._support.errors import TegotaeError
from tegotae._support.workplace import locked
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.run import Run, train

HOLDER = """
import sys
from pathlib import Path
from tegotae._support.workplace import locked

with locked(Path(sys.argv[1])):
    print("locked", flush=True)
    sys.stdin.readline()
"""


def test_a_lock_ends_with_its_process_however_that_ends(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as second:
        assert second.stdout is not None
        assert second.stdout.readline() == "locked\n"
        with pytest.raises(TegotaeError) as raised, locked(tmp_path):
            raise AssertionError("two in one folder")
        second.send_signal(signal.SIGKILL)
    assert str(raised.value) == (
        f"another run is at work in {tmp_path}; wait for it, or choose another folder"
    )
    with locked(tmp_path):
        pass


def test_what_goes_wrong_under_a_lock_is_told_as_it_is(tmp_path):
    with pytest.raises(BlockingIOError, match="of its own"), locked(tmp_path):
        raise BlockingIOError("of its own")
    with locked(tmp_path):
        pass


def test_the_target_of_a_link_in_the_locks_place_is_left_as_it_is(tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("content")
    (tmp_path / ".lock").symlink_to(precious)
    with pytest.raises(TegotaeError) as raised, locked(tmp_path):
        raise AssertionError("a link was followed")
    assert str(raised.value) == f"cannot open {tmp_path / '.lock'}: it is a link; remove it"
    assert precious.read_text() == "content"


def test_a_file_in_the_locks_place_is_not_emptied(tmp_path):
    (tmp_path / ".lock").write_text("content")
    with locked(tmp_path):
        pass
    assert (tmp_path / ".lock").read_text() == "content"


def test_agents_are_not_trained_in_a_folder_in_use(tmp_path):
    pytest.importorskip("stable_baselines3")
    from tegotae.systems.recipe import recipe

    with locked(tmp_path), pytest.raises(TegotaeError, match=f"at work in {tmp_path}; "):
        train(Run(experiment=recipe("AR").experiment(), learner=AgentLearner()), tmp_path)
    assert os.listdir(tmp_path) == [".lock"]
