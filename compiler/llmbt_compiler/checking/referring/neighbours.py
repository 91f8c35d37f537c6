"""Things told as the neighbour of another: "the red block's neighbour", "the green neighbour of object 3"."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.checking.referring.landmarks import landmark
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.nouns import noun
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import Relation, relations
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["entered_beside", "neighbour"]

_NEIGHBOURS = frozenset({"neighbour", "neighbor", "neighbours", "neighbors"})
_MODIFYING = frozenset(
    {"direct", "immediate", "next", "-", "door", "only", "sole", "closest", "nearest", "own", "block"}
)
_ENTERING = frozenset({"is", "stands", "lies", "sits", "are", "was", "waits", "theres"})
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


def entered_beside(
    words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "Next to the cookies there is (something that I need)": all that stands there, of the kind that is named."""
    begin, _ = sentence_at(words, i)
    of = next((r for r in relations(words) if begin <= r.start <= begin + 1 and not r.owner), None)
    mark = landmark(words, of.end, scene) if of is not None and of.name != "between" and of.start == begin else None
    if of is None or mark is None or len(mark.ids) != 1 or not mark.end <= i <= mark.end + 3:
        return None
    between = {t.text for t in words[mark.end : i]}
    theres = any(t.owner and t.text == "there" for t in words[mark.end : i])
    if not (theres or between & _ENTERING) or not between <= _ENTERING | {"there", ","}:
        return None
    some = words[i].text == "something"
    end = i + 1 if some else noun(words, i, scene) if lexicon().is_(words[i].text, "articles") else 0
    if not end or not scene[mark.ids[0]].movable:
        return None
    core = [t for t in words[i + 1 : end] if t.text not in {"one", "thing"}]
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    every = world.every(core, True) if core else (tuple(e.id for e in scene.objects), False)
    if not isinstance(every, tuple):
        return None
    pool = tuple(o for o in every[0] if o not in mark.ids)
    found = world.related(of, pool, mark.ids, words[begin:end], False) if pool else None
    ids = found.ids if isinstance(found, Found) else found.candidates if found and found.code == "E304" else ()
    return Meant(i, end, tuple(sorted(ids, key=natural)), stop=end) if ids else None


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
