"""`tegotae metrics`: the metrics of hopping, of walking and of robots, and a user's own."""

import json

from places import TESTS
from tegotae.cli import main
from tegotae.measures.gaits.metrics import WALKING
from tegotae.measures.hopping import HOPPING
from tegotae.measures.robots import ROBOTS

FILE = str(TESTS / "users" / "own_metrics.py")


def listed(capsys, *words: str) -> list[tuple[str, str]]:
    assert main(["metrics", *words, "--json"]) == 0
    return [(x["metric"], x["of"]) for x in json.loads(capsys.readouterr().out)["metrics"]]


def test_the_metrics_of_all_bodies_are_listed(capsys):
    rows = listed(capsys)
    assert {("t0_s", "hopping"), ("upright", "walking"), ("saturated_share", "robots")} < {*rows}
    for catalogue in (HOPPING, WALKING, ROBOTS):
        assert {(metric.name, catalogue.kind) for metric in catalogue.built_in} < {*rows}
    assert listed(capsys, "cost*") == [
        ("cost_of_transport", "walking"),
        ("cost_of_transport", "robots"),
    ]


def test_a_users_metrics_are_listed_with_their_file(capsys):
    assert listed(capsys, "largest*", "--parts", FILE) == [
        ("largest_pitch_rad", "walking"),
        ("largest_action", "robots"),
    ]
