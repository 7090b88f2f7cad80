"""Recordings of real robots: files, columns, quantities and units."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require, require_finite, require_known, unknown
from tegotae._support.files import read_arrays
from tegotae._support.progress import note
from tegotae._support.tables import parse_number
from tegotae.measures.log_csv import is_clock, read_log
from tegotae.measures.plausibility import check_plausible, doubts

_LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_KGF_N = 9.80665
_FORCE = {
    **{"N": 1.0, "kN": 1e3, "mN": 1e-3, "MN": 1e6},
    **{"kgf": _KGF_N, "kg": _KGF_N, "gf": 1e-3 * _KGF_N, "g": 1e-3 * _KGF_N},
}
_ENERGY = {"J": 1.0, "kJ": 1e3, "mJ": 1e-3, "MJ": 1e6}


class Quantity(NamedTuple):
    """Something that may be recorded."""

    names: tuple[str, ...]
    """Names of its column, without the unit."""
    units: Mapping[str, float]
    """Its units in those of the SI, whose own is the first."""

    def scale_of(self, unit: str) -> float | None:
        """Return the factor from a unit to the SI, or None if it is no unit of this quantity.

        Capitals count only where they distinguish two units, as those of mN and MN do.
        """
        matches = [candidate for candidate in self.units if candidate.lower() == unit.lower()]
        if len(matches) > 1:
            matches = [candidate for candidate in matches if candidate[0] == unit[0]]
        return self.units[matches[0]] if matches else None

    @property
    def si(self) -> str:
        """Unit of the quantity in the SI."""
        return next(iter(self.units))


QUANTITIES = {
    "time": Quantity(("time", "t"), {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}),
    "height": Quantity(("height", "y"), _LENGTH),
    "ground": Quantity(("ground",), _LENGTH),
    "phase": Quantity(("phase",), {"rad": 1.0, "deg": np.pi / 180.0}),
    "force": Quantity(("actuator_force", "force"), _FORCE),
    "spring_force": Quantity(("spring_force",), _FORCE),
    "command": Quantity(("command",), {"share": 1.0, "percent": 1e-2, "%": 1e-2}),
    "work": Quantity(("work",), _ENERGY),
    "climb_flight": Quantity(("climb_flight",), _LENGTH),
    "climb": Quantity(("climb",), _LENGTH),
}
"""The quantities of a recording, by their names in commands."""
OF_A_GAIT = tuple(name for name in QUANTITIES if name not in ("spring_force", "command"))
"""Those that `tegotae.measures.hopping.measure` takes."""


def split_unit(column: str) -> tuple[str, str]:
    """Split a column's name into its small letters and its unit, if it has one.

    Example:
        >>> split_unit("Height (mm)"), split_unit("height_mm"), split_unit("height")
        (('height', 'mm'), ('height', 'mm'), ('height', ''))
    """
    name, unit = in_brackets(column)
    plain = re.sub(r"\W+", "_", name.strip()).strip("_")
    if unit:
        return plain.lower(), unit
    stem, _, ending = plain.rpartition("_")
    return (stem.lower(), ending) if stem else (plain.lower(), "")


def in_brackets(text: str) -> tuple[str, str]:
    """Return the text before the brackets at the end, and the text in them."""
    match = re.fullmatch(r"(.*?)\s*[\[(]([\w%]*)[\])]\s*", text)
    return (match.group(1), match.group(2)) if match else (text, "")


MOST_BYTES = 2**30
"""Size limit of all arrays of a .npz together [bytes]: hours of a robot's log."""
_NEEDED = {*QUANTITIES["time"].names, *QUANTITIES["height"].names}


