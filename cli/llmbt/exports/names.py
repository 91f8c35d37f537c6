"""Names of leaves and ports as identifiers of C++ and Python."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable

__all__ = ["class_names", "function_names", "parameter_names"]

CPP_KEYWORDS = frozenset(
    re.findall(
        r"\w+",
        """alignas alignof and asm auto bool break case catch char class concept const constexpr continue decltype
        default delete do double else enum explicit export extern false float for friend goto if inline int long
        mutable namespace new noexcept not nullptr operator or private protected public register requires return
        short signed sizeof static struct switch template this throw true try typedef typename union unsigned using
        virtual void volatile while xor name status config""",
    )
)


def _unique(found: Iterable[tuple[str, str]], taken: Iterable[str] = ()) -> dict[str, str]:
    used, names = set(taken), dict[str, str]()
    for name, wanted in found:
        candidate, k = wanted, 2
        while candidate in used:
            candidate, k = f"{wanted}_{k}", k + 1
        used.add(candidate)
        names[name] = candidate
    return names


def _plain(text: str) -> str:
    word = re.sub(r"[^A-Za-z0-9_]", "_", text)
    return f"_{word}" if not word or word[0].isdigit() else word


def class_names(names: Iterable[str]) -> dict[str, str]:
    """`pick_up` to `PickUp`, each once."""
    return _unique(
        (n, "".join(w[:1].upper() + w[1:] for w in re.split(r"_+", _plain(n)) if w) or "Node") for n in names
    )


def function_names(names: Iterable[str]) -> dict[str, str]:
    """As they are, where that is an identifier."""
    return _unique((n, _plain(n)) for n in names)


def parameter_names(names: Iterable[str]) -> dict[str, str]:
    """Names of parameters, of which none is a keyword of Python or C++."""
    safe = ((n, _plain(n)) for n in names)
    words = ((n, f"{p}_" if keyword.iskeyword(p) or p in CPP_KEYWORDS else p) for n, p in safe)
    return _unique(words, ("self",))
