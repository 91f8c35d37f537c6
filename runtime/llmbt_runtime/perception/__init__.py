"""Seeing: images, what they show of things that are looked for, and what is known of those that are not seen."""
