"""A plan as a tree along its causal links: each action below the one that needs what it brings about.

A causal link (McAllester and Rosenblitt, "Systematic nonlinear planning", AAAI 1991) leads from the action that makes a
literal true to the action, or the goals, that need it. The plan is read from left to right with a stack, as a parser
reads a sentence: an action takes from the top of the stack those that it needs, and all above one that nobody needs
later. The order of the tree is then the order of the plan, and the tree runs the plan, if

- an action hangs by a literal that is false from the first action below it until it is done: its branch is entered;
- that literal holds from then on until the action above is done: the branch is not entered again;
- what else an action needs is looked at before its children where it holds all the while, and after them otherwise.

An action that has to come before another, and gives it nothing, hangs by a literal that lasts. Not every plan can be
read so; the rows of a chain always work (`update.chain`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

from llmbt_atl.state import GroundAction, apply
from llmbt_ir.condition import Condition, Facts, Goals, holds
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.update.edit import branch
from llmbt_runtime.update.step import Step

__all__ = ["linked_tree"]

_NEVER = 1 << 60
"""Later than any state."""


def linked_tree(
    goals: Goals, wanted: int, plan: tuple[GroundAction, ...], facts: Facts
) -> tuple[Tree, tuple[Step, ...]] | None:
    """The goals' initial tree, grown for the alternative `wanted` to run a plan from a state, and its edits; None where
    the plan cannot be read so. The goals keep their ids."""
    links = _links(plan, facts, goals[wanted])
    nest = _nested(links)
    return None if nest is None else _grown(goals, wanted, links, nest)


@dataclass(frozen=True, slots=True)
class _Links:
    """Who makes what true for whom. A consumer is an action's place in the plan, or `len(plan)` for the goals."""

    plan: tuple[GroundAction, ...]
    needs: tuple[dict[Condition, int], ...]
    """Of each consumer its literals, each with the action that makes it true for it, -1 for the first state."""
    made: tuple[dict[Condition, int], ...]
    """Of each action the literals that it makes true, each with the first state since which it was false."""
    lost: dict[tuple[int, Condition], int]
    """The first state in which a literal that an action made true is false again."""
    uses: tuple[dict[int, list[Condition]], ...]
    """Of each action its consumers, in order, with the literals that they have from it."""

    def last(self, j: int) -> int:
        """The last consumer of an action; the action itself where it has none."""
        return max(self.uses[j], default=j)

    def purpose(self, j: int) -> list[Condition]:
        """What an action is there for: the goals that it makes true for good, or else what its first consumer needs."""
        return self.uses[j].get(len(self.plan)) or next(iter(self.uses[j].values()), [])

    def useful(self, j: int) -> set[Condition]:
        """What anybody has of an action."""
        return {q for literals in self.uses[j].values() for q in literals}


def _links(plan: tuple[GroundAction, ...], facts: Facts, goals: tuple[Condition, ...]) -> _Links:
    needs: list[dict[Condition, int]] = []
    made: list[dict[Condition, int]] = []
    lost: dict[tuple[int, Condition], int] = {}
    uses: tuple[dict[int, list[Condition]], ...] = tuple({} for _ in plan)
    maker: dict[Condition, int] = {}
    false_since: dict[Condition, int] = {}
    state = facts
    for i, wanted in enumerate((*(a.pre for a in plan), goals)):
        needs.append({c: maker.get(c, -1) for c in wanted})
        for c, j in needs[i].items():
            if j >= 0:
                uses[j].setdefault(i, []).append(c)
        if i == len(plan):
            break
        action = plan[i]
        begun = sorted(c for c in (*action.adds, *(~d for d in action.deletes)) if not holds(c, state))
        made.append({c: false_since.get(c, 0) for c in begun})
        for c in begun:
            false_since[~c] = i + 1
            if ~c in maker:
                lost[maker.pop(~c), ~c] = i + 1
            maker[c] = i
        state = apply(action, state)
    return _Links(plan, tuple(needs), tuple(made), lost, uses)


@dataclass(frozen=True, slots=True)
class _Nest:
    """Of each consumer the actions right below it, in the order of the plan, each with the literal by which it hangs;
    and the first action at or below it."""

    below: list[dict[Condition, int]]
    first: list[int]


