"""Sphinx configuration: `sphinx-build -W docs docs/_build/html`."""

import re
import sys
from pathlib import Path

from sphinx.ext import napoleon
from sphinx.util import logging

import tegotae
from tegotae.api.about import SOFTWARE

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1]))
from apps import playground
from command_reference import command_reference
from prose_numbers import stale
from research_pages import page_text, source_of

project = "tegotae"
(author,) = SOFTWARE.authors
copyright = f"{SOFTWARE.year}, {author}"
release = version = tegotae.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",  # ships MathJax: equations need no network
    "sphinx.ext.viewcode",
]
myst_enable_extensions = ["amsmath", "dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]

html_theme = "furo"
html_title = f"tegotae {release}"
html_static_path = ["_static"]
html_css_files = ["console.css"]  # long commands wrap

# Docstrings put code and equations between single backticks.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_default_options = {"special-members": "__call__"}
autodoc_typehints_format = "short"

# Every reference that a page makes to this package must lead somewhere. Not so those in signatures:
# they name other packages, and this one's classes by the private modules that define them.
nitpicky = True
nitpick_ignore_regex = [
    (r"py:.*", r"(?!tegotae\.|tegotae_robots\.|lanewise\.|research\.|apps\.).*"),
    (r"py:class", r"(tegotae\.\w+|tegotae_robots|lanewise)(\.\w+){2,}"),
    (r"py:class", r"tegotae\.(parameters|documents|registry)\.[PT]"),
]


def read_docstring(app, what, name, obj, options, lines):
    """Turn a docstring into reStructuredText: its Google sections, and |x| as absolute values."""
    # Napoleon takes what stands before a colon in an attribute's docstring for its type.
    kind = "" if what in ("attribute", "data", "property") else what
    lines[:] = napoleon.GoogleDocstring(lines, napoleon.Config(), app, kind, name, obj).lines()
    for i, line in enumerate(lines):
        parts = re.split(r"(`[^`]*`)", line)
        lines[i] = "".join(p if p.startswith("`") else p.replace("|", r"\|") for p in parts)


def read_research(app, docname, source):
    """Take the text of a page that stands in `research` from there."""
    page = Path(app.env.doc2path(docname))
    app.env.note_dependency(str(source_of(page)))
    source[0] = page_text(page)


def add_commands(app, docname, source):
    """Put the command-line reference into its page."""
    if docname == "commands":
        marker = "<!-- written here as the pages are built: the reference -->"
        source[0] = source[0].replace(marker, command_reference())


def check_numbers(app, docname, source):
    """A number that differs from its table is a warning, which ends the build."""
    for fault in stale(source[0]):
        logging.getLogger(__name__).warning(fault, location=docname)


def keep_words_whole(app, pagename, templatename, context, doctree):
    """Console lines that wrap do not do so at the hyphens of options and names."""
    context["body"] = re.sub(
        r'(?<=<div class="highlight-console).*?</pre>',
        lambda block: re.sub(
            r"(?<=[ >\n])[^\s<>]*-[^\s<>]*", r'<span class="word">\g<0></span>', block[0]
        ),
        context.get("body") or "",
        flags=re.DOTALL,
    )


def write_playground(app, error):
    """The page to play with, beside the pages that link to it."""
    if error is None and app.builder.format == "html":
        html = playground.Page(playground.standard()).html()
        (Path(app.outdir) / "playground-page.html").write_text(html, encoding="utf-8")


def setup(app):
    """Connect the hooks."""
    app.connect("source-read", read_research)
    app.connect("source-read", add_commands)
    app.connect("source-read", check_numbers)
    app.connect("autodoc-process-docstring", read_docstring)
    app.connect("html-page-context", keep_words_whole)
    app.connect("build-finished", write_playground)
