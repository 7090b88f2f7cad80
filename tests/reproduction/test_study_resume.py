"""A study that is killed, anywhere and at any time, ends in the numbers of an undisturbed one."""

import dataclasses
import os
import random
import signal
import subprocess

import numpy as np
import pytest

import study_runs
from research.reproduction import runner
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from research.reproduction.record import read_record
from tegotae._support.documents import DamagedDocumentError
from tegotae._support.errors import TegotaeError
from tegotae._support.workers import WorkersDied


@pytest.mark.thorough
def test_kills_at_random_moments_lose_only_the_work_in_flight(smoke_study, tmp_path):
    moments = random.Random(5)
    folder = tmp_path / "study"
    stored: dict[str, bytes] = {}
    for awaited in (0, 1):  # records, before the moment is drawn
        process = study_runs.start(folder)
        observed = study_runs.wait_for(lambda p=process: study_runs.workers(p), "workers", process)
        study_runs.wait_for(
            lambda p=process, n=awaited: (
                p.poll() is not None or len(study_runs.records(folder)) >= n
            ),
            "a record",
        )
        observed = study_runs.workers(process) if process.poll() is None else observed
        try:
            process.wait(moments.uniform(0.0, 2.0))
        except subprocess.TimeoutExpired:
            process.kill()
        process.communicate(timeout=900)
        study_runs.assert_ended(observed)
        current = {path.name: path.read_bytes() for path in study_runs.records(folder)}
        assert stored.items() <= current.items()
        stored = current
    out, _ = study_runs.finish(study_runs.start(folder))
    assert out.startswith("3 records in ")
    study_runs.assert_same(folder, smoke_study)
    assert stored.items() <= {p.name: p.read_bytes() for p in study_runs.records(folder)}.items()


def test_neither_a_killed_worker_nor_a_second_run_that_is_refused_changes_a_thing(
    smoke_study, tmp_path, one_line_error
):
    folder = study_runs.copy(smoke_study, tmp_path / "study", "ART")
    process = study_runs.start(folder, "--workers", "2", programs_of=smoke_study)
    pair = study_runs.wait_for(
        lambda: result if len(result := study_runs.workers(process)) == 2 else None,
        "workers",
        process,
    )
    for words in (["run", "--scale", "smoke"], ["merge", str(smoke_study)]):
        message = one_line_error("reproduction", *words, "--dir", str(folder))
        assert f"another run is at work in {folder}; wait for it" in message
    random.Random(1).choice(pair).kill()
    _, err = study_runs.finish(process)
    assert "Traceback" not in err
    study_runs.assert_same(folder, smoke_study)


@pytest.mark.parametrize(
    "sign", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.thorough)]
)
def test_an_interrupted_study_goes_on_where_it_was_and_does_a_damaged_record_anew(
    smoke_study, tmp_path, sign
):
    folder = study_runs.copy(smoke_study, tmp_path / "study", "ART", "T")
    process = study_runs.start(folder, "--workers", "1", programs_of=smoke_study)
    observed = study_runs.wait_for(lambda: study_runs.workers(process), "workers", process)
    # Ctrl-C reaches every process of the terminal, a polite kill the one that is named.
    (os.killpg if sign == signal.SIGINT else os.kill)(process.pid, sign)
    out, err = process.communicate(timeout=900)
    study_runs.assert_ended(observed)
    assert out == ""
    if sign == signal.SIGINT:
        assert process.returncode == 130
        *progress, last = err.splitlines()
        assert progress == ["study  2/3  done before"]
        assert last == (
            f"tegotae: interrupted; {folder} keeps 2 of 3 models, "
            "the same command continues from there"
        )
    else:
        assert process.returncode == -signal.SIGTERM
    (damaged,) = folder.glob("records/T-*")
    content = damaged.read_bytes()[:-100]
    damaged.write_bytes(content)
    out, _ = study_runs.finish(study_runs.start(folder, programs_of=smoke_study))
    assert f"{damaged.name} is damaged: " in out
    assert f"it is set aside in {folder / 'damaged'} and done again" in out
    assert (folder / "damaged" / damaged.name).read_bytes() == content
    study_runs.assert_same(folder, smoke_study)


def test_what_a_kill_left_half_written_is_no_record_and_is_cleared(smoke_study, tmp_path):
    folder = study_runs.copy(smoke_study, tmp_path / "study", *study_runs.MODELS)
    complete = study_runs.records(folder)[0]
    half = complete.with_name(f".{complete.name}.0123abcd")
    half.write_bytes(complete.read_bytes()[:100])
    assert len(Folder(folder).all()[0]) == 3
    runner.run_study(plan("smoke"), folder, unasked)
    assert not half.exists()
    study_runs.assert_same(folder, smoke_study)


@pytest.mark.thorough
def test_a_flipped_bit_anywhere_is_found_or_changes_nothing(smoke_study, tmp_path):
    (source,) = smoke_study.glob("records/T-*")
    content, complete = source.read_bytes(), dataclasses.asdict(read_record(source))
    bits = random.Random(0)
    result = 0
    places = range(0, len(content), 17)
    for place in places:
        flipped = bytearray(content)
        flipped[place] ^= 1 << bits.randrange(8)
        (tmp_path / "flipped").write_bytes(flipped)
        try:
            np.testing.assert_equal(dataclasses.asdict(read_record(tmp_path / "flipped")), complete)
        except DamagedDocumentError:
            result += 1
    # The rest are dates and the like in the archive, which carry nothing.
    assert result > len(places) // 2


def unasked(bundles):
    raise AssertionError(f"work was asked for: {bundles}")
    yield


# Workers that die again and again.


def test_workers_that_always_die_end_the_study_and_keep_what_is_done(smoke_study, tmp_path):
    requested = []

    def dying(bundles):
        requested.append(len(bundles))
        raise WorkersDied
        yield

    folder = study_runs.copy(smoke_study, tmp_path / "study", "V")
    with pytest.raises(TegotaeError) as raised:
        runner.run_study(plan("smoke"), folder, dying)
    assert str(raised.value) == (
        "workers died 5 times without a result; is there enough memory?; "
        f"{folder} keeps 1 of 3 models, the same command continues from there"
    )
    assert requested == [2] * 5


def test_workers_may_die_often_as_long_as_the_study_gets_on(smoke_study, tmp_path):
    records = {record.model: record for record in Folder(smoke_study).all()[0]}

    def dying_after_one(bundles):
        for _ in range(3):
            for unit in bundles[0]:
                yield unit, records[unit.name].result
            raise WorkersDied

    assert runner.run_study(plan("smoke"), tmp_path / "study", dying_after_one) == 3
    study_runs.assert_same(tmp_path / "study", smoke_study)
