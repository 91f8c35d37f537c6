"""XML as BehaviorTree.CPP's parser (tinyxml2) takes it: `&` and `<` may stand as such where they mean themselves. Pure.

Scripts in attributes are written so in BehaviorTree.CPP's own tutorials: `<ScriptCondition code="a<b && c"/>`.
"""

from __future__ import annotations

import re
from bisect import bisect_left

__all__ = ["escaped"]

_TOKEN = re.compile(
    rb"""<!--.*?(?:-->|\Z)|<!\[CDATA\[.*?(?:\]\]>|\Z)|<\?.*?(?:\?>|\Z)
    |(?P<tag></?[A-Za-z_:\x80-\xff][^"'<>]*+(?:"[^"]*+"[^"'<>]*+|'[^']*+'[^"'<>]*+)*+>)
    |(?P<text>&)""",
    re.DOTALL | re.VERBOSE,
)
_VALUE = re.compile(rb"\"[^\"]*+\"|'[^']*+'")
_LOOSE = re.compile(rb"<|&(?!(?:amp|lt|gt|quot|apos|\#[0-9]+|\#x[0-9A-Fa-f]+);)")


def escaped(data: bytes) -> tuple[bytes, tuple[int, ...]]:
    """The same document with `&` and `<` written as XML wants it, and the lines (from 1) in which that was needed."""
    ends = [found.start() for found in re.finditer(rb"\n", data)]
    lines: set[int] = set()

    def mended(text: bytes, at: int) -> bytes:
        def one(found: re.Match[bytes]) -> bytes:
            lines.add(bisect_left(ends, at + found.start()) + 1)
            return b"&lt;" if found.group() == b"<" else b"&amp;"

        return _LOOSE.sub(one, text)

    def token(found: re.Match[bytes]) -> bytes:
        if found["tag"] is not None:
            start = found.start()
            return _VALUE.sub(lambda value: mended(value.group(), start + value.start()), found.group())
        if found["text"] is not None:
            whole = data[found.start() : found.start() + 12]
            return mended(b"&", found.start()) if _LOOSE.match(whole) else b"&"
        return found.group()

    return _TOKEN.sub(token, data), tuple(sorted(lines))
