"""A study gives the same table on processors with other vectors."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lowered import available_targets

SMOKE_WITH_VECTORS = """
import sys
from pathlib import Path
from lanewise import machine

chosen = machine.target_of(sys.argv[1])
machine._host = lambda name: chosen

import conftest
from research.reproduction.export import csv_of
from research.reproduction.plan import plan
from research.reproduction.table import tabulate
from research.reproduction.unit import work

table = tabulate(work(unit) for unit in plan("smoke").units)
Path(sys.argv[2]).write_text(csv_of(table), encoding="utf-8")
"""


@pytest.mark.thorough
@pytest.mark.skipif("avx512" not in available_targets(), reason="the processor has no AVX-512")
def test_a_study_gives_the_same_table_with_avx2_and_avx512(tmp_path: Path) -> None:
    """Native code for either; XLA, which summarises and learns, without AVX-512 or as it likes."""
    for vectors, flags in (("avx512", ""), ("avx2", "--xla_cpu_max_isa=AVX2")):
        subprocess.run(
            [sys.executable, "-c", SMOKE_WITH_VECTORS, vectors, str(tmp_path / vectors)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "XLA_FLAGS": flags},
            check=True,
        )
    table = (tmp_path / "avx512").read_bytes()
    assert table.count(b"\n") > 3
    assert (tmp_path / "avx2").read_bytes() == table
