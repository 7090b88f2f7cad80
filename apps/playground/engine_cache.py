"""Engines that come with the package, and those that are compiled when they are wanted."""

from __future__ import annotations

import gzip
import hashlib
import json
from dataclasses import dataclass
from importlib import resources
from importlib.metadata import version
from importlib.resources.abc import Traversable
from typing import Any

import jax

from apps.playground.bodies import form
from apps.playground.compiler import compile_webassembly, has_compiler
from apps.playground.program import Program
from apps.playground.source import program_source
from tegotae._support.documents import JsonObject
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.systems.descriptions import describe


@dataclass(frozen=True)
class CompiledEngine:
    """A compiled closed loop.

    Args:
        wasm: the WebAssembly, gzipped.
        layout: by name, where in a lane a number begins and how many there are.
        source: the hash of the C that was compiled.
        made_by: versions of what traced and compiled it; others may write the same otherwise.
    """

    wasm: bytes
    layout: dict[str, list[int]]
    source: str
    made_by: dict[str, str]


def engine_name(controller: Controller, body: Body) -> str:
    """Return the name of a structure's engine: the same for all weights and numbers.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> from tegotae.systems.recipe import recipe
        >>> heavy = engine_name(recipe("V-sector-w8").controller(), Hopper(mass_kg=0.2))
        >>> heavy == engine_name(recipe("V-sector-w4").controller(), Hopper())
        True
    """
    structure = {"controller": describe(controller), "body": form(body)}
    text = json.dumps(structure, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def cached_engine(controller: Controller, body: Body) -> CompiledEngine:
    """Return the engine of a controller on a body: read from the package, or compiled.

    Raises:
        MissingExtraError: if it must be compiled and there is no compiler.
        TegotaeError: for an operation that has no C, by its name.
    """
    if not has(controller, body):
        return compile_engine(controller, body)
    entries = _cached(controller, body)
    wasm = (_engines() / entries["wasm"]).read_bytes()
    return CompiledEngine(wasm, entries["layout"], entries["source"], entries["made_by"])


def has(controller: Controller, body: Body) -> bool:
    """Return whether the engine comes with the package.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> from tegotae.systems.recipe import recipe
        >>> learned, network = recipe("ART-rF-tphif-w4").controller(), recipe("T-F").controller()
        >>> has(learned, Hopper(mass_kg=0.2)), has(network, Hopper())
        (True, False)
    """
    return _cache_file(controller, body).is_file()


def is_present(controller: Controller, body: Body) -> bool:
    """Return whether the package has the engine, of its present code."""
    if not has(controller, body):
        return False
    source = program_source(Program(controller, body))
    return _cached(controller, body).get("source") == _hash_of(source)


def _cached(controller: Controller, body: Body) -> dict[str, Any]:
    return json.loads(_cache_file(controller, body).read_text(encoding="utf-8"))


def _hash_of(source: str) -> str:
    return hashlib.sha256(source.encode()).hexdigest()[:16]


def _engines() -> Traversable:
    return resources.files("apps.playground") / "engines"


def _cache_file(controller: Controller, body: Body) -> Traversable:
    return _engines() / f"{engine_name(controller, body)}.json"


def compile_engine(controller: Controller, body: Body) -> CompiledEngine:
    """Compile the engine of a controller on a body anew."""
    program = Program(controller, body)
    source = program_source(program)
    wasm = gzip.compress(compile_webassembly(source), mtime=0)
    return CompiledEngine(wasm, program.layout.document(), _hash_of(source), makers())


def makers() -> dict[str, str]:
    """Return the versions of the programs that would trace and compile an engine here."""
    return {"jax": jax.__version__, "ziglang": version("ziglang") if has_compiler() else "none"}


def engine_document(engine: CompiledEngine, title: str, wasm: str) -> JsonObject:
    """Return the document beside an engine's WebAssembly."""
    return {
        "about": title,
        "wasm": wasm,
        "made_by": engine.made_by,
        "source": engine.source,
        "layout": engine.layout,
    }
