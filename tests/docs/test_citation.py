"""The paper and the software are cited alike wherever they are cited."""

import pytest

from places import ROOT
from tegotae.api.about import PAPER, SOFTWARE
from tegotae.cli import main


def words(name: str) -> str:
    """A file's text without line breaks, emphasis or quotation marks."""
    return " ".join((ROOT / name).read_text(encoding="utf-8").replace(">", "").split())


def test_the_command_prints_both_references_and_their_bibtex(capsys):
    assert main(["cite"]) == 0
    printed = capsys.readouterr().out
    for reference in (PAPER, SOFTWARE):
        assert reference.text() in printed
        assert reference.bibtex() in printed


def test_the_command_prints_bibtex_alone(capsys):
    assert main(["cite", "--bibtex"]) == 0
    assert capsys.readouterr().out.startswith("@software{tegotae,\n  author = {{The tegotae")


def test_the_page_has_the_references_and_entries_that_the_command_prints():
    page = (ROOT / "docs" / "cite.md").read_text(encoding="utf-8")
    for reference in (PAPER, SOFTWARE):
        assert reference.text() in words("docs/cite.md")
        assert reference.bibtex() in page


def test_the_readme_names_the_paper_in_full_and_the_command_that_cites_both():
    assert "`tegotae cite` prints BibTeX for both." in words("README.md")
    assert PAPER.text().rstrip(".") in words("README.md").replace("*", "").replace(
        "Locomotion,", "Locomotion."
    )


def test_the_citation_file_has_the_same_software_and_paper():
    yaml = pytest.importorskip("yaml")
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (citation["title"], citation["version"]) == (SOFTWARE.title, SOFTWARE.version)
    paper, *related = citation["references"]
    authors = tuple(f"{item['given-names']} {item['family-names']}" for item in paper["authors"])
    assert (paper["title"], authors) == (PAPER.title, PAPER.authors)
    assert (paper["collection-title"], str(paper["year"])) == (PAPER.venue, PAPER.year)
    page = words("docs/related.md")
    for work in related:  # nothing is cited that the page does not place
        assert work["title"] in page
        assert work.get("doi", work.get("url")) in page
