"""The methods by name, and one way to run them all."""

from __future__ import annotations

from collections.abc import Callable

from llmbt_atl.state import Domain
from llmbt_ir.condition import Goals
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.baselines.chain_alone import ChainPolicy
from llmbt_runtime.baselines.local_rule import LocalPolicy
from llmbt_runtime.baselines.pabt import PaBtPolicy
from llmbt_runtime.baselines.paper import PaperPolicy, Reading
from llmbt_runtime.baselines.shell import Limits, Policy, Run, carry_on
from llmbt_runtime.executor import Change, Settings, execute
from llmbt_runtime.world import World

__all__ = ["METHODS", "run"]

METHODS = {
    "paper": "the paper's Algorithm 1 to the letter",
    "paper-kind": "Algorithm 1 as the text around it means it: all achievers, a conflict is an exclusion",
    "pa-bt": "PA-BT (Colledanchise, Almeida and Ögren 2019)",
    "local": "our local rule alone, online, without certificate or plan",
    "chain": "the complete search alone, acted out as a chain",
    "loop": "the whole loop: certified before it acts",
}


def run(
    method: str,
    world: World,
    domain: Domain,
    goals: Goals,
    limits: Limits | None = None,
    *,
    tree: Tree | None = None,
    keep: Callable[[Change], None] | None = None,
) -> Run:
    """Pursue goals in a world by one of METHODS (KeyError for another name), from the tree of the goals or from `tree`.

    `keep` hears of the versions that the whole loop installs.
    """
    limits = limits or Limits()
    tree = tree or goal_tree(goals)
    if method == "loop":
        return _loop(world, domain, tree, goals, limits, keep)
    policies: dict[str, Callable[[], Policy]] = {
        "paper": lambda: PaperPolicy(Reading.LETTER),
        "paper-kind": lambda: PaperPolicy(Reading.KIND),
        "pa-bt": PaBtPolicy,
        "local": lambda: LocalPolicy(goals),
        "chain": lambda: ChainPolicy(goals, limits.expansions),
    }
    return carry_on(method, policies[method](), world, domain, tree, goals, limits)


def _loop(
    world: World, domain: Domain, tree: Tree, goals: Goals, limits: Limits, keep: Callable[[Change], None] | None
) -> Run:
    trees = [tree]

    def kept(change: Change) -> str:
        trees.append(change.grown.tree)
        if keep is not None:
            keep(change)
        return f"v{len(trees) - 1:03d}"

    settings = Settings(
        budget=limits.expansions,
        max_ticks=limits.ticks,
        attempts=limits.attempts,
        settle_s=limits.settle_s,
    )
    result = execute(world, domain, tree, goals, keep=kept, settings=settings)
    return Run(
        "loop",
        result.outcome,
        result.reason,
        False,
        result.actions,
        result.updates,
        result.planner_calls,
        result.expansions,
        max(map(len, trees)),
        result.ticks,
        trees[-1],
        result.unsolvable,
    )
