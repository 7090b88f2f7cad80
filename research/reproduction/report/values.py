"""Numbers and pictures as values of JSON."""

from __future__ import annotations

import base64
import io
import math
import struct
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError
from tegotae.figures.style import STYLE, styled

_DPI = 200
_SCREEN_PER_IN = 115
"""Pixels of the screen per inch of a figure: its letters of 8 pt are then as tall as small text."""

_COLOURS = 256
"""Number of colours of a picture's palette."""
_PNG = b"\x89PNG\r\n\x1a\n"


def json_number(value: float) -> float | None:
    """Return six digits of a number, or None if it is not finite, which JSON cannot hold."""
    return float(f"{value:.6g}") if math.isfinite(value) else None


def embedded_figure(figure: Figure) -> JsonObject:
    """Embed a figure as a picture in the page, with its size there."""
    stream = io.BytesIO()
    with styled():
        figure.draw_without_rendering()  # a second axis is laid out by the ticks of the first draw
        figure.savefig(stream, format="png", dpi=_DPI)
    small = io.BytesIO()
    # A palette makes a picture of many lines a third as large, and no eye sees it.
    Image.open(stream).convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE).save(
        small, format="png", optimize=True
    )
    return _embedded(small.getvalue(), _DPI)


def embedded_file(path: Path) -> JsonObject:
    """Embed a PNG file of a figure in the page.

    Raises:
        TegotaeError: if it is none.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    if not content.startswith(_PNG) or len(content) < 24:
        raise TegotaeError(f"{path} is no PNG picture")
    return _embedded(content, STYLE["savefig.dpi"])


def _embedded(png: bytes, dpi: float) -> JsonObject:
    width, height = (round(n * _SCREEN_PER_IN / dpi) for n in struct.unpack(">II", png[16:24]))
    source = "data:image/png;base64," + base64.b64encode(png).decode()
    return {"source": source, "width": width, "height": height}
