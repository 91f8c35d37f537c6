"""What the header of a point cloud's file promises, held against what is in the file: a torn one is read as whole."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["shortage"]

_PLY_BYTES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "int32", "uint32", "float", "float32"), 4),
    **dict.fromkeys(("double", "float64"), 8),
}


@dataclass(frozen=True, slots=True)
class _Table:
    """`rows` points of `values` numbers, which take `size` bytes in a binary file."""

    rows: int
    values: int
    size: int
    binary: bool


def shortage(data: bytes) -> str | None:
    """What a file lacks of the points that its header promises; None where it holds them, or where its header is one
    that is not understood here (points after lists, compressed data)."""
    ply = data[:3] == b"ply"
    head, body = _ply_parts(data) if ply else _pcd_parts(data)
    table = _ply(head) if ply else _pcd(head)
    if table is None:
        return None
    held = len(body) // max(1, table.size) if table.binary else len(body.split()) // max(1, table.values)
    if held >= table.rows:
        return None
    return f"its header promises {table.rows} points, and it holds {held}"


def _ply_parts(data: bytes) -> tuple[list[list[str]], bytes]:
    head, _, rest = data.partition(b"end_header")
    return _words(head), rest.partition(b"\n")[2]


def _pcd_parts(data: bytes) -> tuple[list[list[str]], bytes]:
    at = data.find(b"\nDATA")
    end = data.find(b"\n", at + 1)
    return (_words(data[:end]), data[end + 1 :]) if 0 <= at < end else ([], b"")


def _words(head: bytes) -> list[list[str]]:
    return [line.split() for line in head.decode("latin-1").splitlines() if line.split()]


def _ply(head: list[list[str]]) -> _Table | None:
    """The vertices, where they are the first element."""
    form, rows, sizes, element = "", 0, [], ""
    for words in head:
        if words[0] == "format" and len(words) > 1:
            form = words[1]
        elif words[0] == "element" and len(words) == 3:
            if not element and (words[1] != "vertex" or not words[2].isdigit()):
                return None
            rows, element = (int(words[2]), "vertex") if not element else (rows, "another")
        elif words[0] == "property" and element == "vertex":
            if words[1] not in _PLY_BYTES:
                return None
            sizes.append(_PLY_BYTES[words[1]])
    return _Table(rows, len(sizes), sum(sizes), form != "ascii") if sizes else None


def _pcd(head: list[list[str]]) -> _Table | None:
    said = {words[0]: words[1:] for words in head}
    counts = said.get("COUNT", ["1"] * len(said.get("SIZE", ())))
    numbers = [*said.get("POINTS", ("",)), *said.get("SIZE", ("",)), *counts]
    kind = said.get("DATA", [""])[:1]
    if kind not in (["ascii"], ["binary"]) or not all(n.isdigit() for n in numbers):
        return None
    sizes = [int(s) * int(c) for s, c in zip(said["SIZE"], counts, strict=False)]
    return _Table(int(said["POINTS"][0]), sum(int(c) for c in counts), sum(sizes), kind == ["binary"])
