"""Things told as the neighbour of another: "the red block's neighbour", "the green neighbour of object 3"."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.checking.referring.landmarks import landmark
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import Relation
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["neighbour"]

_NEIGHBOURS = frozenset({"neighbour", "neighbor", "neighbours", "neighbors"})
_MODIFYING = frozenset(
    {"direct", "immediate", "next", "-", "door", "only", "sole", "closest", "nearest", "own", "block"}
)
_LONGEST = 8


def neighbour(words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """The phrase that begins right here and ends in "neighbour", or in "neighbour of" and a thing; with all those that
    stand next to it."""
    head = next((k for k in range(i + 1, min(len(words), i + _LONGEST)) if words[k].text in _NEIGHBOURS), None)
    if head is None:
        return None
    of_them = [t.text for t in words[i : i + 2]] == ["one", "of"]
    if words[head].text.endswith("s") and not of_them:
        return None
    first = i + 2 * of_them
    owner = next((k for k in range(first, head) if words[k].owner), None)
    of = [t.text for t in words[head + 1 : head + 2]] in (["of"], ["to"])
    if words[first].text == "its":
        before = [m for m in mentions_in(words[:first], scene) if scene[m.id].movable]
        marks, told, stop = tuple(m.id for m in before[-1:]), words[first + 1 : head], head + 1
    elif owner is not None:
        marks, told, stop = _owners(words, first, owner, scene), words[owner + 1 : head], head + 1
    elif of and lexicon().is_(words[first].text, "articles"):
        mark = landmark(words, head + 2, scene) or _coloured(words, head + 2, scene)
        marks, told, stop = (mark.ids, words[first + 1 : head], mark.end) if mark is not None else ((), (), 0)
    else:
        return None
    colours = {t.text for t in told if t.text in scene.colours}
    if len(marks) != 1 or any(t.text not in colours | _MODIFYING for t in told):
        return None
    pool = tuple(e.id for e in scene.objects if all(c in e.colour for c in colours) and e.id not in marks)
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    found = world.related(Relation("next", head, head + 1), pool, marks, words[i:stop], False)
    ids = found.ids if isinstance(found, Found) else found.candidates if found.code == "E304" else ()
    return Meant(i, stop, tuple(sorted(ids, key=natural)), stop=stop) if ids else None


def _owners(words: Sequence[Token], i: int, owner: int, scene: Scene) -> tuple[str, ...]:
    """ "(The red block)'s", "(object 6)'s", "(red)'s": where just these words name one thing."""
    named = next((m.id for m in mentions_in(words, scene) if m.start == i and m.end == owner + 1), None)
    if named is not None:
        return (named,)
    mark = landmark(words[: owner + 1], i, scene) or _coloured(words, i, scene)
    return mark.ids if mark is not None and mark.end >= owner else ()


def _coloured(words: Sequence[Token], at: int, scene: Scene) -> Meant | None:
    at += int(at < len(words) and lexicon().is_(words[at].text, "articles"))
    if at >= len(words) or words[at].text not in scene.colours:
        return None
    return Meant(at, at + 1, tuple(e.id for e in scene.objects if words[at].text in e.colour))
