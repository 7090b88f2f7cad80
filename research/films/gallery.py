"""Run the examples, and keep their pictures small: `docs/_static/gallery/`.

Run: python -m research.films.gallery [NAME ...]
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from research.frame import Names, main

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
PICTURES = ROOT / "docs" / "_static" / "gallery"
WIDTH = 1000
"""Largest width of a picture [pixels]."""
COLOURS = 256


def shrunk(picture: Image.Image) -> Image.Image:
    """Shrink a picture to the page's width and to few colours."""
    if picture.width > WIDTH:
        height = round(picture.height * WIDTH / picture.width)
        picture = picture.resize((WIDTH, height), Image.Resampling.LANCZOS)
    return picture.convert("RGB").quantize(COLOURS)


def draw(name: str) -> Path:
    """Run an example in a folder of its own, and keep its picture."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, EXAMPLES / f"{name}.py"], cwd=folder, check=True)
        PICTURES.mkdir(parents=True, exist_ok=True)
        with Image.open(Path(folder) / f"{name}.png") as picture:
            shrunk(picture).save(PICTURES / f"{name}.png", optimize=True)
    return PICTURES / f"{name}.png"


def run(names: Names = ()) -> None:
    """Draw the named examples, or all."""
    for name in names or sorted(path.stem for path in EXAMPLES.glob("*.py")):
        path = draw(name)
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1024:.0f} KiB")


if __name__ == "__main__":
    main(run)
