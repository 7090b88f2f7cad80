"""Recordings of anyone: columns of a file, by names and units, as `measure` takes them."""

from tegotae.measures.recordings.columns import Recording, left_alone, recording
from tegotae.measures.recordings.files import FORMATS, read_columns
from tegotae.measures.recordings.quantities import QUANTITIES

__all__ = ["FORMATS", "QUANTITIES", "Recording", "left_alone", "read_columns", "recording"]
