"""Kept artefacts: the command that makes each file again, and the files that a change made stale.

    python tests/helpers/artefacts.py                  # of the changes since main
    python tests/helpers/artefacts.py --since v0.1     # of those since another revision
    python tests/helpers/artefacts.py docs/_static/figures/optimum.png    # how this file is made

`tests/kept/artefacts.toml`, and for a topic of research `research/TOPIC/artefacts.toml`, have a row
for every kept table, picture, document and engine. A row is

- *stale* if the present code cannot read or does not make its files (engines, controllers, the
  zoo), or if a document or a pin that it rests on changed and its files did not;
- *to look at* if code changed that its command runs, and no pin stands for that code: scripts of
  research and what draws. Comments and docstrings do not count.

Others rest on changed code of the package: their numbers are as before where `pins.py` finds equal
bits. `--all` names them.
"""

import argparse
import ast
import fnmatch
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from places import ROOT, TESTS

ROWS = [TESTS / "kept" / "artefacts.toml", *sorted((ROOT / "research").glob("*/artefacts.toml"))]
PINS = "tests/kept/pins.json"
_PINNED = re.compile(r"src/(lanewise|tegotae)/(?!figures/|cli/|api/)")
"""Code of which pins show that it computes the same."""
_SOURCES = ("src", ".", "tests/helpers")
"""Folders from which modules are imported."""
_MODULE = re.compile(r"[a-z_]+(\.\w+)+(:\w+)?")


@dataclass(frozen=True, kw_only=True)
class Artefact:
    """Kept files that one command makes.

    Args:
        files: their paths from the root, as patterns.
        command: the command that makes them, run at the root; or why there is none.
        needs: documents of the repository that the command reads, as patterns.
        pins: pins (`pins.py`) that have the numbers of its simulations or trainings.
        check: the name of a check of its files against the present code (`CHECKS`).
    """

    files: tuple[str, ...]
    command: str
    needs: tuple[str, ...] = ()
    pins: tuple[str, ...] = ()
    check: str = ""

    @cached_property
    def paths(self) -> list[str]:
        """The tracked files."""
        return matching(self.files)

    @property
    def scripts(self) -> list[Path]:
        """The program that the command runs, as files; of a package the module of the command."""
        if "python " not in self.command:
            is_command = self.command.startswith("tegotae ")
            return [*(ROOT / "src/tegotae/api").glob("*.py")] if is_command else []
        program = re.search(r"python (?:-m ([\w.]+)|(\S+\.py)) ?([\w-]*)", self.command)
        if program is None:
            return []
        module, script, word = program.groups()
        if script:
            return [ROOT / script]
        file = module_file(f"{module}.__main__") or module_file(module)
        if file is None:
            return []
        entry = re.search(rf'"{word}": Command\(\s*"([\w.]+):', file.read_text(encoding="utf-8"))
        command = module_file(entry[1]) if entry else None
        return [command or file]

    @property
    def has_command(self) -> bool:
        """True if the repository has the program or the command of `tegotae`."""
        if "python " in self.command:
            return bool(self.scripts) and all(script.exists() for script in self.scripts)
        if not self.command.startswith("tegotae "):
            return True
        return any(f"{self.command} ".startswith(f"tegotae {name} ") for name in commands())


@cache
def commands() -> list[str]:
    """The commands of `tegotae`, by their words."""
    file = ROOT / "src" / "tegotae" / "cli" / "commands.toml"
    purposes = tomllib.loads(file.read_text(encoding="utf-8"))
    return [name for names in purposes.values() for name in names]


def artefacts() -> list[Artefact]:
    """The rows of all files `artefacts.toml`."""
    return [
        Artefact(**{k: tuple(x) if isinstance(x, list) else x for k, x in row.items()})
        for file in ROWS
        for row in tomllib.loads(file.read_text(encoding="utf-8"))["artefact"]
    ]


