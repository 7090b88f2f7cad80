"""Documents are held against a schema: a line that names the file, the entry, what is there."""

import json
import os
import struct
from io import BytesIO
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from controller_files import text
from records import made_up
from refusals import refused
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from research.reproduction.readings.folder import MultiverseFolder
from research.reproduction.readings.plan import multiverse
from research.reproduction.record import read_record
from tegotae import TegotaeError
from tegotae._support import documents
from tegotae._support.documents import (
    DamagedDocumentError,
    checked,
    fitted,
    parse_json,
    parse_toml,
)
from tegotae._support.files import read_arrays
from tegotae._support.pages import as_script
from tegotae.systems import controller_file
from tegotae.training.curves import read_curves
from tegotae.training.run import claim, write_curves
from tegotae.training.settings import load_configuration


class Inner(msgspec.Struct):
    name: str
    population: Annotated[int, msgspec.Meta(ge=1)]


class Outer(msgspec.Struct):
    seeds: int
    algorithm: Inner
    weights: list[float]
    model: str | None = None
    software: dict[str, str] = {}


def document(**changes: Any) -> dict[str, Any]:
    fields = {"seeds": 1, "algorithm": {"name": "pgpe", "population": 8}, "weights": [1, 2.5]}
    return {**fields, **changes}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seeds": None}, "its seeds is None; it must be a whole number"),
        ({"seeds": True}, "its seeds is True; it must be a whole number"),
        ({"seeds": 1.5}, "its seeds is 1.5; it must be a whole number"),
        ({"model": 3}, "its model is 3; it must be a text or null"),
        ({"weights": [1.0, "2"]}, "its weights[1] is '2'; it must be a number"),
        ({"weights": [10**400]}, "which is too large"),
        ({"algorithm": []}, "its algorithm is []; it must be an object"),
        ({"algorithm": {"name": "pgpe"}}, "it has no entry 'algorithm.population'"),
        (
            {"algorithm": {"name": "pgpe", "population": 0}},
            "its algorithm.population is 0; it must be a whole number >= 1",
        ),
        ({"software": {"jax": 1}}, "an entry is a whole number; it must be a text"),
    ],
)
def test_what_does_not_fit_a_schema_is_named_with_what_would(changes, message):
    with pytest.raises(DamagedDocumentError) as raised:
        fitted(document(**changes), Outer)
    assert message in str(raised.value)


def test_what_fits_is_taken():
    assert fitted(document(), Outer).weights == [1.0, 2.5]
    for value in ([], None, 3, "text"):
        with pytest.raises(DamagedDocumentError, match="it must be an object"):
            fitted(value, Outer)


BAD_TEXTS = ["\x1b[31mred", "a\x00b", "\ud800", "\x9b1m", "\u202egnp.exe", "\x7f"]
GOOD_TEXTS = ["ART-rF-tphif-w8", "$x^2$", "[red]", "φ̇ = ω\n\tf", "日本語", "🦘", ""]


@pytest.mark.parametrize("text", BAD_TEXTS)
def test_a_text_that_would_command_a_terminal_is_refused(text):
    for value in (text, {"model": text}, {text: 1}, [[{"a": [text]}]]):
        with pytest.raises(DamagedDocumentError, match="which no text of such a file has"):
            parse_json(json.dumps(value))


@pytest.mark.parametrize("text", GOOD_TEXTS)
def test_a_text_is_taken_as_it_is(text):
    assert parse_json(json.dumps({"model": [text]})) == {"model": [text]}


@pytest.mark.parametrize("depth", [100, 900, 100_000])
@pytest.mark.parametrize(("start", "end"), [("[", "]"), ('{"a":', "}")])
def test_what_is_nested_very_deep_is_refused(depth, start, end):
    with pytest.raises(DamagedDocumentError, match="nested deeper than 64 levels"):
        parse_json(start * depth + "1" + end * depth)


@given(st.recursive(st.none() | st.booleans() | st.floats() | st.text(), st.lists, max_leaves=9))
def test_a_json_value_is_itself_or_refused(value):
    try:
        result = checked(value)
    except DamagedDocumentError as refused:
        result, lines = value, str(refused).splitlines()
    else:
        lines = ["taken"]
    assert result is value
    assert len(lines) == 1


