"""Recordings of real robots: files, columns, quantities and units."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require, require_finite, unknown
from tegotae._support.files import read_arrays
from tegotae._support.tables import number, read_csv

_LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_FORCE = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "MN": 1e6}
_ENERGY = {"J": 1.0, "kJ": 1e3, "mJ": 1e-3, "MJ": 1e6}


class Quantity(NamedTuple):
    """Something that may be recorded."""

    names: tuple[str, ...]
    """Names of its column, without the unit."""
    units: Mapping[str, float]
    """Its units in those of the SI, whose own is the first."""

    def of(self, unit: str) -> float | None:
        """A unit in that of the SI; None if it is no unit of this.

        Capitals count only where they distinguish two units, as those of mN and MN do.
        """
        alike = [known for known in self.units if known.lower() == unit.lower()]
        if len(alike) > 1:
            alike = [known for known in alike if known[0] == unit[0]]
        return self.units[alike[0]] if alike else None

    @property
    def si(self) -> str:
        """Its unit of the SI."""
        return next(iter(self.units))


QUANTITIES = {
    "time": Quantity(("time", "t"), {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}),
    "height": Quantity(("height", "y"), _LENGTH),
    "ground": Quantity(("ground",), _LENGTH),
    "phase": Quantity(("phase",), {"rad": 1.0, "deg": np.pi / 180.0}),
    "force": Quantity(("actuator_force", "force"), _FORCE),
    "spring_force": Quantity(("spring_force",), _FORCE),
    "command": Quantity(("command",), {"share": 1.0, "percent": 1e-2}),
    "work": Quantity(("work",), _ENERGY),
    "climb_flight": Quantity(("climb_flight",), _LENGTH),
    "climb": Quantity(("climb",), _LENGTH),
}
"""The quantities of a recording, by their names in commands."""
OF_A_GAIT = tuple(name for name in QUANTITIES if name not in ("spring_force", "command"))
"""Those that `tegotae.measures.hopping.measure` takes."""


def split(column: str) -> tuple[str, str]:
    """A column's name in small letters, and its unit, if its name has one.

    Example:
        >>> split("Height (mm)"), split("height_mm"), split("height")
        (('height', 'mm'), ('height', 'mm'), ('height', ''))
    """
    name, unit = in_brackets(column)
    plain = re.sub(r"\W+", "_", name.strip()).strip("_")
    if unit:
        return plain.lower(), unit
    stem, _, ending = plain.rpartition("_")
    return (stem.lower(), ending) if stem else (plain.lower(), "")


def in_brackets(text: str) -> tuple[str, str]:
    """The text before brackets at the end, and that in them."""
    match = re.fullmatch(r"(.*?)\s*[\[(](\w*)[\])]\s*", text)
    return (match.group(1), match.group(2)) if match else (text, "")


MOST_BYTES = 2**30
"""Size limit of all arrays of a .npz together [bytes]: hours of a robot's log."""
_NEEDED = {*QUANTITIES["time"].names, *QUANTITIES["height"].names}


def read_columns(path: Path | str) -> dict[str, np.ndarray]:
    """The columns of a file by name, as they are: texts or numbers.

    Args:
        path: a .csv with a row of names, a .npz of arrays of one dimension, or a .parquet (extra
            "study").

    Raises:
        TegotaeError: for another ending, a file that cannot be read, or arrays of other shapes.
        MissingExtraError: for Parquet without pyarrow.

    Example:
        >>> np.savez("walk.npz", time_s=np.arange(3) * 0.01, height_m=np.ones(3))
        >>> list(read_columns("walk.npz"))
        ['time_s', 'height_m']
    """
    path = Path(path)
    read = FORMATS.get(path.suffix.lower())
    if read is None:
        raise TegotaeError(
            f"{path} is no recording: its name must end in {', '.join(FORMATS)}, and it ends in "
            f"{path.suffix or 'nothing'}"
        )
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    return read(path)


def _npz(path: Path) -> dict[str, np.ndarray]:
    try:
        columns = read_arrays(path, MOST_BYTES)
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError as error:
        raise TegotaeError(f"{path} is no recording: no .npz of plain arrays ({error})") from None
    # One number, such as a rate, is no column; and one column more in a matrix is still one.
    columns = {name: np.squeeze(column) for name, column in columns.items()}
    for name, column in columns.items():
        if column.ndim > 1 and split(name)[0] in _NEEDED:
            raise TegotaeError(
                f"{path} is no recording: {name} has the shape {column.shape}; it must be one "
                "number a sample"
            )
    kept = {name: column for name, column in columns.items() if column.ndim == 1}
    if not kept:
        raise TegotaeError(f"{path} is no recording: it holds no array of one dimension")
    return kept


