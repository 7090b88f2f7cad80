"""The distributions of the package, built once for all tests of the pages."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from places import ROOT

BUILD = "from hatchling.build import *; build_sdist({0!r}); build_wheel({0!r})"


@pytest.fixture(scope="session")
def built(tmp_path_factory) -> Path:
    """A folder with a source distribution and a wheel."""
    folder = tmp_path_factory.mktemp("built")
    tools, dist = folder / "tools", folder / "dist"
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "install"]
    subprocess.run([*pip, "--target", tools, "hatchling"], check=True)
    command = [sys.executable, "-c", BUILD.format(str(dist))]
    path = {"PYTHONPATH": str(tools)}
    subprocess.run(command, cwd=ROOT, env=os.environ | path, check=True, capture_output=True)
    return dist
