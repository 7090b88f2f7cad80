"""`tegotae cite`: how to cite the software and the paper that it implements."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae import __version__


@dataclass(frozen=True)
class Reference:
    """A work to cite."""

    key: str
    """Of its BibTeX entry."""
    kind: str
    """Of its BibTeX entry, such as inproceedings."""
    authors: tuple[str, ...]
    """Each as initials and family name, or a group."""
    title: str
    venue: str = ""
    year: str = ""
    version: str = ""

    def text(self) -> str:
        """The reference as one sentence of a bibliography."""
        *others, last = self.authors
        authors = f"{', '.join(others)} and {last}" if others else last
        version = f"version {self.version}" if self.version else ""
        where = [self.venue or "Software", version, self.year]
        return f"{authors}: {self.title}. {', '.join(filter(None, where))}."

    def bibtex(self) -> str:
        """The reference as a BibTeX entry."""
        group = len(self.authors) == 1
        authors = " and ".join(self.authors)
        fields = {
            "author": f"{{{authors}}}" if group else authors,
            "title": f"{{{self.title}}}",
            "booktitle": self.venue,
            "version": self.version,
            "year": self.year,
        }
        lines = [f"  {name} = {{{value}}}," for name, value in fields.items() if value]
        return "\n".join([f"@{self.kind}{{{self.key},", *lines, "}"])


PAPER = Reference(
    key="herneth2023learnable",
    kind="inproceedings",
    authors=("C. Herneth", "M. Hayashibe", "D. Owaki"),
    title="Learnable Tegotae-based Feedback in CPGs with Sparse Observation Produces Efficient and "
    "Adaptive Locomotion",
    venue="IEEE International Conference on Robotics and Automation (ICRA)",
    year="2023",
)
"""The paper. Its DOI and page numbers are left out: no source at hand confirms them."""
SOFTWARE = Reference(
    key="tegotae",
    kind="software",
    authors=("The tegotae developers",),
    title="tegotae: learned Tegotae feedback in central pattern generators",
    version=__version__,
    year="2026",
)
"""This package."""


@dataclass(frozen=True)
class Cite:
    """Print how to cite this software and the paper that it implements, with BibTeX entries."""

    bibtex: bool = False
    """Print the BibTeX entries alone."""

    def run(self) -> None:
        """Print the references."""
        if not self.bibtex:
            print("Please cite the software and the paper:\n")
            print("\n".join(each.text() for each in (SOFTWARE, PAPER)), end="\n\n")
        print("\n\n".join(each.bibtex() for each in (SOFTWARE, PAPER)))
