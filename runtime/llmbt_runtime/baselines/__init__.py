"""Other ways to update a tree while it runs, for comparison, all behind `run` (docs/suite.md)."""

from llmbt_runtime.baselines.methods import EXECUTORS, METHODS, STEPS_ONLY, run
from llmbt_runtime.baselines.shell import Limits, Run

__all__ = ["EXECUTORS", "METHODS", "STEPS_ONLY", "Limits", "Run", "run"]
