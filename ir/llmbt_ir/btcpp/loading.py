"""The linter's errors: what BehaviorTree.CPP 4.10 refuses to load, to build, or to tick (docs/trees.md)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from difflib import get_close_matches

from llmbt_ir.btcpp.document import INSTRUCTION
from llmbt_ir.btcpp.findings import File
from llmbt_ir.btcpp.nodes import BUILTIN, KINDS, NodeKind, forbidden_character, is_port_name

__all__ = ["LEVELS", "check_loading", "is_unknown"]

LEVELS = 256
"""In one <BehaviorTree>; a <SubTree> starts the count again."""
VERSION_3 = {"SequenceStar": "SequenceWithMemory", "SubTreePlus": 'SubTree, with _autoremap="true" where wanted'}
PORT_NAMES = "it begins with a letter, has none of the characters that names may not have, and is not reserved"


def check_loading(file: File) -> None:
    """All errors of a file."""
    _file(file)
    _models(file)
    _trees(file)
    _circles(file)
    for tree in file.document.trees:
        for index, level in _levels(file, tree):
            _node(file, index, level)


def _file(file: File) -> None:
    d = file.document
    root = d[d.root]
    if root.tag != "root":
        file.say("T101", f"the outermost element is <{root.tag}>, not <root>", d.root, 'write <root BTCPP_format="4">')
        return
    for i, element in enumerate(d.elements):
        if element.tag == INSTRUCTION:
            file.say("T121", "a processing instruction makes loading fail", i, "remove the <?...?>")
    wanted, ids = root.get("main_tree_to_execute"), [d[t].get("ID") for t in d.trees]
    if not d.trees and not d.named(d.root, "include"):
        file.say("T120", "the file has no <BehaviorTree>", d.root)
    elif wanted and wanted not in ids and not d.named(d.root, "include"):
        title = f"main_tree_to_execute names `{wanted}`, and no <BehaviorTree> has that ID"
        file.say("T120", title, d.root, attribute="main_tree_to_execute", near=(wanted, filter(None, ids)))


def _models(file: File) -> None:
    d = file.document
    models = d.named(d.root, "TreeNodesModel")
    for extra in (m for k, m in enumerate(models) if d[m].file in {d[e].file for e in models[:k]}):
        file.say("T119", "a second <TreeNodesModel>; a file has at most one", extra)
    first: dict[tuple[str, int], int] = {}  # each file may declare what it uses
    for i in (k for m in models for k in d.kids(m)):
        element, name = d[i], d[i].get("ID")
        if element.tag not in KINDS:
            file.say("T123", f"<{element.tag}> declares no node type", i, near=(element.tag, KINDS))
            continue
        if not element.has("ID"):
            file.say("T112", f"<{element.tag}> needs an ID", i)
            continue
        _name(file, i, name, "ID")
        if (name, element.file) in first:
            line = d[first[name, element.file]].line
            file.say("T105", f"`{name}` is declared twice, first in line {line}", i, attribute="ID")
        first.setdefault((name, element.file), i)
        for p in d.kids(i):
            port = d[p].get("name")
            if d[p].tag in ("input_port", "output_port", "inout_port") and not is_port_name(port):
                file.say("T122", f"`{port}` cannot be a port's name", p, PORT_NAMES, attribute="name")


def _trees(file: File) -> None:
    d = file.document
    first: dict[str, int] = {}
    for tree in d.trees:
        name, n = d[tree].get("ID"), len(d.kids(tree))
        if name or d[tree].has("ID"):
            _name(file, tree, name, "ID")
        elif len(d.kids(d.root)) > 1:
            file.say("T103", "a <BehaviorTree> without an ID, and it is not alone in the file", tree, 'write ID="..."')
        if name in first and name:
            title = f"<BehaviorTree> `{name}` is there twice, first {d.place(first[name], tree)}"
            file.say("T105", title, tree, attribute="ID")
        first.setdefault(name, tree)
        if name in file.types and file.types[name].kind is not NodeKind.SUBTREE:
            file.say("T106", f"a tree cannot be called `{name}`: that is a node type", tree, attribute="ID")
        if n != 1:
            hint = "put the nodes into one <ReactiveSequence>" if n else "every tree has one node at its top"
            file.say("T107", f"<BehaviorTree> `{name}` has {n} nodes at its top, not 1", tree, hint)


def _circles(file: File) -> None:
    """SubTrees that contain themselves: one finding for each SubTree element that closes a circle."""
    d = file.document
    below: dict[int, list[tuple[int, int]]] = {t: [] for t in d.trees}
    for i, tree in file.calls.items():
        below[file.tree_of[i]].append((i, tree))
    done: set[int] = set()
    for start in d.trees:
        path: list[int] = []
        on_path: set[int] = set()
        stack: list[tuple[int, bool]] = [(start, False)]
        while stack:
            tree, leaving = stack.pop()
            if leaving:
                path.pop()
                on_path.discard(tree)
                done.add(tree)
                continue
            if tree in done or tree in on_path:
                continue
            path.append(tree)
            on_path.add(tree)
            stack.append((tree, True))
            for i, called in below[tree]:
                if called in on_path:
                    names = [d[t].get("ID") for t in path[path.index(called) :]]
                    title = f"SubTree `{names[0]}` contains itself: {' -> '.join([*names, names[0]])}"
                    file.say("T117", title, i, attribute="ID")
                stack.append((called, False))


def _levels(file: File, tree: int) -> Iterator[tuple[int, int]]:
    stack = [(i, 1) for i in reversed(file.document.kids(tree))]
    while stack:
        index, level = stack.pop()
        yield index, level
        stack.extend((c, level + 1) for c in reversed(file.document.kids(index)))


def _node(file: File, index: int, level: int) -> None:
    d, element, kind = file.document, file.document[index], file.kind_of(index)
    if level == LEVELS + 1:
        hint = "put a branch into a <BehaviorTree> of its own and name it by a <SubTree>"
        file.say("T108", f"nested more than {LEVELS} levels deep", index, hint)
    explicit = element.tag in KINDS
    if explicit and not element.get("ID"):
        file.say("T112", f"<{element.tag}> needs an ID", index)
        return
    _name(file, index, element.get("ID") if explicit else element.tag, "ID" if explicit else "")
    if not explicit and element.has("ID"):
        hint = f'write <{element.tag} ...>, or <{kind or NodeKind.ACTION} ID="{element.tag}" ...>'
        file.say("T113", f"<{element.tag}> may not have an ID", index, hint, attribute="ID")
    if any((ord(c) < 32 and c not in "\t\n\r") or ord(c) == 127 for c in element.get("name")):
        file.say("T124", "a control character in the name", index, attribute="name")
    parent = element.parent
    if explicit and element.tag != NodeKind.SUBTREE and d[parent].tag == "ReactiveSequence":
        hint = f"write <{element.get('ID')} .../>"
        file.say("T115", f"<{element.tag} ID=...> straight under a ReactiveSequence is refused", index, hint)
    if element.tag == NodeKind.SUBTREE:
        _subtree(file, index)
    elif file.type_of(index) not in file.types:
        _unknown(file, index)
    else:
        _ports(file, index)
    _children(file, index, kind)


def _name(file: File, index: int, name: str, attribute: str) -> None:
    bad = forbidden_character(name)
    if not name:
        file.say("T104", "an empty name", index, attribute=attribute)
    elif name in ("Root", "root"):
        file.say("T104", f"`{name}` is reserved", index, "call it something else", attribute=attribute)
    elif bad is not None:
        plain = re.sub(r"\W+", "_", name).strip("_")
        what = f"`{bad}`" if bad.isprintable() and bad != " " else "a space" if bad == " " else f"\\x{ord(bad):02x}"
        hint = f"write `{plain}`" if plain else ""
        file.say("T104", f"the name `{name}` has {what} in it", index, hint, attribute=attribute)


def is_unknown(file: File, index: int) -> bool:
    """Whether a node type that nothing declares is an error: where the file declares others, where a version before 4
    had it, or where it has children and is spelt almost as a built-in one. Any other may be registered by a program."""
    name = file.type_of(index)
    if file.declared or name in VERSION_3:
        return True
    return bool(file.document.kids(index)) and bool(get_close_matches(name, BUILTIN, cutoff=0.85))


def _unknown(file: File, index: int) -> None:
    """A node type that nothing declares."""
    name = file.type_of(index)
    if name in VERSION_3:
        file.say("T109", f"<{name}> is a node of version 3", index, f"in version 4 it is {VERSION_3[name]}")
    elif is_unknown(file, index):
        title = f"unknown node `{name}`: it is not built in, and TreeNodesModel does not declare it"
        file.say("T109", title, index, near=(name, file.types))


def _subtree(file: File, index: int) -> None:
    d, element = file.document, file.document[index]
    name = element.get("ID")
    if name not in d.by_id and not d.named(d.root, "include"):
        title = f"no <BehaviorTree> has the ID `{name}`"
        file.say("T116", title, index, attribute="ID", near=(name, filter(None, d.by_id)))
    model = file.declared.get(name)
    if model is not None and element.get("_autoremap") not in ("1", "true", "True", "TRUE"):
        for port, wanted in model.ports.items():
            if wanted.required and not element.has(port):
                hint = f'write {port}="{{{port}}}"'
                file.say(
                    "T125",
                    f"<SubTree> `{name}` needs `{port}`, which its model declares without a default",
                    index,
                    hint,
                )
    called = element.get("name")
    if called:
        same = [i for i in file.calls if i != index and d[i].get("name") == called]
        twin = min((i for i in same if file.tree_of[i] == file.tree_of[index]), default=index)
        if twin < index:
            title = f"two SubTrees are called `{called}` in one tree, the other in line {d[twin].line}"
            file.say("T118", title, index, "leave the name out, or choose another", attribute="name")


def _ports(file: File, index: int) -> None:
    element, name = file.document[index], file.type_of(index)
    ports = file.types[name].ports
    for attribute, value in element.attributes:
        if not is_port_name(attribute):
            continue
        if attribute not in ports:
            hint = "" if ports else f"`{name}` has no ports; write `_{attribute}` for a remark"
            title = f"`{name}` has no port `{attribute}`"
            file.say("T110", title, index, hint, attribute=attribute, near=(attribute, ports))
        elif name in BUILTIN and not _pointer(value) and not _converts(value, ports[attribute].type):
            title = f"`{value}` is no {ports[attribute].type.removeprefix('BT::')}, which `{attribute}` takes"
            file.say("T111", title, index, attribute=attribute)


def _pointer(value: str) -> bool:
    return len(value) >= 3 and value[0] == "{" and value[-1] == "}"


def _converts(value: str, type_: str) -> bool:
    if type_ == "int":
        return re.fullmatch(r"-?\d+", value) is not None
    if type_ == "unsigned int":
        return value.isdecimal()
    if type_ == "bool":
        return value in ("0", "1", "true", "false", "True", "False", "TRUE", "FALSE")
    if type_ == "BT::NodeStatus":
        return value in ("IDLE", "RUNNING", "SUCCESS", "FAILURE", "SKIPPED")
    return True


def _children(file: File, index: int, kind: NodeKind | None) -> None:
    name, n = file.type_of(index), len(file.document.kids(index))
    least, most = {
        NodeKind.DECORATOR: (1, 1),
        NodeKind.CONTROL: (1, None),
        None: (0, None),
    }.get(kind, (0, 0))
    if name in ("IfThenElse", "WhileDoElse"):
        least, most = 2, 3
    elif name == "TryCatch":
        least = 2
    elif re.fullmatch(r"Switch[2-6]", name):
        least = most = int(name[-1]) + 1
    if n < least or (most is not None and n > most):
        wanted = "no child" if most == 0 else f"{least}" if least == most else f"{least} or more"
        wanted = "2 or 3" if (least, most) == (2, 3) else wanted
        file.say("T114", f"<{name}> has {n or 'no'} {'child' if n == 1 else 'children'}; it takes {wanted}", index)
