"""The command line: puts compiler and runtime together, renders, and decides exit codes."""

__version__ = "0.1.0"
