"""Graphs of scalars as LLVM: each scalar a vector of lanes."""
