"""A controller from elsewhere on the limbs of an environment, without training."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from tegotae._support.errors import TegotaeError, require_all
from tegotae.api.controller import Changes
from tegotae.api.parameters import check_types
from tegotae.api.results import JsonFile
from tegotae.api.wiring import DEFAULT_ENVIRONMENT, EnvironmentOptions, environment_of
from tegotae.parts.units import Units
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.env_documents import extras_of, stem_of
from tegotae.systems.resolve import law_on_robot, resolve


def _conversions(saved: SavedController, omega: float | None, units: Units) -> pd.DataFrame:
    """Return a row for each number that changes its units."""
    rows = [
        ("length", 1.0, units.length_m, "m"),
        ("time", 1.0, units.time_s, "s"),
        ("force", 1.0, units.force_n, "N"),
        ("omega", saved.omega, round(omega or 0.0, 3), "rad/s"),
    ]
    return pd.DataFrame(rows, columns=["number", "its own", "there", "unit"])


@check_types
def transfer(
    law: str,
    *,
    env: str = "",
    duration_s: float = 8.0,
    environment: EnvironmentOptions | Changes = DEFAULT_ENVIRONMENT,
) -> JsonFile:
    """Put a controller from elsewhere on the limbs of an environment, without training.

    With units in the wiring (`tegotae wiring suggest MODEL.xml --settings legs=true`) it is scaled
    by Froude's similarity: lengths over l0, times over √(l0 / g), forces over the weight. Its file
    is then a name for every command, such as simulate, evaluate or train --start.

    Args:
        law: controller with weights, by name: a file, a trained controller such as
            zoo:AR-rF+range@quadruped-c, a legged system such as quadruped-c or a template,
            FILE.toml. NAME@FILE.toml puts it on the robot of a file.
        env: environment, unless the name says the robot: a Gymnasium id, with a wiring.
        duration_s: duration of an episode [s].
        environment: wiring of the limbs, and settings of the environment.

    Raises:
        TegotaeError: for a name, a wiring or values that cannot be.

    Example:
        >>> transfer("quadruped-c@robot.toml").save("walks.json")  # doctest: +SKIP
    """
    from tegotae.training.environments.transfer import transferred

    if (on_robot := law_on_robot(law)) is not None:
        law, env = on_robot
    if not env:
        raise TegotaeError("no robot is given; name its file, LAW@FILE.toml, or an --env")
    options = environment_of(environment)
    require_all(extras_of(env))
    saved = resolve(law).controller()
    spec, wiring = options.wired(env)
    name = f"{saved.name or Path(law).stem}-on-{stem_of(env)}"
    put = transferred(saved, spec, wiring, name=name, omega=options.omega, duration_s=duration_s)
    table = pd.DataFrame() if wiring.units is None else _conversions(saved, put.omega, wiring.units)

    return JsonFile(
        raw=put,
        write=lambda path: save(put, path),
        title=f"{saved.name or law}, {put.controller.n_weights} weights, on {spec.env}",
        rows=table,
        views=[] if table.empty else [table.set_index("number")],
        notes=["Next:", "tegotae simulate FILE.json", "tegotae evaluate FILE.json"],
        data={"name": name, "omega_rad_per_s": put.omega},
    )
