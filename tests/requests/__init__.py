"""Requests over the scenes, and whether what is decided about each is right."""
