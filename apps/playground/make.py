"""Make the engines that come with the package: `python -m apps.playground.make`."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path

from apps.playground import engine_cache
from apps.playground.bodies import STANDARD
from apps.playground.standard import standard
from tegotae._support.files import write_atomically
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller

FOLDER = Path(__file__).parent / "engines"


def main() -> None:
    """Compile an engine for every standard controller on every standard body, where it is not of
    the present code."""
    files = set()
    for title, controller, body in engine_bodies():
        wasm = re.sub(r"\W+", "-", title) + ".wasm.gz"
        document = f"{engine_cache.engine_name(controller, body)}.json"
        files |= {wasm, document}
        if engine_cache.is_present(controller, body):
            continue
        engine = engine_cache.compile_engine(controller, body)
        write_atomically(FOLDER / wasm, engine.wasm)
        text = json.dumps(engine_cache.engine_document(engine, title, wasm), separators=(",", ":"))
        write_atomically(FOLDER / document, text + "\n")
        print(f"{title}: {len(engine.wasm)} bytes gzipped")
    for old in FOLDER.glob("*.*"):
        if old.name not in files:
            old.unlink()


def engine_bodies() -> Iterator[tuple[str, Controller, Body]]:
    """Yield every standard controller on every standard body, with their name."""
    for choice in standard():
        for name, body in STANDARD.items():
            controller = dataclasses.replace(choice.saved.controller, limbs=body.limbs)
            yield f"{choice.saved.name} on a {name}", controller, body


if __name__ == "__main__":
    main()
