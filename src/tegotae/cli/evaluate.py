"""Metrics on the command line: by name, or a user's own as FILE.py:OBJECT."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from tegotae._support import tables
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.files import output_file
from tegotae._support.limits import MOST_RAD_PER_S
from tegotae.cli.extras import require_environments
from tegotae.cli.options import (
    UNSET,
    BodyOptions,
    ProtocolOptions,
    refuse_given,
    refuse_on_environment,
    require_ours,
)
from tegotae.measures.hopping.metric import Metric
from tegotae.measures.hopping.registry import chosen, register
from tegotae.systems import user_objects as references
from tegotae.systems.legged import Legged
from tegotae.systems.resolve import Resolved, resolve
from tegotae.training.collection import sets_of


def named(given: Sequence[str]) -> tuple[Metric, ...] | None:
    """The metrics that were named; None if none was, which stands for all.

    A user's own, given as FILE.py:OBJECT or MODULE:OBJECT, is registered.

    Raises:
        TegotaeError: for a name or a file that is not there, or an object that is no metric.
    """
    if not given:
        return None
    return chosen([_name(each) for each in given])


def _name(given: str) -> str:
    if not references.is_reference(given):
        return given
    return register(references.named(given, Metric, "metric")).name


OF_ONE_LEG = ("drop", "undisturbed", "disturbed", "work", "metric")
OF_SEVERAL = ("starts", "seed")
ON_ENVIRONMENTS = ("place", "omega", "settings", "starts", "json", "csv")


@dataclass(frozen=True, kw_only=True)
class Evaluate(ProtocolOptions, BodyOptions):
    """Evaluate controllers: the hopping of one leg, or how several legs walk.

    One leg: as in the paper, at five frequencies and with a drop of the ground. Several legs: from
    the same random phases for all, with falls, speed, cost of transport, time to lock and gait. A
    controller that was trained on an environment runs there again, with fitness, return, distance,
    work and hops.

    Settings are those of the controller's system and of its experiment's protocol; options replace
    single ones. Numbers are means over the runs of a set with their 95 % intervals; a single run
    has none.
    """

    place: Annotated[str, tyro.conf.Positional]
    """A controller file, a folder, or another name with weights, such as V-sector-w4, quadruped-c
    or FILE.py:OBJECT."""
    omega: Annotated[tuple[float, ...], UNSET] = ()
    """Frequency [rad/s] around which one leg is evaluated, or frequencies for several legs; by
    default the frequency of the training."""
    undisturbed: Annotated[float | None, UNSET] = None
    """Time from the release to the drop [s], for one leg; by default the protocol's."""
    disturbed: Annotated[float | None, UNSET] = None
    """Time from the drop to the end [s]; by default the protocol's."""
    metric: Annotated[tuple[str, ...], UNSET] = ()
    """Compute only these metrics of one leg: names, your own as FILE.py:OBJECT, or all. Without the
    option, all are computed and the usual ones shown."""
    settings: Annotated[tuple[str, ...], UNSET] = ()
    """Settings of the environment that differ from the training: NAME=VALUE, such as noise=0.02 or
    mass_factor=1.2."""
    starts: int = 32
    """Number of releases per controller, for several legs or an environment with noise."""
    seed: int = 1
    """Seed of the random phases at release, for several legs."""
    json: bool = False
    """Print one JSON object."""
    csv: Annotated[Path | None, UNSET] = None
    """Write a row per run to this file; for several legs, a row per run and frequency."""

    def run(self) -> None:
        """Evaluate, and print."""
        for omega in self.omega:
            require_finite("omega", omega, above=0.0, most=MOST_RAD_PER_S)
        found = resolve(self.place)
        if found.is_on_environment:
            self._on_environment(found)
            return
        require_ours(found)
        several = found.body.limbs > 1
        if self.settings:
            raise TegotaeError("--settings is for controllers that were trained on an environment")
        refuse_given(self, OF_ONE_LEG if several else OF_SEVERAL, self.place, several)
        if self.csv is not None:
            output_file(self.csv)
        if several:
            self._walking(found)
        else:
            self._hopping(found)

    def _on_environment(self, found: Resolved) -> None:
        require_environments(saved.task for _, saved in found.controllers)
        from tegotae.cli import wired as on_environment

        refuse_on_environment(self, ON_ENVIRONMENTS, self.place)
        sets = sets_of(found)
        on_environment.require_environment(sets, self.place)
        if self.csv is not None:
            output_file(self.csv)
        rows = on_environment.evaluate_all(sets, self.starts, self.settings, self.omega)
        if self.csv is not None:
            on_environment.write(rows, self.csv)
        if self.json:
            on_environment.print_json(rows)
            return
        on_environment.print_table(rows)

    def _hopping(self, found: Resolved) -> None:
        from tegotae.cli import hopping as one_leg

        if len(self.omega) > 1:
            raise TegotaeError("--omega has several frequencies; one leg is evaluated around one")
        times = {"undisturbed_s": self.undisturbed, "disturbed_s": self.disturbed}
        protocol = self.changed(times)
        asked = named(self.metric)
        sets = [runs.replaced(body=self.in_place_of(runs.body)) for runs in sets_of(found)]
        omega = self.omega[0] if self.omega else None
        results = one_leg.evaluate_all(sets, protocol, omega, asked)
        if self.csv is not None:
            tables.write_csv(self.csv, one_leg.columns(results))
        if self.json:
            listed = [{"name": r.name, "labels": r.labels, **e.to_dict()} for r, e in results]
            print(json.dumps({"controllers": listed}))
            return
        one_leg.print_table(results, one_leg.shown(asked))

    def _walking(self, found: Resolved) -> None:
        from tegotae.cli import walking as several_legs

        sets = [
            (name, labels, self._on_body(legged), weights)
            for name, labels, legged, weights in several_legs.subjects(found)
        ]
        evaluations = several_legs.evaluate_all(sets, self.omega, self.starts, self.seed)
        if self.csv is not None:
            tables.write_csv(self.csv, several_legs.columns(evaluations), digits=6)
        if self.json:
            print(json.dumps({"controllers": several_legs.listed(evaluations)}))
            return
        several_legs.print_table(evaluations)

    def _on_body(self, legged: Legged) -> Legged:
        body = self.in_place_of(legged.body)
        return legged if body is legged.body else legged.with_body(body)
