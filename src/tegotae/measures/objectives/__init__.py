"""Objectives: the measures that a training maximises."""
