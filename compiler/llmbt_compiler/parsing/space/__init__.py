"""Words of space grounded in coordinates: relations, ranks and orders become ids before the walk sees them."""

from llmbt_compiler.parsing.space.comparing import compared
from llmbt_compiler.parsing.space.orders import arrangement
from llmbt_compiler.parsing.space.settling import certainty, related
from llmbt_compiler.parsing.space.stepping import stepped

__all__ = ["arrangement", "certainty", "compared", "related", "stepped"]
