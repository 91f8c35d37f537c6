"""Reasoning (paper, section IV.B): a request and a semantic map become a prompt, a reply, and descriptive
steps."""
