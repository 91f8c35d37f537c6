"""Runs behaviour trees against a world and lets them grow where a condition fails."""
