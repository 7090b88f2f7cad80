"""`python -m research.reproduction optimum-proofs`: check proofs of the table of the optimum."""

from __future__ import annotations

from dataclasses import dataclass

from research.reproduction.optimum import proofs
from research.reproduction.optimum.exact import verify
from tegotae._support.errors import require
from tegotae.measures.optimum import curve
from tegotae.parts.bodies import Hopper


@dataclass(frozen=True)
class CheckProofs:
    """Check every bound of the kept table by its certificates, in rational arithmetic."""

    make: bool = False
    """Prove the table's rows anew first; its gaits stay as they are."""

    def run(self) -> None:
        """Check the table and print one line per row."""
        if self.make:
            require("casadi", "optimum")
            proofs.write_bounds(curve().columns)
            curve.cache_clear()
        certificates = proofs.read_certificates()
        for row in proofs.claimed_bounds():
            proofs.check_row(row, certificates)
            print(
                f"{row.omega:8.4g} rad/s: at most {row.upper_bound:.7g} m/J in period 1, "
                f"{row.upper_bound_any:.7g} m/J in any: proved"
            )
        largest = verify(certificates[0], Hopper())
        print(f"any frequency of at least a hop a minute: at most {float(largest):.7g} m/J: proved")