def read_columns(path: Path | str) -> Mapping[str, np.ndarray | pd.Series]:
    """Return the columns of a file by name, unconverted: texts or numbers.

    Args:
        path: a .csv with a row of names (`tegotae.measures.log_csv`), a .npz of arrays of one
            dimension, or a .parquet (extra "study").

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
        if column.ndim > 1 and split_unit(name)[0] in _NEEDED:
            raise TegotaeError(
                f"{path} is no recording: {name} has the shape {column.shape}; it must be one "
                "number a sample"
            )
    vectors = {name: column for name, column in columns.items() if column.ndim == 1}
    if not vectors:
        raise TegotaeError(f"{path} is no recording: it holds no array of one dimension")
    return vectors


def _parquet(path: Path) -> dict[str, np.ndarray]:
    arrow = require("pyarrow", "study")
    try:
        table = pd.read_parquet(path, engine="pyarrow")
    except (OSError, arrow.ArrowException) as error:
        first = str(error).splitlines()[0]
        raise TegotaeError(f"{path} is no recording: {first}") from None
    return {str(name): table[name].to_numpy() for name in table}


FORMATS: dict[str, Callable[[Path], Mapping[str, np.ndarray | pd.Series]]] = {
    ".csv": partial(
        read_log, units=[unit for entry in QUANTITIES.values() for unit in entry.units]
    ),
    ".npz": _npz,
    ".parquet": _parquet,
}
"""The reader of each ending."""


def recording(
    columns: Mapping[str, Collection[object]],
    assignments: Sequence[str] = (),
    *,
    rate_hz: float | None = None,
    quantities: Collection[str] = OF_A_GAIT,
    needed: Sequence[str] = ("height",),
) -> pd.DataFrame:
    """Return the gait recorded in some columns, in SI units, for
    `tegotae.measures.hopping.measure`.

    A column is known by its name with its unit, as `height_m`, `height_mm`, `height [mm]` or
    `Height (mm)`. Columns of other names are left alone, unless they are named.

    Args:
        columns: arrays of one length, by name.
        assignments: columns of quantities, `QUANTITY=COLUMN` or `QUANTITY=COLUMN[UNIT]`, with a
            minus before the column if it points the other way.
        rate_hz: samples a second, where there is no column of times.
        quantities: the quantities that are read, of `QUANTITIES`.
        needed: those of them that must be there, beside the time.

    Returns:
        A row a sample: `time_s` and `height_m`, and what there is of `ground_m`, `phase_rad`,
        `force_n`, `work_j`, `climb_flight_m` and `climb_m`. Samples with an empty cell are left out
        where the others have uniform times, as columns of several rates have. Times of day count
        from the first.

    Raises:
        TegotaeError: if there is no height, no time, two columns for one quantity or one for two, a
            unit that is not known, a cell that is no number, columns of several lengths, too few
            samples, or what no body and sensor make (`tegotae.measures.plausibility`).

    Example:
        >>> table = {"t [ms]": [0, 10, 20], "com": [990.0, 1000.0, 1010.0]}
        >>> recording(table, ["height=com[mm]"]).height_m.tolist()
        [0.99, 1.0, 1.01]
    """
    sources = {
        name: source
        for name, source in _sources(columns, assignments).items()
        if name in quantities
    }
    for quantity in needed:
        if quantity not in sources:
            raise _lacking(quantity, columns)
    if "time" not in sources and rate_hz is None:
        raise _lacking("time", columns, ", or give the rate of the samples: --rate HZ")
    if "time" in sources and rate_hz is not None:
        raise TegotaeError(
            f"column {sources['time'].column!r} holds the times; --rate is for columns without any"
        )
    values = {
        f"{quantity}_{QUANTITIES[quantity].si.lower()}": place.numbers(columns[place.column])
        for quantity, place in sources.items()
    }
    lengths = {place.column: len(columns[place.column]) for place in sources.values()}
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
    table = _without_empty_rows(pd.DataFrame(values))
    check_plausible(table)
    return table


_LEAST_SAMPLES = 3
_UNIFORM = 0.01


def _without_empty_rows(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows without an empty cell, if their times are uniform."""
    complete = table.dropna()
    steps = np.diff(complete["time_s"])
    if len(complete) < _LEAST_SAMPLES or np.ptp(steps) > 2.0 * _UNIFORM * steps.mean():
        return table
    return complete.reset_index(drop=True)


