"""The command line: puts compiler and runtime together, renders, and decides exit codes."""
