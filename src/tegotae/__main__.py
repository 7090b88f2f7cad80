"""`python -m tegotae`."""

from tegotae.cli import entry

entry()