def read_recording(
    path: Path | str,
    assignments: Sequence[str] = (),
    *,
    rate_hz: float | None = None,
    resample_hz: float | None = None,
    quantities: Collection[str] = OF_A_GAIT,
    needed: Sequence[str] = ("height",),
) -> pd.DataFrame:
    """Read the recording in a file, and report ignored or odd columns on standard error.

    Args:
        path: as of `read_columns`.
        assignments: as of `recording`.
        rate_hz: as of `recording`.
        resample_hz: rate for `resampled`; None to leave the times as they are.
        quantities: as of `recording`.
        needed: as of `recording`.

    Raises:
        TegotaeError: for what `read_columns`, `recording` or `resampled` refuse.
    """
    table = read_columns(path)
    samples = recording(table, assignments, rate_hz=rate_hz, quantities=quantities, needed=needed)
    lines = left_alone(table, assignments)
    count = len(next(iter(table.values())))
    if len(samples) < count:
        lines.append(
            f"{count - len(samples)} of {count} samples have an empty cell and are left out"
        )
    for line in [*lines, *doubts(samples)]:
        note(f"tegotae: {line}")
    return samples if resample_hz is None else resampled(samples, resample_hz)


def resampled(samples: pd.DataFrame, rate_hz: float) -> pd.DataFrame:
    """Resample a recording at uniform times by linear interpolation, which needs increasing times.

    Every column is interpolated over its own samples, without its empty cells, and a command is
    held until its next one.

    Args:
        samples: from `recording`.
        rate_hz: samples a second.

    Raises:
        TegotaeError: for a rate that is not positive, times that do not increase, or values that
            are infinite or all missing.
    """
    require_finite("resample", rate_hz, above=0.0, most=1e6)
    times = samples["time_s"].to_numpy()
    check_plausible(samples)
    held = {str(name): times[samples[name].notna()] for name in samples}
    begin = max(at[0] for at in held.values() if len(at))
    end = min(at[-1] for at in held.values() if len(at))
    time_s = begin + np.arange(int((end - begin) * rate_hz + 1e-9) + 1) / rate_hz

    def at_times(name: str) -> np.ndarray:
        values = samples[name].dropna().to_numpy()
        if not len(values) or np.isinf(values).any():
            raise TegotaeError(f"{name} has no finite values; name another column")
        if name == "command_share":
            return values[np.searchsorted(held[name], time_s + 1e-9, "right") - 1]
        return np.interp(time_s, held[name], np.unwrap(values) if name == "phase_rad" else values)

    return pd.DataFrame({name: at_times(name) for name in held} | {"time_s": time_s})


def left_alone(
    columns: Mapping[str, Collection[object]], assignments: Sequence[str] = ()
) -> list[str]:
    """Return a line for every column that has a quantity's name but is not read since its unit is
    unknown.

    Args:
        columns: arrays by name, as for `recording`.
        assignments: which column is what, as for `recording`.

    Example:
        >>> left_alone({"time_s": [], "height_m": [], "force": []})
        ["column 'force' is without a unit and is left alone; say it: --columns force=force[N]"]
    """
    sources = _sources(columns, assignments)
    lines = []
    for column in columns:
        name, unit = split_unit(column)
        full_name = f"{name}_{unit}".lower().strip("_")
        for quantity, entry in QUANTITIES.items():
            if quantity in sources or not {name, full_name} & {*entry.names}:
                continue
            spelling = _with_unit("" if full_name in entry.names else unit)
            lines.append(
                f"column {column!r} is {spelling} and is left alone; say it: --columns "
                f"{quantity}={column}[{entry.si}]"
            )
    return lines


def _with_unit(unit: str) -> str:
    return f"in {unit!r}" if unit else "without a unit"


@dataclass(frozen=True)
class _Source:
    """Place at which a quantity is read.

    Args:
        column: its column.
        scale: its unit in that of the SI, negative for a column that points the other way.
    """

    column: str
    scale: float

    def numbers(self, column: Collection[object]) -> np.ndarray:
        """Return the column in SI units as float64, NaN where a cell is empty.

        Raises:
            TegotaeError: for a cell that is no number.
        """
        cells = np.asarray(column)
        if cells.dtype.kind in "fiub":
            return self.scale * cells.astype(float)
        if _is_clock(cells):
            stamps = pd.to_datetime(pd.Series(cells), utc=True, format="ISO8601", errors="coerce")
            if stamps.isna().any():
                row = int(np.argmax(stamps.isna()))
                raise TegotaeError(
                    f"{self.column} is {str(cells[row])!r} in {_place(column, row)}, which is no "
                    "time by ISO 8601"
                )
            return ((stamps - stamps.iloc[0]) / pd.Timedelta(seconds=1)).to_numpy(float)
        values = np.full(len(cells), np.nan)
        for row, cell in enumerate(cells.tolist()):
            text = str(cell).strip()
            try:
                values[row] = parse_number(text) if text and cell is not None else np.nan
            except ValueError:
                raise TegotaeError(
                    f"{self.column} is {text!r} in {_place(column, row)}, which is no number; "
                    "correct the cell, or leave it empty"
                ) from None
        return self.scale * values


