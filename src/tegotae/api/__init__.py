"""The functions of the package, with their options and results: Python and the command line use
the same ones, for a hopper, for bodies with legs and for controllers of other simulators."""
