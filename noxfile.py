"""The Pythons and the range of dependencies that `pyproject.toml` declares: `nox`.

Each session installs a distribution into an empty environment, runs README's commands outside the
clone, and then a few tests of every kind. Those of the whole suite are `make test`.
"""

import re
import shlex
from pathlib import Path

import nox

ROOT = Path(__file__).parent
PYTHONS = nox.project.python_versions(nox.project.load_toml("pyproject.toml"))
SMOKE = (
    "tests/parts/test_hopper.py",
    "tests/simulation/test_rollout.py",
    "tests/measures/test_metrics_spectrum.py",
    "tests/training/test_pgpe.py",
)

nox.needs_version = ">=2024.10"
nox.options.default_venv_backend = "uv"


@nox.session(python=PYTHONS)
@nox.parametrize(
    ("resolution", "archive"),
    [("highest", "*.whl"), ("lowest-direct", "*.tar.gz")],
    ids=["newest", "lowest"],
)
def installed(session: nox.Session, resolution: str, archive: str) -> None:
    """The wheel with the newest dependencies, the source distribution with the lowest."""
    folder = Path(session.create_tmp()).resolve()
    session.run("uv", "build", "--out-dir", str(folder), str(ROOT), external=True)
    (distribution,) = folder.glob(archive)

    def add(*extras: str) -> None:
        # Of a distribution the dependencies would not be direct ones.
        session.install("--resolution", resolution, "-r", str(ROOT / "pyproject.toml"), *extras)

    add()
    session.install("--no-deps", str(distribution))
    with session.chdir(folder):
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        for command in re.findall(r"^\$ (tegotae .*)$", readme, re.MULTILINE):
            session.run(*shlex.split(command))
    add("--extra", "test")
    session.run("python", "-m", "pytest", "-p", "no:cacheprovider", *SMOKE)
