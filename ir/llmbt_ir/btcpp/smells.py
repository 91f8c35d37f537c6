"""The linter's warnings: files that load, and yet do not do what they seem to say (docs/trees.md)."""

from __future__ import annotations

from collections.abc import Iterator

from llmbt_ir.btcpp.findings import Effect, File
from llmbt_ir.btcpp.loading import is_unknown
from llmbt_ir.btcpp.match import Content, content_of
from llmbt_ir.btcpp.nodes import BUILTIN, CONDITIONS_OF_NODES, REACTIVE, REMEMBERING, NodeKind
from llmbt_ir.diagnostics import Diagnostic, Severity, Span

__all__ = ["check_smells"]

SEQUENCES = frozenset({"Sequence", "ReactiveSequence", "AsyncSequence", "SequenceWithMemory"})
FALLBACKS = frozenset({"Fallback", "ReactiveFallback", "AsyncFallback"})
SUCCESS, FAILURE, RUNNING, SKIPPED = "S", "F", "R", "K"
ANY = frozenset((SUCCESS, FAILURE, RUNNING, SKIPPED))
Results = frozenset[str]
SCRIPTS = frozenset({"code", "if"})


def check_smells(file: File) -> None:
    """All warnings of a file."""
    d = file.document
    for line in d.loose:
        span = Span(d.source, line, text=d.lines[line - 1])
        title = "`&` or `<` as such in a value: BehaviorTree.CPP reads it, Groot2 and other XML programs do not"
        file.found.append(Diagnostic("T216", title, span, "", "write &amp; and &lt;", Severity.WARNING))
    if d[d.root].get("BTCPP_format") != "4":
        file.say("T201", "the file does not say that it is for version 4", d.root, 'write <root BTCPP_format="4" ...>')
    if not d[d.root].get("main_tree_to_execute") and len(d.trees) > 1:
        hint = f'write main_tree_to_execute="{d[d.trees[0]].get("ID")}"'
        file.say("T210", f"{len(d.trees)} trees, and main_tree_to_execute does not say which to run", d.root, hint)
    _undeclared(file)
    _unused(file)
    _memory(file)
    _unreached(file)
    for tree in d.trees:
        for i in d.below(tree):
            if i != tree:
                _attributes(file, i)
                _twice(file, i)
    _unguarded(file)


def _undeclared(file: File) -> None:
    if file.declared:
        return
    d = file.document
    told: set[str] = set()
    for i in (i for t in d.trees for i in d.below(t) if i != t):
        name = file.type_of(i)
        if name not in file.types and name not in told and not is_unknown(file, i):
            told.add(name)
            kind = file.kind_of(i) or (("Action", "Decorator")[len(d.kids(i))] if len(d.kids(i)) < 2 else "Control")
            hint = f'declare it: <TreeNodesModel><{kind} ID="{name}"/>'
            file.say(
                "T209",
                f"no TreeNodesModel declares `{name}`: its ports cannot be checked, nor shown by Groot2",
                i,
                hint,
            )


def _unused(file: File) -> None:
    d = file.document
    if d.main not in d.by_id:
        return
    seen: set[int] = set()
    stack = [d.by_id[d.main]]
    below: dict[int, list[int]] = {}
    for i, tree in file.calls.items():
        below.setdefault(file.tree_of[i], []).append(tree)
    while stack:
        tree = stack.pop()
        if tree not in seen:
            seen.add(tree)
            stack.extend(below.get(tree, ()))
    for tree in d.trees:
        if d[tree].file:  # a library of trees has more than one program uses
            continue
        if tree not in seen and d[tree].get("ID") and d.by_id[d[tree].get("ID")] == tree:
            file.say("T207", f"tree `{d[tree].get('ID')}` is not used from `{d.main}`", tree, attribute="ID")


def _memory(file: File) -> None:
    """Nodes that remember, in a tree that is reactive elsewhere."""
    d = file.document
    for tree in d.trees:
        inside = [i for i in d.below(tree) if i != tree]
        if not any(d[i].tag in REACTIVE for i in inside):
            continue
        for i in inside:
            if d[i].tag in REMEMBERING:
                title = f"<{d[i].tag}> remembers where it stopped, in a tree that is reactive elsewhere"
                what = "an earlier condition that changes is not looked at again; "
                file.say("T202", title, i, f"{what}write <{REMEMBERING[d[i].tag]}>")