@pytest.mark.parametrize(
    ("read", "text"),
    [
        (parse_json, '{"weights": [1], "name": "a", "weights": [2]}'),
        (parse_json, '{"system": {"omega": 8, "omega": 4}}'),
        (parse_toml, "omega = 8\nomega = 4"),
    ],
)
def test_of_two_entries_of_one_name_none_wins(read, text):
    with pytest.raises(DamagedDocumentError, match=r"its entry '\w+' is there 2 times|no TOML"):
        read(text)


def test_a_message_about_a_very_long_value_leaves_its_middle_out():
    message = str(TegotaeError(f"no leg is called {'a' * 5000!r}; did you mean knee?"))
    assert len(message) == 600
    assert message.startswith("no leg is called 'aaa")
    assert message.endswith("aaa'; did you mean knee?")


def test_a_file_that_is_too_large_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(documents, "MOST_BYTES", 100)
    (tmp_path / "a.json").write_text("[" + "1," * 100 + "1]")
    with pytest.raises(DamagedDocumentError, match="it is larger than"):
        documents.read(tmp_path / "a.json")


def test_a_file_that_may_not_be_read_is_not_called_damaged(tmp_path):
    refused(r"^cannot read .*: Is a directory$", documents.read, tmp_path)


# Every kind of document, with entries of a wrong type.


def changed(document: dict[str, Any], place: tuple[str, ...], value: Any) -> str:
    copy = json.loads(json.dumps(document))
    entry = copy
    for name in place[:-1]:
        entry = entry[name]
    entry[place[-1]] = value
    return json.dumps(copy)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("algorithm",), "pgpe"),
        (("algorithm", "name"), 3),
        (("algorithm", "population"), "many"),
        (("seeds",), None),
        (("seeds",), 10**12),
        (("scale",), ["quick"]),
        (("stopping",), 3),
        (("experiments",), [1]),
    ],
)
def test_the_description_of_a_study_is_held_against_its_schema(tmp_path, place, value):
    (tmp_path / "study.json").write_text(changed(plan("smoke").document, place, value))
    with pytest.raises(TegotaeError, match=rf"study\.json is damaged: its {'.'.join(place)} is "):
        _ = Folder(tmp_path).document


@pytest.mark.parametrize(
    ("place", "value"), [(("seeds",), "4"), (("models",), 3), (("choices",), [])]
)
def test_the_description_of_a_multiverse_is_held_against_its_schema(tmp_path, place, value):
    (tmp_path / "study.json").write_text(changed(multiverse("smoke").document, place, value))
    with pytest.raises(TegotaeError, match=rf"study\.json is damaged: its {place[0]} is "):
        _ = MultiverseFolder(tmp_path).document


@pytest.mark.parametrize(
    "text", ["[]", '{"configuration": 3}', "[" * 10_000, '{"configuration": {"a": "\\ud800"}}']
)
def test_the_account_of_a_training_is_held_against_its_schema(tmp_path, text):
    (tmp_path / "run.json").write_text(text)
    (tmp_path / "checkpoint.npz").touch()
    refused(r"run\.json is damaged: .*; choose another folder", claim, tmp_path, {}, {})


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("algorithm",), "sac"),
        (("algorithm", "name"), None),
        (("experiment", "name"), 3),
        (("experiment",), "AR"),
    ],
)
def test_learning_curves_ask_a_schema_of_their_training(tmp_path, place, value):
    configuration = {
        "experiment": {"name": "AR"},
        "algorithm": {"name": "pgpe", "population": 8},
    }
    document = {"configuration": configuration, "software": {"engine": "native"}}
    changes = changed(document, ("configuration", *place), value)
    (tmp_path / "run.json").write_text(changes)
    write_curves(tmp_path / "curves.csv", [])
    with pytest.raises(
        TegotaeError, match=rf"run\.json is damaged: its configuration\.{'.'.join(place)} is "
    ):
        read_curves([tmp_path])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"population": "8"}, "its population is '8'"),
        ({"population": 8.5}, "its population is 8.5"),
        ({"population": 7}, "population is 7"),
        ({"std": None}, "its std is None"),
        ({"std": [0.1]}, r"its std is \[0.1\]"),
    ],
)
def test_kept_settings_are_held_against_their_algorithm(tmp_path, settings, message):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({"algorithm": "pgpe", "settings": settings, "found": {}}))
    with pytest.raises(TegotaeError, match=message) as raised:
        load_configuration(path)
    assert str(path) in str(raised.value)


