"""Recordings of real robots: files, columns, quantities and units."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require, require_finite, unknown
from tegotae._support.files import read_arrays
from tegotae._support.tables import number, read_csv
from tegotae.measures.hopping.recording import Samples

_LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_FORCE = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "MN": 1e6}


@dataclass(frozen=True)
class Quantity:
    """Something that may be recorded.

    Args:
        names: by which its column is known, without the unit.
        units: how much each unit is of the SI's, the SI's first.
        about: its meaning.
    """

    names: tuple[str, ...]
    units: Mapping[str, float]
    about: str

    def of(self, unit: str) -> float | None:
        """How much a unit is of the SI's; None if it is no unit of this.

        Capitals count only where they distinguish two units, as those of mN and MN do.
        """
        alike = [known for known in self.units if known.lower() == unit.lower()]
        if len(alike) > 1:
            alike = [known for known in alike if known[0] == unit[0]]
        return self.units[alike[0]] if alike else None


QUANTITIES = {
    "time": Quantity(("time", "t"), {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}, "when"),
    "height": Quantity(("height", "y"), _LENGTH, "height of the centre of mass"),
    "ground": Quantity(("ground",), _LENGTH, "height of the ground"),
    "phase": Quantity(("phase",), {"rad": 1.0, "deg": np.pi / 180.0}, "phase of the oscillator"),
    "force": Quantity(("actuator_force", "force"), _FORCE, "actuator force"),
    "work": Quantity(
        ("work",), {"J": 1.0, "kJ": 1e3, "mJ": 1e-3, "MJ": 1e6}, "running total of the work"
    ),
    "climb_flight": Quantity(
        ("climb_flight",), _LENGTH, "running total of the heights climbed in flight"
    ),
    "climb": Quantity(("climb",), _LENGTH, "running total of all heights climbed"),
}
"""What can be measured, by the name that it has on the command line."""


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
    """What stands before brackets at the end of a text, and in them."""
    match = re.fullmatch(r"(.*?)\s*[\[(](\w*)[\])]\s*", text)
    return (match.group(1), match.group(2)) if match else (text, "")


MOST_BYTES = 2**30
"""Of all arrays of a .npz together [bytes]: hours of a robot's log."""
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


def _numbers_of(name: str, column: Iterable) -> np.ndarray:
    """A column as float64, NaN where a cell is empty.

    Raises:
        TegotaeError: for a cell that is no number.
    """
    cells = np.asarray(column)
    if cells.dtype.kind in "fiub":
        return cells.astype(float)
    found = np.full(len(cells), np.nan)
    for row, cell in enumerate(cells.tolist()):
        text = str(cell).strip()
        try:
            found[row] = number(text) if text and cell is not None else np.nan
        except ValueError:
            raise TegotaeError(f"{name} is {text!r} in row {row}, which is no number") from None
    return found


def _csv(path: Path) -> dict[str, np.ndarray]:
    return read_csv(path, kind="recording")


def _npz(path: Path) -> dict[str, np.ndarray]:
    try:
        columns = read_arrays(path, MOST_BYTES)
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError as error:
        raise TegotaeError(f"{path} is no recording: no .npz of plain arrays ({error})") from None
    # One number, such as a rate, is no column; and one column more in a matrix is still one.
    columns = {name: np.squeeze(column) for name, column in columns.items()}
    kept = {name: column for name, column in columns.items() if column.ndim == 1}
    for name, column in columns.items():
        if column.ndim > 1 and split(name)[0] in _NEEDED:
            raise TegotaeError(
                f"{path} is no recording: {name} has the shape {column.shape}; it must be one "
                "number a sample"
            )
    if not kept:
        raise TegotaeError(f"{path} is no recording: it holds no array of one dimension")
    return kept


def _parquet(path: Path) -> dict[str, np.ndarray]:
    arrow = require("pyarrow", "study")
    parquet = require("pyarrow.parquet", "study")
    try:
        table = parquet.read_table(path)
    except (OSError, arrow.ArrowException) as error:
        first = str(error).splitlines()[0]
        raise TegotaeError(f"{path} is no recording: {first}") from None
    return {
        name: np.array(table.column(name).to_pylist(), dtype=object) for name in table.column_names
    }


