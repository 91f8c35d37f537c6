"""Keywords: which words of a step name its action, its target, its destination and its location."""
