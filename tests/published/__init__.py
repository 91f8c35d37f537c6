"""Steps that nobody here wrote, scored by what they mean; the texts are read from a local copy."""
