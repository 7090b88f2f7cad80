"""Statements of the paper on which the study's table has no column: how a push looks, what remains
without senses, and what ΔΩ and a longer horizon change.

`python -m research.reproduction.statements measure` and `horizon` make their tables, `report` the
effects and the table of the page. `further` is the list, judged as the claims are.
"""
