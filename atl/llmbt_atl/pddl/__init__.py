"""STRIPS domains and problems in PDDL: what they become here, and how to write a library as XML."""

from llmbt_atl.pddl.domain import import_domain
from llmbt_atl.pddl.names import pddl_call, pddl_fact
from llmbt_atl.pddl.problem import PddlProblem, import_problem
from llmbt_atl.pddl.write import write_library

__all__ = ["PddlProblem", "import_domain", "import_problem", "pddl_call", "pddl_fact", "write_library"]
