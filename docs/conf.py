"""Sphinx configuration: `sphinx-build -W docs docs/_build/html`."""

import re

from sphinx.ext import napoleon

import tegotae

project = "tegotae"
author = "The tegotae developers"
copyright = f"2025, {author}"
release = version = tegotae.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
]
myst_enable_extensions = ["amsmath", "dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]

html_theme = "furo"
html_title = f"tegotae {release}"
html_static_path = ["_static"]

# Docstrings put code and equations between single backticks.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_default_options = {"special-members": "__call__"}
autodoc_typehints_format = "short"

# Every reference that a page makes to this package must lead somewhere. Not so those in signatures:
# they name other packages, and this one's classes by the private modules that define them.
nitpicky = True
nitpick_ignore_regex = [
    (r"py:.*", r"(?!tegotae\.).*"),
    (r"py:class", r"tegotae(\.\w+){3,}"),
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


def setup(app):
    """Connect the hook."""
    app.connect("autodoc-process-docstring", read_docstring)
