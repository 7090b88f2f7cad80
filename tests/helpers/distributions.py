"""The distributions of the package."""

import os
import subprocess
import sys
from pathlib import Path

from places import ROOT

BUILD = "from hatchling.build import *; build_sdist({0!r}); build_wheel({0!r})"


def build(folder: Path) -> Path:
    """Return a folder with a source distribution and a wheel, within `folder`."""
    tools, dist = folder / "tools", folder / "dist"
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "install"]
    subprocess.run([*pip, "--target", tools, "hatchling"], check=True)
    command = [sys.executable, "-c", BUILD.format(str(dist))]
    path = {"PYTHONPATH": str(tools)}
    subprocess.run(command, cwd=ROOT, env=os.environ | path, check=True, capture_output=True)
    return dist