@pytest.mark.parametrize("name", BAD_TEXTS)
def test_a_controller_whose_name_would_harm_is_refused_in_one_line(tmp_path, name, one_line_error):
    path = tmp_path / "controller.json"
    path.write_text(json.dumps({**json.loads(text()), "name": name}))
    refused("which no text of such a file has", controller_file.load, path)
    assert f"{path} is damaged: its text " in one_line_error("simulate", str(path))


# Records.


def damaged_record(folder: Path, **changes: Any) -> Path:
    """A record with made-up numbers and some entries changed, its checksum right."""
    import dataclasses

    record = dataclasses.replace(made_up(plan("smoke").units[0]), **changes)
    record.result.write(folder / "a.npz")
    return folder / "a.npz"


def configuration(**changes: Any) -> dict[str, Any]:
    return {**plan("smoke").units[0].configuration, **changes}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"configuration": [1]}, "its configuration is [1]; it must be an object"),
        (
            {"configuration": configuration(experiment={"name": 3, "omega": None})},
            "its configuration.experiment.name is 3",
        ),
        ({"configuration": configuration(budgets=None)}, "its configuration.budgets is None"),
        ({"configuration": configuration(algorithm={})}, "'configuration.algorithm.population'"),
        ({"configuration": configuration(experiment=[])}, "its configuration.experiment is []"),
        ({"software": {"engine": None}}, "an entry is null; it must be a text"),
        ({"software": {"jax": "1"}}, "it does not name its engine"),
        ({"software": {"engine": "xla", "\x1b[31m": "1"}}, "which no text of such a file has"),
        ({"weights": np.zeros(3)}, "its weights has float64 values of shape (3,)"),
        ({"best_fitness": np.array(["a", "b"])}, "its best_fitness has <U1 values"),
        ({"best_fitness": np.zeros(0)}, "it has no runs"),
        ({"ended": np.zeros(2)}, "its ended has float64 values"),
        ({"curves": {"centre_fitness": np.zeros((3, 5))}}, "where (3, 2) belong"),
        ({"episodes": {"cot_inverse": np.zeros((2, 7))}}, "its cot_inverse has"),
        ({"at_budgets": {"cot_inverse": np.zeros((4, 2, 2))}}, "where (1, 2, 2) belong"),
    ],
)
def test_a_record_with_a_right_checksum_is_held_against_its_schema(tmp_path, changes, message):
    with pytest.raises(DamagedDocumentError) as raised:
        read_record(damaged_record(tmp_path, **changes))
    assert message in str(raised.value)


def test_a_record_that_would_unpack_to_gigabytes_is_not_unpacked(tmp_path, monkeypatch):
    path = damaged_record(tmp_path, weights=np.zeros((2, 4_000_000)))
    assert path.stat().st_size < 200_000
    monkeypatch.setattr("tegotae.study.MOST_BYTES", 2**24)
    monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("it was unpacked"))
    with pytest.raises(DamagedDocumentError, match=r"it unpacks to 61\.1 MiB, more"):
        read_record(path)


@pytest.mark.parametrize("content", [b"", b"PK\x05\x06", b"hello", struct.pack("<8I", *range(8))])
def test_what_is_no_archive_is_a_value_error(content):
    with pytest.raises(ValueError, match=r"."):
        read_arrays(BytesIO(content), 2**20)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads anything")
def test_a_record_without_permission_is_not_called_damaged(tmp_path):
    path = damaged_record(tmp_path)
    path.chmod(0)
    with pytest.raises(TegotaeError, match=r"^cannot read .*: Permission denied$") as raised:
        read_record(path)
    assert not isinstance(raised.value, DamagedDocumentError)


@pytest.mark.parametrize("text", ["<!--<script>", "</script>", "<!--", "]]>", "\u2028", "&lt;"])
def test_no_text_of_a_record_ends_or_opens_the_scripts_of_the_report(text):
    script = as_script({"software": {text: text}})
    assert "<" not in script
    assert ">" not in script
    assert json.loads(script) == {"software": {text: text}}
