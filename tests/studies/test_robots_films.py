"""The films of robots: panels side by side, as long as their shortest."""

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("mujoco")


def test_panels_stand_side_by_side_for_as_long_as_all_have_pictures(tmp_path, monkeypatch, study):
    films = study("films.robots")
    shades = np.arange(0, 250, 25, dtype=np.uint8)
    frames = [np.full((30, 40, 3), shade, np.uint8) for shade in shades]
    films.write(tmp_path / "two.webp", {"a_b": frames, "c": frames[:6]})
    with Image.open(tmp_path / "two.webp") as film:
        assert film.size == (600, 240)
        assert film.n_frames == 6