def git(*words: str) -> str:
    """The output of a command of git at the root."""
    return subprocess.run(
        ["git", *words], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout


@cache
def tracked() -> list[str]:
    """All files of the repository, but for those that are deleted here."""
    return [name for name in git("ls-files").splitlines() if (ROOT / name).exists()]


def matching(patterns: Iterable[str]) -> list[str]:
    """The tracked files that one of some patterns matches."""
    return [name for name in tracked() if any(fnmatch.fnmatchcase(name, p) for p in patterns)]


# What a change touches


def base_of(since: str) -> str:
    """The commit from which the changes since a revision are counted: where both have branched.

    Raises:
        SystemExit: with one line, for a revision that there is not.
    """
    outcome = subprocess.run(
        ["git", "merge-base", since, "HEAD"], cwd=ROOT, capture_output=True, text=True
    )
    if outcome.returncode:
        raise SystemExit(f"there is no revision {since!r} to compare with; name one with --since")
    return outcome.stdout.strip()


def changed_files(base: str) -> set[str]:
    """Files that differ from a commit; Python code only where it does something else."""
    names = git("diff", "--name-only", "--no-renames", base).splitlines()
    names += git("ls-files", "--others", "--exclude-standard").splitlines()
    return {name for name in names if not name.endswith(".py") or _is_other_code(base, name)}


def _is_other_code(revision: str, name: str) -> bool:
    earlier = earlier_text(revision, name)
    path = ROOT / name
    if earlier is None or not path.exists():
        return True
    return code_of(earlier) != code_of(path.read_text(encoding="utf-8"))


def earlier_text(revision: str, name: str) -> str | None:
    """The text of a file at a revision; None where there was none."""
    outcome = subprocess.run(
        ["git", "show", f"{revision}:{name}"], cwd=ROOT, capture_output=True, text=True
    )
    return outcome.stdout if outcome.returncode == 0 else None


def code_of(text: str) -> str:
    """Python code without comments and docstrings, for comparison.

    Example:
        >>> code_of("x = 1  # one") == code_of("x=1") != code_of("x = 2")
        True
    """
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [x for x in body if not _is_text(x)] or [ast.Pass()]  # type: ignore[attr-defined]
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    is_constant = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return is_constant and isinstance(node.value.value, str)  # type: ignore[attr-defined]


def module_file(name: str) -> Path | None:
    """The file of a module of the repository, or None."""
    for folder in _SOURCES:
        stem = ROOT / folder / name.replace(".", "/")
        for file in (stem.with_name(f"{stem.name}.py"), stem / "__init__.py"):
            if file.exists():
                return file.resolve()
    return None


@cache
def imported(file: Path) -> frozenset[Path]:
    """The files of the repository that a file imports, or names as `module:object`."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names |= {node.value.partition(":")[0]} if _MODULE.fullmatch(node.value) else set()
    beside = {file.with_name(f"{name}.py") for name in names if "." not in name}
    files = {module_file(name) for name in names} | {path for path in beside if path.exists()}
    return frozenset(path for path in files if path is not None)


def closure(files: Iterable[Path]) -> set[str]:
    """The files that some files of code import, themselves included, as paths from the root."""
    seen: set[Path] = set()
    waiting = [file.resolve() for file in files if file.exists()]
    while waiting:
        file = waiting.pop()
        if file not in seen:
            seen.add(file)
            waiting += imported(file) - seen
    return {file.relative_to(ROOT).as_posix() for file in seen}


def changed_pins(base: str) -> set[str]:
    """Pins of which some result has other bits than at a commit."""
    earlier = earlier_text(base, PINS)
    before = json.loads(earlier)["pins"] if earlier else {}
    present = json.loads((ROOT / PINS).read_text(encoding="utf-8"))["pins"]
    return {name for name in present if before.get(name) != present[name]}


# Checks of files against the present code: sentences on what does not fit


def engines(paths: list[str]) -> Iterator[str]:
    """Engines of the playground whose code would be compiled from other source now."""
    from apps.playground import engine_cache
    from apps.playground.make import engine_bodies

    kept = {Path(path).name for path in paths}
    for title, controller, body in engine_bodies():
        name = f"{engine_cache.engine_name(controller, body)}.json"
        if name not in kept:
            yield f"there is no engine of {title}"
        elif not engine_cache.is_present(controller, body):
            yield f"the engine of {title} is of other code"


def controllers(paths: list[str]) -> Iterator[str]:
    """Controller files that cannot be read."""
    from tegotae import TegotaeError
    from tegotae.systems import controller_file

    for path in paths:
        if path.endswith(".json"):
            try:
                controller_file.load(ROOT / path)
            except TegotaeError as error:
                yield str(error)


def zoo(paths: list[str]) -> Iterator[str]:
    """Archives of the zoo with models that cannot be read."""
    from tegotae import TegotaeError
    from tegotae.systems.resolve import resolve
    from tegotae.systems.zoo import open_zoo

    for path in paths:
        for model in open_zoo(ROOT / path).models:
            try:
                resolve(f"zoo:{path}:{model}/0")
            except TegotaeError as error:
                yield f"{path}, {model}: {error}"


CHECKS: dict[str, Callable[[list[str]], Iterator[str]]] = {
    "controllers": controllers,
    "engines": engines,
    "zoo": zoo,
}


# The report


@dataclass(frozen=True)
class Verdict:
    """Meaning of a change for an artefact: why it is stale, and which of its code changed."""

    artefact: Artefact
    reasons: tuple[str, ...]
    code: tuple[str, ...]

    @property
    def unpinned(self) -> tuple[str, ...]:
        """Changed code of which no pin shows that it does the same."""
        return tuple(name for name in self.code if not _PINNED.match(name))


def verdicts(since: str) -> list[Verdict]:
    """The artefacts that changes since a revision concern."""
    base = base_of(since)
    changed, pins = changed_files(base), changed_pins(base)
    result = []
    for row in artefacts():
        code = sorted(closure(row.scripts) & changed)
        is_made = bool(set(row.paths) & changed)
        reasons = [] if row.has_command else ["its command is gone"]
        reasons += [] if is_made else [f"{x} changed" for x in matching(row.needs) if x in changed]
        reasons += [] if is_made else [f"the pin {x!r} changed" for x in row.pins if x in pins]
        if row.check and code:
            reasons += CHECKS[row.check](row.paths)
        if reasons or (code and not is_made):
            result.append(Verdict(row, tuple(reasons), tuple(code)))
    return result


def shortened(names: tuple[str, ...], most: int = 3) -> str:
    """Some names in a line, and how many more there are.

    Example:
        >>> shortened(("a", "b", "c", "d"), 2)
        'a; b; and 2 more'
    """
    more = (f"and {len(names) - most} more",) if len(names) > most else ()
    return "; ".join((*names[:most], *more))


def report(since: str, all_of_them: bool) -> bool:
    """Print what changes since a revision mean; True if nothing is stale."""
    concerned = verdicts(since)
    stale = [verdict for verdict in concerned if verdict.reasons]
    fresh = [verdict for verdict in concerned if not verdict.reasons]
    others = [verdict for verdict in fresh if verdict.unpinned or all_of_them]
    print(f"stale since {since}: {len(stale)} of {len(artefacts())} artefacts")
    for verdict in stale:
        print_verdict(verdict.artefact, verdict.reasons)
    if others:
        print(f"to look at, for code that their command runs changed: {len(others)}")
    for verdict in others:
        print_verdict(verdict.artefact, verdict.unpinned or verdict.code)
    if len(fresh) > len(others):
        print(
            f"{len(fresh) - len(others)} more rest on changed code of the package: as before if "
            "`python tests/helpers/pins.py` finds equal bits; --all names them"
        )
    return not stale


def print_verdict(artefact: Artefact, reasons: tuple[str, ...]) -> None:
    """Print an artefact, why it is named, and its command."""
    print(f"  {', '.join(artefact.files)}: {shortened(reasons)}\n      {artefact.command}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--since", default="main", help="a revision of git")
    parser.add_argument("--all", action="store_true", help="name all that rest on changed code")
    parser.add_argument("files", nargs="*", help="kept files whose command is asked for")
    words = parser.parse_args()
    for file in words.files:
        name = Path(file).resolve().relative_to(ROOT).as_posix()
        for row in artefacts():
            if name in row.paths:
                print(f"{name}: {row.command}")
    return 0 if words.files else not report(words.since, words.all)


if __name__ == "__main__":
    sys.exit(main())