def _nested(links: _Links) -> _Nest | None:
    """The plan read with a stack."""
    end = len(links.plan)
    nest = _Nest([], list(range(end + 1)))
    stack: list[int] = []
    for c in range(end + 1):
        for start, serves in _starts(links, stack, c):
            taken = _hung(links, nest, stack[start:], c)
            begin = nest.first[stack[start]] if start < len(stack) else c
            if taken is not None and (c == end or any(links.made[c][q] <= begin for q in serves)):
                break
        else:
            return None
        nest.below.append(taken)
        nest.first[c] = begin
        stack[start:] = [c]
    return nest


def _starts(links: _Links, stack: list[int], c: int) -> Iterator[tuple[int, Collection[Condition]]]:
    """From where on a consumer may take the stack, the most first, each with the literals of which one has to be left
    for it to hang by. What cannot wait it has to take; what it needs besides it takes, but for goals, where it can then
    still hang by what it is there for."""
    end = len(links.plan)
    must = next((k for k, j in enumerate(stack) if links.last(j) <= c), len(stack))
    start = must
    while start and stack[start - 1] in links.needs[c].values() and links.last(stack[start - 1]) < end:
        start -= 1
    if c < end:
        yield from ((k, links.purpose(c)) for k in range(start, must))
    yield must, links.useful(c) if c < end else ()


def _hung(links: _Links, nest: _Nest, taken: list[int], c: int) -> dict[Condition, int] | None:
    """Actions below a consumer, each with the literal by which it can hang there; None where one has none.

    Best is what the consumer needs. Below the goals there is nothing else: it would be looked at for ever.
    """
    found: dict[Condition, int] = {}
    for j in taken:
        fresh = [q for q, since in links.made[j].items() if since <= nest.first[j]]
        needed = [q for q in fresh if links.needs[c].get(q) == j]
        lasting = [q for q in fresh if links.lost.get((j, q), _NEVER) > c + 1] if c < len(links.plan) else []
        if not needed and not lasting:
            return None
        useful = links.useful(j)
        found[needed[0] if needed else min(lasting, key=lambda q: (q not in useful, q.negated, q))] = j
    return found


def _order(links: _Links, nest: _Nest, c: int) -> tuple[Condition, ...]:
    """What is looked at before a consumer acts: what holds all the while, its children, what holds after them."""
    leaves = {q: j for q, j in links.needs[c].items() if q not in nest.below[c]}
    steady = [q for q, j in leaves.items() if j < nest.first[c]]
    return (*steady, *nest.below[c], *(q for q in leaves if q not in steady))


def _grown(goals: Goals, wanted: int, links: _Links, nest: _Nest) -> tuple[Tree, tuple[Step, ...]]:
    tree, end = goal_tree(goals), len(links.plan)
    top = tree[tree.root if len(goals) == 1 else f"alt{wanted + 1}"]
    leaf_of = {tree[i].condition: i for i in top.children}
    nodes = dict(tree.nodes)
    nodes[top.id] = replace(top, children=tuple(leaf_of[q] for q in _order(links, nest, end)))
    steps: list[Step] = []
    open_ = [(end, top.id)]
    while open_:
        c, above = open_.pop()
        children: list[str] = []
        deeper: list[tuple[int, str]] = []
        for leaf in nodes[above].children:
            literal = nodes[leaf].condition
            if literal is None or literal not in nest.below[c]:
                children.append(leaf)
                continue
            j = nest.below[c][literal]
            fallback, sequence, *rest = branch(leaf, links.plan[j], _order(links, nest, j))
            nodes.update((n.id, n) for n in (fallback, sequence, *rest))
            children.append(fallback.id)
            steps.append(Step("expand", leaf, str(literal), str(links.plan[j]), reason=_why(links, c, j, literal)))
            deeper.append((j, sequence.id))
        nodes[above] = replace(nodes[above], children=tuple(children))
        open_ += reversed(deeper)
    return Tree(tree.root, nodes), tuple(steps)


def _why(links: _Links, c: int, j: int, literal: Condition) -> str:
    action = links.plan[j]
    if c == len(links.plan):
        return f"the goal {literal} is reached by {action} in the plan"
    if literal in links.needs[c]:
        return f"{links.plan[c]} needs {literal}; in the plan {action} brings it about"
    return f"in the plan {action} comes before {links.plan[c]}, for the sake of what comes later"
