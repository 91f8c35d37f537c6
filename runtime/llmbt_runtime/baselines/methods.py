"""The methods by name, and one way to run them all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llmbt_atl.state import Domain
from llmbt_ir.condition import Goals
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.baselines.ablations import UncertifiedPolicy, chain_only, without_re_expansion
from llmbt_runtime.baselines.chain_alone import ChainPolicy
from llmbt_runtime.baselines.expansion import ExpansionPolicy
from llmbt_runtime.baselines.fixed import FixedPolicy
from llmbt_runtime.baselines.local_rule import LocalPolicy
from llmbt_runtime.baselines.pabt import PaBtPolicy
from llmbt_runtime.baselines.paper import PaperPolicy, Reading
from llmbt_runtime.baselines.shell import Limits, Policy, Run, carry_on
from llmbt_runtime.baselines.steps import FeasiblePolicy, ScriptPolicy
from llmbt_runtime.executor import Change, Settings, Updater, execute
from llmbt_runtime.update.loop import update
from llmbt_runtime.world import World

__all__ = ["EXECUTORS", "METHODS", "STEPS_ONLY", "run"]

METHODS = {
    "paper": "the paper's Algorithm 1 to the letter",
    "paper-kind": "Algorithm 1 as the text around it means it: all achievers, a conflict is an exclusion",
    "pa-bt": "PA-BT (Colledanchise, Almeida and Ögren 2019)",
    "local": "our local rule alone, online, without certificate or plan",
    "chain": "the complete search alone, acted out as a chain",
    "loop": "the whole loop: certified before it acts",
}

EXECUTORS = {
    "script": "the steps of a right plan, one after another, without feedback (declared-API code generation)",
    "retry": "the same; a step that fails is tried three times",
    "feasible": "of the steps that are left the first that helps and can be done now (SayCan, PaLM-E)",
    "fixed": "a tree fully expanded beforehand, every skill from every place, never updated",
    **{m: METHODS[m] for m in ("paper", "paper-kind", "pa-bt")},
    "expansion": "BT Expansion (Cai et al. 2021), redone whenever its tree fails",
    "chain": "a monitor: the complete search anew at every deviation, its plan acted out",
    "loop": METHODS["loop"],
    "loop-uncertified": "ours without the certificate: acts as it grows, plans where the local rule ends",
    "loop-no-re-expansion": "ours without re-expansion: a condition gets one achiever",
    "loop-chain": "ours with the chain alone: no local rule",
}
"""Ways to execute what a language model asked for, from none to the whole loop, all behind `run`."""

STEPS_ONLY = ("script", "retry", "feasible")
"""Those that have no tree."""

UPDATERS: dict[str, Updater] = {
    "loop": update,
    "loop-no-re-expansion": without_re_expansion,
    "loop-chain": chain_only,
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
    grew: Callable[[Tree], None] = lambda _: None,
    clock: Callable[[], float] = lambda: 0.0,
) -> Run:
    """Pursue goals in a world by one of METHODS or EXECUTORS (KeyError for another name), from the tree of the goals or
    from `tree`.

    `keep` hears of the versions that the whole loop installs, `grew` of every changed tree of any method; `clock`
    measures the time spent on changing it.
    """
    limits = limits or Limits()
    tree = tree or goal_tree(goals)
    if method in UPDATERS:
        return _loop(method, world, domain, tree, goals, limits, keep, grew, clock)
    policies: dict[str, Callable[[], Policy]] = {
        "script": lambda: ScriptPolicy(goals, limits.expansions),
        "retry": lambda: ScriptPolicy(goals, limits.expansions, attempts=3),
        "feasible": lambda: FeasiblePolicy(goals, limits.expansions),
        "fixed": lambda: FixedPolicy(goals, limits.expansions),
        "expansion": lambda: ExpansionPolicy(goals, limits.expansions, limits.nodes),
        "loop-uncertified": lambda: UncertifiedPolicy(goals, budget=limits.expansions),
        "paper": lambda: PaperPolicy(Reading.LETTER),
        "paper-kind": lambda: PaperPolicy(Reading.KIND),
        "pa-bt": PaBtPolicy,
        "local": lambda: LocalPolicy(goals),
        "chain": lambda: ChainPolicy(goals, limits.expansions),
    }
    return carry_on(method, policies[method](), world, domain, tree, goals, limits, grew, clock)


def _loop(
    method: str,
    world: World,
    domain: Domain,
    tree: Tree,
    goals: Goals,
    limits: Limits,
    keep: Callable[[Change], None] | None,
    grew: Callable[[Tree], None],
    clock: Callable[[], float],
) -> Run:
    trees, spent = [tree], 0.0

    def timed(*args: Any, **kwargs: Any) -> Any:
        nonlocal spent
        began = clock()
        try:
            return UPDATERS[method](*args, **kwargs)
        finally:
            spent += clock() - began

    def kept(change: Change) -> str:
        trees.append(change.grown.tree)
        grew(change.grown.tree)
        if keep is not None:
            keep(change)
        return f"v{len(trees) - 1:03d}"

    settings = Settings(
        budget=limits.expansions,
        max_ticks=limits.ticks,
        attempts=limits.attempts,
        settle_s=limits.settle_s,
    )
    result = execute(world, domain, tree, goals, keep=kept, settings=settings, updater=timed)
    return Run(
        method,
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
        spent,
    )
