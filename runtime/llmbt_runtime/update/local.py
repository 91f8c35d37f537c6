"""The local rule: where a tree fails, the smallest edit that lets it go on (docs/update-loop.md, after the paper's
Expand and Insert and PA-BT, Colledanchise, Almeida and Ogren 2019)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.tree import Kind, Tree
from llmbt_runtime.search.heuristic import HTable
from llmbt_runtime.update.edit import achievers_in, ancestor_conditions, expand, protected, remove_achiever
from llmbt_runtime.update.rollout import Stuck

__all__ = ["Repair", "Step", "drop_excluded", "repair"]

Costs = HTable
MAX_CANDIDATES = 100
"""Of the achievers of a condition, the best so many are looked at."""
Move = tuple[str, str]


@dataclass(frozen=True, slots=True)
class Step:
    """One edit and why: what a version's record lists."""

    kind: str
    node: str
    condition: str
    action: str = ""
    alternatives: tuple[str, ...] = ()
    before: str = ""
    reason: str = ""

    def told(self) -> str:
        """The edit in one line."""
        if self.kind == "move":
            return f"moved up: {self.reason}"
        if self.kind in ("expand", "re-expand"):
            return f"{self.condition} <- {self.action}"
        return f"{self.kind}: {self.reason}"


@dataclass(frozen=True, slots=True)
class Repair:
    """The edited tree, the step, and the moves made so far (each pair at most once)."""

    tree: Tree
    step: Step
    moved: frozenset[Move]


def repair(
    tree: Tree,
    stuck: Stuck,
    domain: Domain,
    h: Costs,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    moved: frozenset[Move] = frozenset(),
    prefer: frozenset[ActionCall] = frozenset(),
    within: str | None = None,
    re_expand: bool = True,
) -> Repair | None:
    """The edit for a tree that failed, or None where the local rule knows none.

    `h` gives the cost of each literal from the state in which the tree failed, inf where it cannot be reached.
    `within` confines the edit to a branch: that of the alternative that is to be reached. Without `re_expand` a
    condition gets one achiever and no further one: for comparison only.
    """
    inside = {n.id for n in tree.preorder(within)}
    leaves = tuple(i for i in stuck.record.failed_leaves() if i in inside and tree[i].condition is not None)
    failed = next((i for i in leaves if _unexpanded(tree, i)), None)
    if failed is None:
        return _further(tree, domain, h, leaves, excluded, prefer) if re_expand else None
    cheaper = _cheaper_ancestor(tree, failed, domain, h, excluded, prefer) if re_expand else None
    if cheaper is not None:
        return Repair(*cheaper, moved)
    condition = tree[failed].condition
    assert condition is not None
    found = _candidates(tree, failed, domain, h, excluded, prefer)
    guarded = protected(tree, failed)
    for action in found:
        if not _threatened(action, guarded, domain):
            step = Step(
                "expand",
                failed,
                str(condition),
                str(action),
                tuple(str(a) for a in found if a is not action)[:8],
                reason=f"{condition} does not hold; {action} brings it about",
            )
            return Repair(expand(tree, failed, action), step, moved)
    if found:
        for i, j, f in _threatened(found[0], guarded, domain):
            head = tree.head(j)
            if (j, i) in moved or (head is not None and domain.mutex(head, f)):
                continue
            step = Step(
                "move",
                j,
                str(head),
                str(found[0]),
                tuple(str(a) for a in found[1:])[:8],
                before=i,
                reason=f"{found[0]} would undo {f}, so {head} comes before it",
            )
            return Repair(tree.move_before(j, i), step, moved | {(j, i)})
    if not re_expand:
        return None
    further = _further(tree, domain, h, ancestor_conditions(tree, failed), excluded, prefer)
    return further and Repair(further.tree, further.step, moved)


