"""The local rule: where a tree fails, the smallest edit that lets it go on (docs/update-loop.md, after the paper's
Expand and Insert and PA-BT, Colledanchise, Almeida and Ogren 2019)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Condition, holds
from llmbt_ir.tree import Kind, Tree
from llmbt_runtime.search.heuristic import HTable
from llmbt_runtime.update.edit import achievers_in, ancestor_conditions, expand, protected, remove_achiever
from llmbt_runtime.update.rollout import Stuck
from llmbt_runtime.update.step import Step

__all__ = ["ALTERNATIVES", "Move", "Repair", "drop_excluded", "helpful_goal", "repair"]

MAX_CANDIDATES = 100
"""Of the achievers of a condition, the best so many are looked at."""
ALTERNATIVES = 8
"""So many of the achievers that were not taken are recorded."""
Move = tuple[str, str]


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
    h: HTable,
    *,
    moved: frozenset[Move] = frozenset(),
    within: str | None = None,
    re_expand: bool = True,
) -> Repair | None:
    """The edit for a tree that failed, or None where the local rule knows none.

    `h` gives the cost of each literal from the state in which the tree failed, and the actions that may be used.
    `within` confines the edit to a branch: that of the alternative that is to be reached. Without `re_expand` a
    condition gets one achiever and no further one: for comparison only.
    """
    inside = {n.id for n in tree.preorder(within)}
    leaves = tuple(i for i in stuck.record.failed_leaves() if i in inside and tree[i].condition is not None)
    failed = next((i for i in leaves if _unexpanded(tree, i)), None)
    if failed is None:
        return _further(tree, domain, h, leaves) if re_expand else None
    cheaper = _cheaper_ancestor(tree, failed, domain, h) if re_expand else None
    if cheaper is not None:
        return Repair(*cheaper, moved)
    condition = tree[failed].condition
    assert condition is not None
    candidates = _candidates(tree, failed, h)
    guarded = protected(tree, failed)
    found: list[GroundAction] = []
    for action in candidates:
        if not _threatened(action, guarded, domain):
            step = Step(
                "expand",
                failed,
                str(condition),
                str(action),
                *_told((*found, *islice(candidates, ALTERNATIVES)), h),
                reason=f"{condition} does not hold; {action} brings it about",
            )
            return Repair(expand(tree, failed, action), step, moved)
        found.append(action)
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
                *_told(found[1:], h),
                before=i,
                reason=f"{found[0]} would undo {f}, so {head} comes before {tree.head(i) or f}",
            )
            return Repair(tree.move_before(j, i), step, moved | {(j, i)})
    further = _further(tree, domain, h, ancestor_conditions(tree, failed)) if re_expand else None
    return further and Repair(further.tree, further.step, moved)


def helpful_goal(tree: Tree, stuck: Stuck, h: HTable, top: str, moved: frozenset[Move]) -> Repair | None:
    """A goal that comes before the one that failed: it is nearer, and the way to it has a part in common with the
    other's way, or with that of a goal of which this is true in turn (what stands in the way has a goal of its own, and
    something else stands there). None where there is no such one: then the goals stay as they were stated.

    `top` is the Sequence of the goals; only goals that are not expanded change places.
    """
    goals = tree[top].children
    failed = next((i for i in stuck.record.failed_leaves() if tree[i].condition is not None), None)
    if failed not in goals:
        return None
    waiting = {g: c for g in goals if (c := tree[g].condition) is not None and not holds(c, stuck.facts)}
    if all(h[c] >= h[waiting[failed]] for c in waiting.values()):
        return None
    ways = {g: h.relaxed_plan(c) for g, c in waiting.items()}
    joined, open_ = {failed}, [failed]
    while open_:
        way = ways[open_.pop()]
        more = [g for g in waiting if g not in joined and not way.isdisjoint(ways[g])]
        joined.update(more)
        open_ += more
    best = min((g for g in goals if g in joined), key=lambda g: h[waiting[g]])
    goal, other = waiting[best], waiting[failed]
    if h[goal] >= h[other] or (best, failed) in moved:
        return None
    near = f"an estimate of {h[goal]:.0f} to {h[other]:.0f}"
    reason = f"{goal} is nearer from here ({near}) and on the way to {other}, so {goal} comes before {other}"
    step = Step("move", best, str(goal), before=failed, reason=reason)
    return Repair(tree.move_before(best, failed), step, moved | {(best, failed)})


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


def _told(actions: Iterable[GroundAction], h: HTable) -> tuple[tuple[str, ...], int]:
    """Alternatives as they are recorded, those that could start at once first, and how many those are."""
    told = sorted(islice(actions, ALTERNATIVES), key=lambda a: h.total(a.pre) > 0)
    return tuple(map(str, told)), sum(h.total(a.pre) == 0 for a in told)


def _candidates(tree: Tree, condition_id: str, h: HTable) -> Iterator[GroundAction]:
    """The achievers that can be reached, do not go in a circle and are not in the tree yet, best first.

    Best is: cheapest preconditions, fewest facts ended, the library's order.
    """
    condition = tree[condition_id].condition
    assert condition is not None
    above = {tree[a].condition for a in ancestor_conditions(tree, condition_id)} | {condition}
    present = {node.action for _, node in achievers_in(tree, condition_id)}
    ranked = (r for r in h.achievers(condition) if not present or r.call not in present)
    return islice((a for a in map(h.action, ranked) if above.isdisjoint(a.pre)), MAX_CANDIDATES)


def _threatened(
    action: GroundAction, guarded: tuple[tuple[str, str, Condition], ...], domain: Domain
) -> tuple[tuple[str, str, Condition], ...]:
    """The guarded heads that an action ends, or that cannot hold together with its preconditions, outermost first."""
    return tuple((i, j, f) for i, j, f in guarded if action.falsifies(f) or any(domain.mutex(c, f) for c in action.pre))


def _cheaper_ancestor(tree: Tree, failed: str, domain: Domain, h: HTable) -> tuple[Tree, Step] | None:
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
        condition = tree[head].condition
        if current is None or condition is None:
            continue
        cost = h.total(current.pre)
        if h[condition] > cost:  # it is 1 and the cost of the cheapest Pre: none is cheaper
            continue
        candidates = _candidates(tree, head, h)
        best = next(candidates, None)
        if best is not None and h.total(best.pre) < cost and not _threatened(best, protected(tree, head), domain):
            return expand(tree, head, best), _re_expansion(tree, head, best, candidates, h)
    return None


def _further(tree: Tree, domain: Domain, h: HTable, heads: tuple[str, ...]) -> Repair | None:
    for head in heads:
        guarded = protected(tree, head)
        safe = (a for a in _candidates(tree, head, h) if not _threatened(a, guarded, domain))
        best = next(safe, None)
        if best is not None:
            return Repair(expand(tree, head, best), _re_expansion(tree, head, best, safe, h), frozenset())
    return None


def _re_expansion(tree: Tree, head: str, best: GroundAction, others: Iterable[GroundAction], h: HTable) -> Step:
    return Step(
        "re-expand",
        head,
        str(tree[head].condition),
        str(best),
        *_told(others, h),
        reason=f"what the tree has for {tree[head].condition} does not serve from here; {best} does",
    )
