"""Between reasoning and execution: do the goals contradict each other, and do they keep to the request?"""

from llmbt_compiler.checking.abilities import unable
from llmbt_compiler.checking.contradictions import contradictions
from llmbt_compiler.checking.crowding import too_many
from llmbt_compiler.checking.grounded import ungrounded
from llmbt_compiler.checking.kept import moved_all_the_same
from llmbt_compiler.checking.obstacles import obstacles
from llmbt_compiler.checking.request import lacking, open_points
from llmbt_compiler.checking.unknown import unknown_names
from llmbt_compiler.checking.witness import witnessed

__all__ = [
    "contradictions",
    "lacking",
    "moved_all_the_same",
    "obstacles",
    "open_points",
    "too_many",
    "unable",
    "ungrounded",
    "unknown_names",
    "witnessed",
]