def drop_excluded(tree: Tree, stuck: Stuck) -> tuple[Tree, Step] | None:
    """Take out the achiever whose action is excluded; the action is the one the rollout wanted to run.

    None where it is no achiever of a condition, as in a tree that somebody else made.
    """
    assert stuck.record.action is not None
    branch = tree.parents.get(stuck.record.action)
    fallback = tree.parents.get(branch) if branch is not None else None
    if branch is None or fallback is None or tree[fallback].kind is not Kind.FALLBACK:
        return None
    if tree[fallback].children[0] == branch or tree[branch].kind is not Kind.SEQUENCE:
        return None
    head = tree.head(fallback)
    call = tree[stuck.record.action].action
    step = Step(
        "remove",
        branch,
        str(head),
        str(call),
        reason=f"{call} failed and is excluded until the world changes",
    )
    return remove_achiever(tree, branch), step


def _unexpanded(tree: Tree, id_: str) -> bool:
    if tree[id_].condition is None:
        return False
    parent = tree.parents.get(id_)
    return parent is None or tree[parent].kind is Kind.SEQUENCE


def _cost(h: Costs, action: GroundAction) -> float:
    return sum(h[c] for c in action.pre)


def _candidates(
    tree: Tree,
    condition_id: str,
    domain: Domain,
    h: Costs,
    excluded: frozenset[ActionCall],
    prefer: frozenset[ActionCall],
) -> tuple[GroundAction, ...]:
    """The achievers that can be reached, do not go in a circle and are not in the tree yet, best first.

    Best is: in the plan where there is one, cheapest preconditions, fewest facts ended, the library's order.
    """
    condition = tree[condition_id].condition
    assert condition is not None
    above = {tree[a].condition for a in ancestor_conditions(tree, condition_id)} | {condition}
    present = {node.action for _, node in achievers_in(tree, condition_id)} | excluded
    ranked = [entry for entry in h.achievers(condition) if entry[-1] not in present]
    ranked.sort(key=lambda entry: entry[-1] not in prefer)  # stable: within, best first
    actions = (domain.action(call) for *_, call in ranked)
    found = (a for a in actions if a is not None and above.isdisjoint(a.pre))
    return tuple(islice(found, MAX_CANDIDATES))


def _threatened(
    action: GroundAction, guarded: tuple[tuple[str, str, Condition], ...], domain: Domain
) -> tuple[tuple[str, str, Condition], ...]:
    """The guarded heads that an action ends, or that cannot hold together with its preconditions, outermost first."""
    return tuple((i, j, f) for i, j, f in guarded if action.falsifies(f) or any(domain.mutex(c, f) for c in action.pre))


def _cheaper_ancestor(
    tree: Tree,
    failed: str,
    domain: Domain,
    h: Costs,
    excluded: frozenset[ActionCall],
    prefer: frozenset[ActionCall],
) -> tuple[Tree, Step] | None:
    """Re-expansion: the nearest ancestor condition that another achiever, from the present state, brings about more
    cheaply than the one in the tree whose precondition failed (an object that is somewhere else now)."""
    below = {failed, *tree.ancestors(failed)}
    for head in ancestor_conditions(tree, failed):
        current = next(
            (
                domain.action(node.action)
                for branch, node in achievers_in(tree, head)
                if branch in below and node.action
            ),
            None,
        )
        if current is None:
            continue
        found = _candidates(tree, head, domain, h, excluded, prefer)
        if (
            found
            and _cost(h, found[0]) < _cost(h, current)
            and not _threatened(found[0], protected(tree, head), domain)
        ):
            return expand(tree, head, found[0]), _re_expansion(tree, head, found)
    return None


def _further(
    tree: Tree,
    domain: Domain,
    h: Costs,
    heads: tuple[str, ...],
    excluded: frozenset[ActionCall],
    prefer: frozenset[ActionCall],
) -> Repair | None:
    for head in heads:
        found = _candidates(tree, head, domain, h, excluded, prefer)
        safe = [a for a in found if not _threatened(a, protected(tree, head), domain)]
        if safe:
            return Repair(expand(tree, head, safe[0]), _re_expansion(tree, head, tuple(safe)), frozenset())
    return None


def _re_expansion(tree: Tree, head: str, found: tuple[GroundAction, ...]) -> Step:
    condition = tree[head].condition
    return Step(
        "re-expand",
        head,
        str(condition),
        str(found[0]),
        tuple(str(a) for a in found[1:])[:8],
        reason=f"what the tree has for {condition} does not serve from here; {found[0]} does",
    )
