"""Experiments: cases with the requests of many users, trials, and what they come to (docs/experiments.md)."""