def _attributes(file: File, index: int) -> None:
    element, name = file.document[index], file.type_of(index)
    model = file.types.get(name)
    for key, value in element.attributes:
        if ":" in key:
            file.say("T212", f"`{key}` has a namespace, which version 4.8 does not load", index, attribute=key)
        wanted = next((c for c in CONDITIONS_OF_NODES if c.lower() == key.lower() and c != key), None)
        if wanted:
            file.say("T214", f"`{key}` is ignored", index, f"did you mean {wanted}?", attribute=key)
        braces = value.count("{") + value.count("}")
        pointer = braces == 2 and value[0] == "{" and value[-1] == "}" and len(value) > 2
        if braces and not pointer and key[0] != "_" and key not in SCRIPTS and key != "name":
            hint = "a blackboard entry is {name} and nothing else; a literal brace is better avoided"
            file.say("T208", f"`{value}` is taken as it stands, not as a blackboard entry", index, hint, attribute=key)
    if model is not None:
        for port, wanted_port in model.ports.items():
            if wanted_port.required and not element.has(port) and element.tag != NodeKind.SUBTREE:
                file.say("T211", f"`{name}` is given no `{port}`, which has no default", index, f'write {port}="..."')


# -- what is never reached -----------------------------------------------------------------------------------------


def _unreached(file: File) -> None:
    d = file.document
    results: dict[int, Results] = {}
    for tree in _callees_first(file):
        for i in reversed(tuple(d.below(tree))):
            if i == tree:
                continue
            kids = [results[c] for c in d.kids(i)]
            found = _results(file, i, kids, results)
            guarded = any(k in CONDITIONS_OF_NODES and k != "_autoremap" for k, _ in d[i].attributes)
            results[i] = ANY if guarded else found
            stop = _last_reached(file.type_of(i), kids)
            if stop is not None and stop + 1 < len(kids):
                blocker, lost = d.kids(i)[stop], d.kids(i)[stop + 1]
                never = "never succeeds" if d[i].tag in SEQUENCES else "never fails"
                title = f"never reached: <{d[blocker].tag}> before it, {d.place(blocker, lost)}, {never}"
                file.say("T203", title, lost, "remove it, or put it before")
        top = d.kids(tree)
        results[tree] = results[top[0]] if len(top) == 1 else ANY


def _callees_first(file: File) -> Iterator[int]:
    """The trees, each after those it names; circles are cut."""
    below: dict[int, list[int]] = {}
    for i, tree in file.calls.items():
        below.setdefault(file.tree_of[i], []).append(tree)
    seen: set[int] = set()
    for start in file.document.trees:
        stack: list[tuple[int, bool]] = [(start, False)]
        while stack:
            tree, leaving = stack.pop()
            if leaving:
                yield tree
            elif tree not in seen:
                seen.add(tree)
                stack.append((tree, True))
                stack.extend((t, False) for t in below.get(tree, ()) if t not in seen)


def _last_reached(name: str, kids: list[Results]) -> int | None:
    """The child at which a composite always stops, where there is one."""
    if name not in SEQUENCES and name not in FALLBACKS:
        return None
    go_on = {SUCCESS, SKIPPED} if name in SEQUENCES else {FAILURE, SKIPPED}
    return next((k for k, kid in enumerate(kids) if not kid & go_on), None)


LEAVES: dict[str, Results] = {
    "AlwaysSuccess": frozenset(SUCCESS),
    "AlwaysFailure": frozenset(FAILURE),
    "Script": frozenset(SUCCESS),
    "SetBlackboard": frozenset(SUCCESS),
    "UnsetBlackboard": frozenset(SUCCESS),
    "Sleep": frozenset((SUCCESS, RUNNING)),
}


def _results(file: File, index: int, kids: list[Results], known: dict[int, Results]) -> Results:
    """What a node can return."""
    name, kind = file.type_of(index), file.kind_of(index)
    if kind is NodeKind.SUBTREE:
        return known.get(file.calls.get(index, -1), ANY)
    if name in SEQUENCES or name in FALLBACKS:
        go_on, end = (SUCCESS, FAILURE) if name in SEQUENCES else (FAILURE, SUCCESS)
        stop = _last_reached(name, kids)
        reached = kids if stop is None else kids[: stop + 1]
        found = {r for kid in reached for r in kid if r in (end, RUNNING)}
        if stop is None and any(go_on in kid for kid in kids):
            found.add(go_on)
        if stop is None and all(SKIPPED in kid for kid in kids):
            found.add(SKIPPED)
        return frozenset(found)
    child = kids[0] if len(kids) == 1 else ANY
    aside = child & {RUNNING, SKIPPED}
    if name == "Inverter":
        swap = {SUCCESS: FAILURE, FAILURE: SUCCESS}
        return frozenset(swap.get(r, r) for r in child)
    if name in ("ForceSuccess", "ForceFailure"):
        ends = child & {SUCCESS, FAILURE}
        return aside | ({SUCCESS if name == "ForceSuccess" else FAILURE} if ends else frozenset())
    if name == "KeepRunningUntilFailure":
        return (child & {FAILURE, SKIPPED}) | {RUNNING}
    if name in LEAVES:
        return LEAVES[name]
    if kind is NodeKind.CONDITION:
        return frozenset((SUCCESS, FAILURE))
    return ANY


