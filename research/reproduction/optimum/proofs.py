"""The certificates behind the kept table's bounds: kept beside it, and checked without a solver.

    python -m research.reproduction optimum-proofs         # check every row, in rational arithmetic
    python -m research.reproduction optimum-proofs --make  # prove the table's rows anew

A bound holds for all faster hops too, so that a row may stand on the certificates of a row before.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction
from itertools import groupby
from pathlib import Path

import numpy as np

from research.reproduction.optimum.certificate import Certificate, certify, upper_certificates
from research.reproduction.optimum.exact import covers, decimal_fraction, verify
from tegotae._support.errors import TegotaeError
from tegotae._support.files import read_arrays, write_arrays
from tegotae._support.progress import reporting
from tegotae._support.tables import write_csv
from tegotae.measures import optimum
from tegotae.measures.optimum import curve
from tegotae.parts.bodies import Hopper

FILE = Path(__file__).with_name("proofs.npz")
TABLE = Path(optimum.__file__).with_name("curve.csv")
"""The table of the package, of which each row is proved."""
"""The kept certificates."""
DIGITS = 7
"""Significant digits of the kept table."""
_MOST_BYTES = 2**25
_STEP = 2.0**-26  # coefficients of V are kept in multiples of it [m]


@dataclass(frozen=True)
class Bounds:
    """Claims of the table at a frequency.

    Args:
        omega: hop frequency ω [rad/s]; None for any, of at least one hop a minute.
        upper_bound: no gait of period 1 has a larger CoT⁻¹ [m/J].
        upper_bound_any: no gait of any period has.
    """

    omega: float | None
    upper_bound: float
    upper_bound_any: float


def claimed_bounds() -> list[Bounds]:
    """Return the claims of the kept table, row by row."""
    optimum = curve()
    names = ("omega", "upper_bound", "upper_bound_any")
    return [
        Bounds(*map(float, values))
        for values in zip(*(optimum[name] for name in names), strict=True)
    ]


def read_certificates(file: Path = FILE) -> list[Certificate]:
    """Return the kept certificates of the default hopper.

    Raises:
        TegotaeError: for a file that holds none.

    Example:
        >>> len(read_certificates()) > 49
        True
    """
    try:
        arrays = read_arrays(file, _MOST_BYTES)
        ends = {name: np.cumsum(arrays[name]) for name in ("n_heights", "n_speeds")}
        knots = [np.split(arrays[name], ends[f"n_{name}"][:-1]) for name in ("heights", "speeds")]
        shapes = 2 * np.stack([arrays["n_heights"], arrays["n_speeds"]], axis=1) - 1
        tables = np.split(arrays["coefficients"], np.cumsum(shapes.prod(axis=1))[:-1])
        scalars = (arrays[name].tolist() for name in ("bound", "time_price", "omega"))
        return [
            Certificate(
                bound, price, x, v, table.reshape(shape), _frequency(omega), (ends[0], ends[1])
            )
            for bound, price, omega, ends, x, v, table, shape in zip(
                *scalars, arrays["lift_off"].tolist(), *knots, tables, shapes, strict=True
            )
        ]
    except OSError as error:
        raise TegotaeError(f"{file} cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, IndexError) as error:
        raise TegotaeError(f"{file} holds no certificates: {error}") from None


def write_certificates(certificates: Sequence[Certificate], file: Path = FILE) -> None:
    """Keep certificates; those of absolute work alone have a place.

    Args:
        certificates: what is kept.
        file: where; the package's own by default.
    """
    of_each = {
        "bound": [certificate.bound for certificate in certificates],
        "time_price": [certificate.time_price for certificate in certificates],
        "omega": [
            math.nan if certificate.omega is None else certificate.omega
            for certificate in certificates
        ],
        "lift_off": [certificate.lift_off for certificate in certificates],
        "n_heights": [len(certificate.heights_m) for certificate in certificates],
        "n_speeds": [len(certificate.speeds_m_per_s) for certificate in certificates],
    }
    joined = {
        "heights": [certificate.heights_m for certificate in certificates],
        "speeds": [certificate.speeds_m_per_s for certificate in certificates],
        "coefficients": [certificate.coefficients.ravel() for certificate in certificates],
    }
    arrays = {name: np.array(values) for name, values in of_each.items()}
    write_arrays(
        file, arrays | {name: np.concatenate(certificate) for name, certificate in joined.items()}
    )


def check_row(row: Bounds, certificates: Iterable[Certificate]) -> None:
    """Check that certificates prove both bounds of a row, in rational arithmetic.

    Args:
        row: what is claimed.
        certificates: of the default hopper, among which those of this frequency or a lower one
            count.

    Raises:
        TegotaeError: if they do not, or one of them does not hold.

    Example:
        >>> check_row(claimed_bounds()[-1], read_certificates())
    """
    body = Hopper()
    lower = [certificate for certificate in certificates if _holds_at(certificate, row.omega)]
    for one_hop, claimed in ((True, row.upper_bound), (False, row.upper_bound_any)):
        good = [
            certificate
            for certificate in lower
            if Fraction(float(certificate.bound)) <= decimal_fraction(claimed)
        ]
        groups = (_needed(certificate, one_hop) for certificate in _by_frequency(good))
        omega = row.omega if one_hop else None
        covering = next(
            (
                certificate
                for certificate in groups
                if certificate and covers(certificate, body, omega)
            ),
            None,
        )
        if covering is None:
            frequency = "any frequency" if row.omega is None else f"{row.omega:g} rad/s"
            period = "period 1" if one_hop else "any period"
            raise TegotaeError(f"no certificates prove {claimed:g} m/J at {frequency}, {period}")
        for certificate in covering:
            verify(certificate, body)


def _holds_at(certificate: Certificate, omega: float | None) -> bool:
    """Return whether a certificate covers gaits of this frequency."""
    if omega is None or certificate.omega is None:
        return certificate.omega is None
    return certificate.omega <= omega and certificate.work == "absolute"


def _by_frequency(certificates: list[Certificate]) -> Iterable[list[Certificate]]:
    """Yield certificates in groups of one frequency, the highest first."""

    def frequency(certificate: Certificate) -> float:
        return -(certificate.omega or 0.0)

    for _, group in groupby(sorted(certificates, key=frequency), frequency):
        yield list(group)


def _needed(certificates: list[Certificate], one_hop: bool) -> list[Certificate]:
    """Return the certificates to be checked: one that covers all, or all where every hop is
    alike.
    """
    universal = [
        certificate for certificate in certificates if covers([certificate], Hopper(), None)
    ]
    return universal[:1] or (certificates if one_hop else [])


def _frequency(omega: float) -> float | None:
    return None if math.isnan(omega) else omega


def rounded_up(value: float, digits: int = DIGITS) -> float:
    """Return the next number of so many significant digits that is not smaller.

    Args:
        value: a number.
        digits: how many significant digits.

    Example:
        >>> rounded_up(1.2216545282)
        1.221655
    """
    context = Context(prec=digits, rounding=ROUND_CEILING)
    return float(context.create_decimal(Decimal(value)))


def rounded_certificate(certificate: Certificate) -> Certificate:
    """Return a certificate with V in multiples of a small step, so that it takes less room."""
    steps = np.round(certificate.coefficients / _STEP)
    return replace(certificate, coefficients=steps * _STEP)


def prove(
    omegas: Iterable[float], best_known: Iterable[float]
) -> tuple[list[Bounds], list[Certificate]]:
    """Prove bounds at frequencies; return them and their certificates.

    Args:
        omegas: hop frequencies ω, rising [rad/s].
        best_known: CoT⁻¹ of the best gait known at each [m/J]; NaN where there is none.

    Returns:
        a row a frequency, and the certificates on which they stand, that of any frequency first.

    Raises:
        TegotaeError: if a certificate does not hold.
        MissingExtraError: if CasADi is not installed.
    """
    body = Hopper()
    certificates = [rounded_certificate(certify(body))]
    bounds: list[Bounds] = []
    one_hop_bound, any_hop_bound = math.inf, math.inf
    pairs = list(zip(omegas, best_known, strict=True))
    with reporting("proofs", len(pairs)) as reporter:
        for count, (omega, best) in enumerate(pairs, 1):
            for one_hop in (False, True):
                try:
                    proofs = (
                        upper_certificates(body, omega, best=float(np.nan_to_num(best)))
                        if one_hop
                        else [certify(body, omega)]
                    )
                except TegotaeError as error:  # the bound of the row before holds here, too
                    print(error, file=sys.stderr)
                    continue
                bound = rounded_up(max((certificate.bound for certificate in proofs), default=0.0))
                if bound < (one_hop_bound if one_hop else any_hop_bound):
                    proofs = list(map(rounded_certificate, proofs))
                    for certificate in proofs:
                        verify(certificate, body)
                    certificates += proofs
                    one_hop_bound, any_hop_bound = (
                        (bound, any_hop_bound) if one_hop else (one_hop_bound, bound)
                    )
            bounds.append(Bounds(omega, min(one_hop_bound, any_hop_bound), any_hop_bound))
            reporter.update(count, f"{omega:.2f} rad/s")
    return bounds, certificates


def write_bounds(columns: dict[str, np.ndarray]) -> None:
    """Prove bounds for a table of gaits, and write both in their places: `TABLE` and `FILE`.

    Args:
        columns: those of `tegotae.measures.optimum.curve`; bounds are replaced.

    Raises:
        TegotaeError: if a certificate does not hold.
        MissingExtraError: if CasADi is not installed.
    """
    bounds, certificates = prove(columns["omega"].tolist(), columns["cot_inverse"].tolist())
    proved = {
        name: [getattr(row, name) for row in bounds] for name in ("upper_bound", "upper_bound_any")
    }
    write_certificates(certificates)
    table = {name: {**columns, **proved}[name] for name in curve().columns}
    write_csv(TABLE, table, digits=DIGITS)