def _parquet(path: Path) -> dict[str, np.ndarray]:
    arrow = require("pyarrow", "study")
    try:
        table = pd.read_parquet(path, engine="pyarrow")
    except (OSError, arrow.ArrowException) as error:
        first = str(error).splitlines()[0]
        raise TegotaeError(f"{path} is no recording: {first}") from None
    return {str(name): table[name].to_numpy() for name in table}


FORMATS: dict[str, Callable[[Path], dict[str, np.ndarray]]] = {
    ".csv": partial(read_csv, kind="recording"),
    ".npz": _npz,
    ".parquet": _parquet,
}
"""The reader of each ending."""


def recording(
    columns: Mapping[str, Collection[object]],
    named: Sequence[str] = (),
    *,
    rate_hz: float | None = None,
    kept: Collection[str] = OF_A_GAIT,
) -> pd.DataFrame:
    """The recorded gait in some columns, in SI units, for `tegotae.measures.hopping.measure`.

    A column is known by its name with its unit, as `height_m`, `height_mm`, `height [mm]` or
    `Height (mm)`. Columns of other names are left alone, unless they are named.

    Args:
        columns: arrays of one length, by name.
        named: which column is what, `QUANTITY=COLUMN` or `QUANTITY=COLUMN[UNIT]`.
        rate_hz: samples a second, where there is no column of times.
        kept: the quantities that are read, of `QUANTITIES`.

    Returns:
        A row a sample: `time_s` and `height_m`, and what there is of `ground_m`, `phase_rad`,
        `force_n`, `work_j`, `climb_flight_m` and `climb_m`.

    Raises:
        TegotaeError: if there is no height, no time, two columns for one quantity or one for two, a
            unit that is not known, a cell that is no number, columns of several lengths, or too few
            samples.

    Example:
        >>> table = {"t [ms]": [0, 10, 20], "com": [990.0, 1000.0, 1010.0]}
        >>> recording(table, ["height=com[mm]"]).height_m.tolist()
        [0.99, 1.0, 1.01]
    """
    chosen = {name: found for name, found in _chosen(columns, named).items() if name in kept}
    if "height" not in chosen:
        raise _lacking("height", columns)
    if "time" not in chosen and rate_hz is None:
        raise _lacking("time", columns, ", or give the rate of the samples: --rate HZ")
    if "time" in chosen and rate_hz is not None:
        raise TegotaeError(
            f"column {chosen['time'][0]!r} holds the times; --rate is for columns without any"
        )
    values = {
        f"{quantity}_{QUANTITIES[quantity].si.lower()}": unit * _numbers_of(name, columns[name])
        for quantity, (name, unit) in chosen.items()
    }
    lengths = {name: len(columns[name]) for name, _ in chosen.values()}
    if len({*lengths.values()}) > 1:
        held = ", ".join(f"{size} in {name!r}" for name, size in lengths.items())
        raise TegotaeError(f"the columns hold {held} samples; all must be of one length")
    samples = next(iter(lengths.values()))
    if samples < _LEAST_SAMPLES:
        raise TegotaeError(
            f"the recording holds {samples} samples; it must have at least {_LEAST_SAMPLES}"
        )
    if rate_hz is not None:
        require_finite("rate", rate_hz, above=0.0, most=1e6)
        values["time_s"] = np.arange(samples) / rate_hz
    return pd.DataFrame(values)


_LEAST_SAMPLES = 3


def resampled(samples: pd.DataFrame, rate_hz: float) -> pd.DataFrame:
    """A recording at uniform times, by linear interpolation, which needs increasing ones.

    Args:
        samples: from `recording`.
        rate_hz: samples a second.

    Raises:
        TegotaeError: for a rate that is not positive, times that do not increase, or values that
            are not finite.
    """
    require_finite("resample", rate_hz, above=0.0, most=1e6)
    before = samples["time_s"].to_numpy()
    if not np.isfinite(before).all() or not (np.diff(before) > 0.0).all():
        raise TegotaeError("the times do not increase; sort the recording before --resample")
    count = int((before[-1] - before[0]) * rate_hz + 1e-9) + 1
    time_s = before[0] + np.arange(count) / rate_hz

    def at_times(name: str) -> np.ndarray:
        values = samples[name].to_numpy()
        sound = np.isfinite(values)
        if not sound.all():
            row = int(np.argmin(sound))
            raise TegotaeError(f"{name} is {values[row]} at sample {row}; fill the gap or cut")
        values = np.unwrap(values) if name == "phase_rad" else values
        return np.interp(time_s, before, values)

    return pd.DataFrame({name: at_times(name) for name in samples} | {"time_s": time_s})


