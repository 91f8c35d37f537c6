"""Pruning: what a certificate does not run is taken out again."""

from __future__ import annotations

from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Facts, Goals
from llmbt_ir.tree import Tree
from llmbt_runtime.update.edit import remove_achiever
from llmbt_runtime.update.grown import Grown
from llmbt_runtime.update.rollout import Certificate, rollout
from llmbt_runtime.update.step import Step

__all__ = ["prune"]


def prune(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    certificate: Certificate,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
) -> Grown | None:
    """The tree without the achievers that its certificate does not run, certified; None where nothing can go.

    What is taken out grows again when it is needed.
    """
    used = set(certificate.nodes)
    steps: list[Step] = []
    smaller = tree
    for node in tuple(tree.preorder()):
        if node.action is None or node.id in used or node.id not in smaller.nodes:
            continue
        branch = smaller.parents.get(node.id)
        fallback = smaller.parents.get(branch) if branch is not None else None
        if branch is None or fallback is None or smaller.head(fallback) is None:
            continue
        inside = {n.id for n in smaller.preorder(branch)}
        if inside & used:
            continue
        head = str(smaller.head(fallback))
        smaller = remove_achiever(smaller, branch)
        steps.append(Step("prune", branch, head, str(node.action), reason="the certificate does not run it"))
    if not steps:
        return None
    found = rollout(smaller, domain, facts, goals, excluded=excluded)
    return Grown(smaller, found, tuple(steps)) if isinstance(found, Certificate) else None
