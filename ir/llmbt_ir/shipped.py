"""Where the files are that travel with the packages: in a wheel beside llmbt_ir, in a checkout at the top."""

from __future__ import annotations

from pathlib import Path

__all__ = ["shipped"]

_IN_CHECKOUT = {"llm_cassettes": "fixtures/llm_cassettes", "replies": "fixtures/replies"}


def shipped(kind: str) -> Path:
    """The folder of shipped things of one kind (as `scenes`, `llm_cassettes`); a name resolves the same way
    from a wheel, an sdist, an editable install and a checkout. The folder need not exist."""
    here = Path(__file__).resolve().parent
    packed = here / "_shipped" / kind
    return packed if packed.is_dir() else here.parents[1] / _IN_CHECKOUT.get(kind, kind)