def left_alone(columns: Mapping[str, Collection[object]], named: Sequence[str] = ()) -> list[str]:
    """A line on every column that has a quantity's name, and is not read since its unit is unknown.

    Args:
        columns: arrays by name, as for `recording`.
        named: which column is what, as for `recording`.

    Example:
        >>> left_alone({"time_s": [], "height_m": [], "force": []})
        ["column 'force' is without a unit and is left alone; say it: --columns force=force[N]"]
    """
    chosen = _chosen(columns, named)
    lines = []
    for column in columns:
        name, unit = split(column)
        whole = f"{name}_{unit}".lower().strip("_")
        for quantity, known in QUANTITIES.items():
            if quantity in chosen or not {name, whole} & {*known.names}:
                continue
            given = _given("" if whole in known.names else unit)
            lines.append(
                f"column {column!r} is {given} and is left alone; say it: --columns "
                f"{quantity}={column}[{known.si}]"
            )
    return lines


def _given(unit: str) -> str:
    return f"in {unit!r}" if unit else "without a unit"


def _numbers_of(name: str, column: Collection[object]) -> np.ndarray:
    """A column as float64, NaN where a cell is empty.

    Raises:
        TegotaeError: for a cell that is no number.
    """
    cells = np.asarray(column)
    if cells.dtype.kind in "fiub":
        return cells.astype(float)
    values = np.full(len(cells), np.nan)
    for row, cell in enumerate(cells.tolist()):
        text = str(cell).strip()
        try:
            values[row] = number(text) if text and cell is not None else np.nan
        except ValueError:
            raise TegotaeError(f"{name} is {text!r} in row {row}, which is no number") from None
    return values


def _chosen(
    columns: Mapping[str, Collection[object]], named: Sequence[str]
) -> dict[str, tuple[str, float]]:
    """Column and unit of every quantity: as named, or else by the columns' own names."""
    chosen: dict[str, tuple[str, float]] = {}
    for words in named:
        quantity, column, scale = _named(columns, words)
        if quantity in chosen:
            raise TegotaeError(
                f"the {quantity} is named twice, {chosen[quantity][0]!r} and {column!r}; name one"
            )
        for other, (taken, _) in chosen.items():
            if taken == column:
                raise TegotaeError(
                    f"column {column!r} is named for two quantities, {other} and {quantity}; it "
                    "can be one of them"
                )
        chosen[quantity] = (column, scale)
    taken = {column for column, _ in chosen.values()}
    known: dict[str, tuple[str, float]] = {}
    for column in (column for column in columns if column not in taken):
        name, unit = split(column)
        for quantity, what in QUANTITIES.items():
            own_scale = what.of(unit)
            if quantity in chosen or name not in what.names or own_scale is None:
                continue
            if quantity in known:
                raise TegotaeError(
                    f"columns {known[quantity][0]!r} and {column!r} may both be the {quantity}; "
                    f"say which, such as --columns {quantity}={column}"
                )
            known[quantity] = (column, own_scale)
    return known | chosen


def _named(columns: Mapping[str, Collection[object]], words: str) -> tuple[str, str, float]:
    """Quantity, column and unit of `QUANTITY=COLUMN[UNIT]`."""
    quantity, _, column = words.partition("=")
    if not column:
        raise TegotaeError(f"{words!r} names no column; write QUANTITY=COLUMN[UNIT]")
    if quantity not in QUANTITIES:
        raise unknown("quantity", quantity, QUANTITIES)
    # The unit is part of the column's name, or said behind it.
    column, unit = (column, split(column)[1]) if column in columns else in_brackets(column)
    if column not in columns:
        raise unknown("column", column, columns)
    scale = QUANTITIES[quantity].of(unit)
    if scale is None:
        raise TegotaeError(
            f"column {column!r} is {_given(unit)}; say which of "
            f"{', '.join(QUANTITIES[quantity].units)} it is, such as "
            f"--columns {quantity}={column}[{QUANTITIES[quantity].si}]"
        )
    return quantity, column, scale


def _lacking(
    quantity: str, columns: Mapping[str, Collection[object]], otherwise: str = ""
) -> TegotaeError:
    what, names = QUANTITIES[quantity], [*columns]
    listed = ", ".join(map(repr, names[:12])) + (", ..." if len(names) > 12 else "")
    return TegotaeError(
        f"no column is the {quantity} ({what.names[0]}_{'/'.join(what.units)}) among {listed}; "
        f"name it: --columns {quantity}=COLUMN[UNIT]{otherwise}"
    )
