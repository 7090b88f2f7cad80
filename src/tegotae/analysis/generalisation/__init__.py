"""Robustness of trained controllers in conditions outside their training."""
