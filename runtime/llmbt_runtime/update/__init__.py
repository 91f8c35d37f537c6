"""BTs Update: expand, insert, certify, and otherwise plan. Pure functions on frozen trees (docs/update-loop.md)."""