# -- conditions checked twice --------------------------------------------------------------------------------------


def _literal(file: File, index: int) -> tuple[Content, bool] | None:
    """A condition and whether it is negated; None for anything else."""
    d, negated = file.document, False
    while d[index].tag == "Inverter" and len(d.kids(index)) == 1:
        index, negated = d.kids(index)[0], not negated
    return (content_of(d, index), negated) if file.kind_of(index) is NodeKind.CONDITION else None


def _twice(file: File, index: int) -> None:
    """The same condition twice in one composite with nothing but conditions between."""
    d, name = file.document, file.document[index].tag
    if name not in SEQUENCES and name not in FALLBACKS:
        return
    seen: dict[Content, tuple[bool, int]] = {}
    for child in d.kids(index):
        literal = _literal(file, child)
        if literal is None:
            seen.clear()
            continue
        content, negated = literal
        if content not in seen:
            seen[content] = (negated, child)
            continue
        before, first = seen[content]
        if before == negated:
            title = f"`{content.label()}` is checked twice in one {name}, first {d.place(first, child)}"
            file.say("T204", title, child, "remove one")
        else:
            never = "so it never succeeds" if name in SEQUENCES else "so it never fails"
            title = f"`{content.label()}` and its opposite, {d.place(first, child)}, in one {name}, {never}"
            file.say("T205", title, child)


# -- actions without what they bring about before them -------------------------------------------------------------


def _unguarded(file: File) -> None:
    """In a reactive tree, an action before which nothing asks whether it has been done."""
    d = file.document
    reactive = {t for t in d.trees if any(d[i].tag in REACTIVE for i in d.below(t))}
    guarded = _guarded(file)
    for tree in d.trees:
        for i in d.below(tree):
            name = file.type_of(i)
            if tree not in reactive or file.kind_of(i) is not NodeKind.ACTION or name in BUILTIN:
                continue
            effects = file.effects.get(name)
            label = content_of(d, i).label()
            if effects:
                if not _guarded_by(file, i, effects):
                    wanted = " or ".join(_shown(e, content_of(d, i)) for e in effects[:3])
                    title = f"nothing before `{label}` asks whether {wanted} holds already"
                    file.say("T206", title, i, "put it into a ReactiveFallback after that condition")
            elif i not in guarded:
                title = f"nothing before `{label}` asks whether it is done: it starts again at every tick"
                file.say("T206", title, i, "put it into a ReactiveFallback after the condition that it brings about")


def _asks(file: File, index: int) -> bool:
    """Whether a branch begins with a condition."""
    d = file.document
    while (d[index].tag in SEQUENCES or d[index].tag in FALLBACKS) and d.kids(index):
        index = d.kids(index)[0]
    return _literal(file, index) is not None


def _guarded(file: File) -> set[int]:
    """The elements before which, in a Fallback above them, something is asked; through SubTrees where all that name
    a tree are."""
    d = file.document
    found: set[int] = set()
    for tree in reversed(tuple(_callees_first(file))):
        callers = file.called_from.get(tree, ())
        if callers and all(c in found for c in callers):
            found.add(tree)
        for i in d.below(tree):
            asked = i in found
            for child in d.kids(i):
                if asked:
                    found.add(child)
                elif d[i].tag in FALLBACKS:
                    asked = _asks(file, child)
    return found


def _guarded_by(file: File, index: int, effects: tuple[Effect, ...]) -> bool:
    """Whether one of an action's effects is asked for before it: alone, or in a row of a chain."""
    d = file.document
    wanted = {_bound(e, content_of(d, index)) for e in effects}
    seen: set[int] = set()
    stack = [index]
    while stack:
        child = stack.pop()
        parent = d[child].parent
        while parent >= 0 and d[parent].tag != "BehaviorTree":
            if d[parent].tag in FALLBACKS:
                before = d.kids(parent)[: d.kids(parent).index(child)]
                rows = (r for b in before for r in ((b, *d.kids(b)) if d[b].tag in SEQUENCES else (b,)))
                if any(_literal(file, r) in wanted for r in rows):
                    return True
            child, parent = parent, d[parent].parent
        callers = [c for c in file.called_from.get(parent, ()) if c not in seen]
        seen.update(callers)
        stack.extend(callers)
    return False


def _bound(effect: Effect, action: Content) -> tuple[Content, bool]:
    given = dict(action.attributes)
    ports = ((k, given.get(v[1:-1], v) if v[:1] == "{" else v) for k, v in effect.ports)
    return Content(effect.type, tuple(sorted(ports))), effect.negated


def _shown(effect: Effect, action: Content) -> str:
    content, negated = _bound(effect, action)
    return f"`{'not ' if negated else ''}{content.label()}`"
