"""Goals stated as such, by a person or by a model that gives structured output: the second front end beside steps."""

from llmbt_compiler.goals.document import Literal, Stated, read_reply, read_stated
from llmbt_compiler.goals.ground import ground

__all__ = ["Literal", "Stated", "ground", "read_reply", "read_stated"]