FORMATS: dict[str, Callable[[Path], dict[str, np.ndarray]]] = {
    ".csv": _csv,
    ".npz": _npz,
    ".parquet": _parquet,
}
"""Who reads which ending."""


_LEAST_SAMPLES = 3


@dataclass(frozen=True)
class Recording:
    """One recorded gait, in SI units: arrays of shape [samples], None for what was not recorded."""

    time_s: np.ndarray
    height_m: np.ndarray
    ground_m: np.ndarray | float = 0.0
    phase_rad: np.ndarray | None = None
    force_n: np.ndarray | None = None
    work_j: np.ndarray | None = None
    climb_flight_m: np.ndarray | None = None
    climb_m: np.ndarray | None = None

    def arguments(self) -> Samples:
        """The arguments of `tegotae.measures.hopping.measure`, by name."""
        return Samples(
            time_s=self.time_s,
            height_m=self.height_m,
            ground_m=self.ground_m,
            phase_rad=self.phase_rad,
            force_n=self.force_n,
            work_j=self.work_j,
            climb_flight_m=self.climb_flight_m,
            climb_m=self.climb_m,
        )

    def resampled(self, rate_hz: float) -> Recording:
        """The same at uniform times, by linear interpolation, which needs increasing ones.

        Raises:
            TegotaeError: for a rate that is not positive, times that do not increase, or values
                that are not finite.
        """
        require_finite("resample", rate_hz, above=0.0, most=1e6)
        if not np.isfinite(self.time_s).all() or not (np.diff(self.time_s) > 0.0).all():
            raise TegotaeError("the times do not increase; sort the recording before --resample")
        count = int((self.time_s[-1] - self.time_s[0]) * rate_hz + 1e-9) + 1
        time_s = self.time_s[0] + np.arange(count) / rate_hz

        def at_times(name: str, column: ArrayLike | None) -> ArrayLike | None:
            if column is None or np.ndim(column) == 0:
                return column
            values = np.asarray(column)
            if not np.isfinite(values).all():
                row = int(np.argmin(np.isfinite(values)))
                raise TegotaeError(f"{name} is {values[row]} at sample {row}; fill the gap or cut")
            values = np.unwrap(values) if name == "phase_rad" else values
            return np.interp(time_s, self.time_s, values)

        columns = {name: at_times(name, column) for name, column in vars(self).items()}
        return replace(self, **{**columns, "time_s": time_s})


def recording(
    columns: Mapping[str, Collection[object]],
    named: Sequence[str] = (),
    *,
    rate_hz: float | None = None,
) -> Recording:
    """The recording in some columns.

    A column is known by its name with its unit, as `height_m`, `height_mm`, `height [mm]` or
    `Height (mm)`. Columns of other names are left alone, unless they are named.

    Args:
        columns: arrays of one length, by name.
        named: which column is what, `QUANTITY=COLUMN` or `QUANTITY=COLUMN[UNIT]`.
        rate_hz: samples a second, where there is no column of times.

    Raises:
        TegotaeError: if there is no height, no time, two columns for one quantity or one for two, a
            unit that is not known, a cell that is no number, columns of several lengths, or too few
            samples.

    Example:
        >>> table = {"t [ms]": [0, 10, 20], "com": [990.0, 1000.0, 1010.0]}
        >>> found = recording(table, ["height=com[mm]"])
        >>> found.time_s.tolist(), found.height_m.tolist()
        ([0.0, 0.01, 0.02], [0.99, 1.0, 1.01])
    """
    chosen = _chosen(columns, named)
    if "height" not in chosen:
        raise _lacking("height", columns)
    if rate_hz is not None:
        if "time" in chosen:
            raise TegotaeError(
                f"column {chosen['time'][0]!r} holds the times; --rate is for columns without any"
            )
        require_finite("rate", rate_hz, above=0.0, most=1e6)
        samples = len(columns[chosen["height"][0]])
        times = {"time_s": np.arange(samples) / rate_hz}
    elif "time" not in chosen:
        raise _lacking("time", columns, ", or give the rate of the samples: --rate HZ")
    else:
        times = {}
    values = {
        f"{quantity}_{next(iter(QUANTITIES[quantity].units)).lower()}": unit * _numbers_of(
            name, columns[name]
        )
        for quantity, (name, unit) in chosen.items()
    }  # fmt: skip
    _check_lengths({chosen[name.rpartition("_")[0]][0]: len(x) for name, x in values.items()})
    return Recording(**times, **values)


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
        for quantity, what in QUANTITIES.items():
            if quantity in chosen or not {name, whole} & {*what.names}:
                continue
            given = f"in {unit!r}" if unit and whole not in what.names else "without a unit"
            lines.append(
                f"column {column!r} is {given} and is left alone; say it: --columns "
                f"{quantity}={column}[{next(iter(what.units))}]"
            )
    return lines


