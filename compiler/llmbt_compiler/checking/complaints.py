"""How the check of a request says what it found: several things that a phrase fits, too few, none."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.checking.referring import Meant
from llmbt_compiler.checking.sentences import span_of
from llmbt_compiler.parsing.names import Fault
from llmbt_compiler.parsing.words import Token
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["lacks", "several", "too_few"]


def several(
    parts: Sequence[Token], request: str, ids: Sequence[str], taken: Sequence[str], what: str = "objects"
) -> Diagnostic:
    """E141: the phrase fits all of `ids`, and the reply takes some of them."""
    said = request[parts[0].start : parts[-1].end]
    return Diagnostic(
        "E141",
        f"`{said}` fits {len(ids)} {what}, and the reply takes {', '.join(taken)} without asking",
        span_of(parts, request),
        "which?",
        f"say which of {', '.join(ids[:6])}",
        candidates=tuple(ids),
    )


def too_few(parts: Sequence[Token], request: str, phrase: Meant) -> Diagnostic:
    """E142: the phrase counts more things than there are."""
    said = request[parts[0].start : parts[-1].end]
    return Diagnostic(
        "E142",
        f"the request names what is not there: `{said}`, and there "
        + (f"{'is' if len(phrase.ids) == 1 else 'are'} only {len(phrase.ids)} of them" if phrase.ids else "is none"),
        span_of(parts, request),
        "too few",
        f"the map has {', '.join(phrase.ids)}" if phrase.ids else "say it in other words",
        candidates=phrase.ids,
    )


def lacks(fault: Fault, parts: Sequence[Token], request: str) -> Diagnostic:
    """E142: what the words name is not in the map."""
    return Diagnostic(
        "E142",
        f"the request names what is not there: {fault.title}",
        span_of(parts, request),
        "not in the map",
        fault.help,
        candidates=fault.candidates,
    )
