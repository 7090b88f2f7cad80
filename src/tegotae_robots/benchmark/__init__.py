"""Sparse-sensing locomotion: subjects, tracks by their senses, and the score of an entry."""
