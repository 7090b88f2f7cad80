"""`python -m tegotae.cli.optimum_table`: make the kept table of the default hopper anew."""

import tyro

from tegotae.cli.status import exit_status
from tegotae.measures.optimum.make import Make

if __name__ == "__main__":
    raise SystemExit(exit_status(tyro.cli(Make).run))
