"""Seeded problems for the symbolic world: a domain, a state, goals, and what happens meanwhile (docs/suite.md)."""

from llmbt_runtime.episodes.generator import EVENTS, KINDS, episode
from llmbt_runtime.episodes.model import Episode
from llmbt_runtime.episodes.truth import reachable

__all__ = ["EVENTS", "KINDS", "Episode", "episode", "reachable"]
