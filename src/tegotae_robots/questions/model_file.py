"""What follows from a robot, as a file that is not written over."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tegotae._support.errors import TegotaeError
from tegotae.questions.answer import TableAnswer
from tegotae.questions.wiring import ModelOptions, stem_of


@dataclass(frozen=True, kw_only=True)
class ModelFileOptions(ModelOptions):
    """What is known of the model, and where what follows from it is written."""

    feet: tuple[str, ...] = ()
    """Bodies or geoms that touch the ground; the lowest ones at the end of a chain by default."""
    out: Path
    """The file (.toml), which must not be there yet."""

    @classmethod
    def options_of(cls, env: str) -> ModelFileOptions:
        """A file that is named as the model."""
        return cls(out=Path(f"{stem_of(env)}.toml"))


@dataclass(frozen=True, repr=False, kw_only=True)
class ModelFile(TableAnswer):
    """What follows from a model, every entry with its reason; in memory until it is saved."""

    ENDING = ".toml"

    def save(self, folder: Path | str, format: str = "toml") -> list[Path]:
        """Write the file of that name; none that is there is written over.

        Raises:
            TegotaeError: for another ending, or if it is there or cannot be written.
        """
        file = Path(folder)
        self.check_file(file)
        self._write(file)
        return [file]

    @classmethod
    def check_file(cls, file: Path) -> None:
        super().check_file(file)
        cls.check_name(file)
        if file.exists():
            raise TegotaeError(f"{file} exists already; name another file with --out")

    @classmethod
    def check_name(cls, file: Path | str) -> None:
        """Raises TegotaeError for an ending that the file cannot have."""
        if not isinstance(file, str | Path):
            raise TegotaeError(f"out is {file!r}; it must be the name of a file")
        if Path(file).suffix != cls.ENDING:
            raise TegotaeError(f"{file} must end in {cls.ENDING}")

    def _write(self, file: Path) -> None:
        raise NotImplementedError