def _place(column: Collection[object], row: int) -> str:
    """Return the line of a file if it is known, or else the row."""
    return f"line {column.index[row]}" if isinstance(column, pd.Series) else f"row {row}"


def _is_clock(column: Collection[object]) -> bool:
    """Return whether a column holds times of day, and so needs no unit."""
    cells = np.asarray(column)
    return cells.dtype.kind == "M" or (len(cells) > 0 and is_clock(cells[0]))


def _scale_of(quantity: str, column: Collection[object], unit: str) -> float | None:
    """Return the factor from a column's unit to the SI, or None if it is no unit of the
    quantity.
    """
    if quantity == "time" and _is_clock(column):
        return 1.0
    return QUANTITIES[quantity].scale_of(unit)


def _sources(
    columns: Mapping[str, Collection[object]], assignments: Sequence[str]
) -> dict[str, _Source]:
    """Return column and unit of every quantity: the assigned ones, or else those of the
    columns' own names.
    """
    sources: dict[str, _Source] = {}
    for words in assignments:
        quantity, source = _assignment(columns, words)
        if quantity in sources:
            raise TegotaeError(
                f"the {quantity} is named twice, {sources[quantity].column!r} and "
                f"{source.column!r}; name one"
            )
        for earlier, taken in sources.items():
            if taken.column == source.column:
                raise TegotaeError(
                    f"column {source.column!r} is named for two quantities, {earlier} and "
                    f"{quantity}; it can be one of them"
                )
        sources[quantity] = source
    taken = {source.column for source in sources.values()}
    matches: dict[str, _Source] = {}
    for column in (column for column in columns if column not in taken):
        name, unit = split_unit(column)
        for quantity, entry in QUANTITIES.items():
            scale = _scale_of(quantity, columns[column], unit)
            if quantity in sources or name not in entry.names or scale is None:
                continue
            if quantity in matches:
                raise TegotaeError(
                    f"columns {matches[quantity].column!r} and {column!r} may both be the "
                    f"{quantity}; say which, such as --columns {quantity}={column}"
                )
            matches[quantity] = _Source(column, scale)
    return matches | sources


def _assignment(columns: Mapping[str, Collection[object]], words: str) -> tuple[str, _Source]:
    """Parse quantity, column and unit of `QUANTITY=COLUMN[UNIT]`."""
    quantity, _, column = str(words).partition("=")
    if not column:
        raise TegotaeError(f"{words!r} names no column; write QUANTITY=COLUMN[UNIT]")
    require_known("quantity", quantity, QUANTITIES)
    turned = column not in columns and column.startswith("-")
    column = column.removeprefix("-") if turned else column
    # The unit is part of the column's name, said behind it, or in the row below the names.
    column, unit = (column, split_unit(column)[1]) if column in columns else in_brackets(column)
    if column not in columns:
        below = [candidate for candidate in columns if in_brackets(candidate)[0] == column]
        if len(below) != 1:
            raise unknown("column", column, columns)
        column, unit = below[0], unit or in_brackets(below[0])[1]
    scale = _scale_of(quantity, columns[column], unit)
    if scale is None:
        raise TegotaeError(
            f"column {column!r} is {_with_unit(unit)}; say which of "
            f"{', '.join(QUANTITIES[quantity].units)} it is, such as "
            f"--columns {quantity}={column}[{QUANTITIES[quantity].si}]"
        )
    return quantity, _Source(column, -scale if turned else scale)


def _lacking(
    quantity: str, columns: Mapping[str, Collection[object]], otherwise: str = ""
) -> TegotaeError:
    entry, names = QUANTITIES[quantity], [*columns]
    listed = ", ".join(map(repr, names[:12])) + (", ..." if len(names) > 12 else "")
    return TegotaeError(
        f"no column is the {quantity} ({entry.names[0]}_{'/'.join(entry.units)}) among {listed}; "
        f"name it: --columns {quantity}=COLUMN[UNIT]{otherwise}"
    )