def _check_lengths(samples: Mapping[str, int]) -> None:
    """Raise `TegotaeError` unless columns have one length, and samples enough."""
    (first, count), *others = samples.items()
    for name, other in others:
        if other != count:
            raise TegotaeError(
                f"column {first!r} holds {count} samples and {name!r} {other}; all must be of one "
                "length"
            )
    if count < _LEAST_SAMPLES:
        raise TegotaeError(
            f"the recording holds {count} samples; it must have at least {_LEAST_SAMPLES}"
        )


def _chosen(
    columns: Mapping[str, Collection[object]], named: Sequence[str]
) -> dict[str, tuple[str, float]]:
    """Column and unit of every quantity: as named, or else by the columns' own names."""
    chosen = _named(columns, named)
    taken = {column for column, _ in chosen.values()}
    free = [column for column in columns if column not in taken]
    return {
        **_found(free, [quantity for quantity in QUANTITIES if quantity not in chosen]),
        **chosen,
    }


def _found(columns: Sequence[str], quantities: Sequence[str]) -> dict[str, tuple[str, float]]:
    """Column and unit of every quantity by a column's own name."""
    found: dict[str, tuple[str, float]] = {}
    for column in columns:
        name, unit = split(column)
        for quantity in quantities:
            what = QUANTITIES[quantity]
            scale = what.of(unit)
            if name not in what.names or scale is None:
                continue
            if quantity in found:
                raise TegotaeError(
                    f"columns {found[quantity][0]!r} and {column!r} may both be the {quantity}; "
                    f"say which, such as --columns {quantity}={column}"
                )
            found[quantity] = (column, scale)
    return found


def _named(
    columns: Mapping[str, Collection[object]], named: Sequence[str]
) -> dict[str, tuple[str, float]]:
    """The same of every quantity whose column was named."""
    chosen: dict[str, tuple[str, float]] = {}
    for each in named:
        quantity, equals, column = each.partition("=")
        if not equals or not column:
            raise TegotaeError(f"{each!r} names no column; write QUANTITY=COLUMN[UNIT]")
        if quantity not in QUANTITIES:
            raise unknown("quantity", quantity, QUANTITIES)
        if column not in columns:  # the unit may be said behind the name
            column, unit = in_brackets(column)
        else:
            unit = split(column)[1]
        if column not in columns:
            raise unknown("column", column, columns)
        units = QUANTITIES[quantity].units
        scale = QUANTITIES[quantity].of(unit)
        if scale is None:
            given = f"in {unit!r}" if unit else "without a unit"
            raise TegotaeError(
                f"column {column!r} is {given}; say which of {', '.join(units)} it is, such as "
                f"--columns {quantity}={column}[{next(iter(units))}]"
            )
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
    return chosen


def _lacking(
    quantity: str, columns: Mapping[str, Collection[object]], otherwise: str = ""
) -> TegotaeError:
    what = QUANTITIES[quantity]
    units = "/".join(what.units)
    names = [*columns]
    listed = ", ".join(map(repr, names[:12])) + (", ..." if len(names) > 12 else "")
    return TegotaeError(
        f"no column is the {quantity} ({what.names[0]}_{units}) among {listed}; name it: "
        f"--columns {quantity}=COLUMN[UNIT]{otherwise}"
    )
