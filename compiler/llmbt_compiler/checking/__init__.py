"""Between reasoning and execution: do the goals contradict each other, and do they keep to the request?"""

from llmbt_compiler.checking.contradictions import contradictions
from llmbt_compiler.checking.request import open_points
from llmbt_compiler.checking.unknown import unknown_names

__all__ = ["contradictions", "open_points", "unknown_names"]
