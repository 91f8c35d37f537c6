"""The action template library: what a robot can do, what that needs and what it brings about."""
