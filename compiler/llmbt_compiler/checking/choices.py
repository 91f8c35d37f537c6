"""Words of a request that leave a choice to the robot: "any of them", "whichever you like", "dealer's choice"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise, takewhile

from llmbt_compiler.checking.referring import predicated
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, singulars, tokens

__all__ = ["left_open"]

_MEANT = re.compile(
    r"\W*(?:\w+\W+){0,3}?(?:he|she|they|it|\w+s)\W+(?:means?|meant|wants?|wanted|said|says|asked|needs?)\b",
    re.IGNORECASE,
)
"""Behind "whichever": somebody else knows which."""
_SPOTS = frozenset({"side", "end", "level", "slot", "spot", "place", "position"})

_LEFT_OPEN = re.compile(
    r"\b(?:your (?:own )?(?:discretion|choice|choosing|pick)|up to you|you (?:may |can |just )?(?:choose|pick|decide)"
    r"|choose (?:for )?yourself|no (?:particular |special )?preference|whichever|whatever you"
    r"|as (?:you (?:like|please|wish|prefer|see fit)|(?:it )?suits? you|(?:it )?pleases you)|take your pick"
    r"|(?:makes?|making) no (?:odds|difference)|(?:all|one and) the same to|all one to me|i[’']?m easy"
    r"|free (?:to choose|choice)|any of (?:the|those|these|my|our)\b"
    r"|(?:doesn['’]?t|does not|won['’]?t|will not) (?:really )?(?:bother|trouble|worry)"
    r"|surprise me|(?<!touch )(?<!move )(?<!do )(?<!grab )(?<!change )anything(?! else| from| on| in)"
    r"|any (?:\w+ ){0,4}(?:will|would|is|are)|any of them"
    r"|all the same|either (?:of (?:\w+ ){1,6})?(?:one )?(?:will|would|can|is|goes|works|does)|either['’](?:s|ll)"
    r"|either (?:side|end|place|spot|slot|position|level|way)\b"
    r"|(?:dealer|robot|driver)['’]s choice|(?:your|its) call|at random|(?:toss|flip) a coin|(?:suit|please) yourself"
    r"|leave (?:it|that|this|the \w+) (?:entirely |all |up )?to (?:you|the robot)"
    r"|(?:just )?(?:pick|choose) (?:any|one)\b(?! of| up| from)"
    r"|(?:am |['’]m )?not (?:fussy|fussed|bothered|picky)"
    r"|(?:do not|don['’]?t) (?:really )?care\b(?! wh)"
    r"|(?:no|not|doesn['’]?t) matter (?:to me )?(?:which|where|what)"
    r"|(?:do not|don['’]?t) (?:really )?(?:care|mind) (?:which|where|what)"
    r"|could(?:n['’]?t| not) care less(?: which| where| what)?)"
    r"(?P<what>(?:\W+\w+){0,3})",
    re.IGNORECASE,
)
"""Says that any of them will do."""


def left_open(words: Sequence[Token], request: str, scene: Scene, *, movable: bool) -> bool:
    """Whether the request says that any will do: any thing (`movable`), or any place."""
    for i, t in enumerate(words[:-1]):
        after = words[i + 1]
        if after.number is not None and i + 2 < len(words):
            after = words[i + 2]  # "any two of them"
        if (
            t.text == "any"
            and (scene.word(after, movable).text or not after.word)
            and not scene.word(after, not movable).text
        ):
            return True
    for m in _LEFT_OPEN.finditer(request):
        if movable and re.search(r"\bwhich one\b", m.group(0), re.IGNORECASE):
            return True
        said = [t.text for t in tokens(m.group(0)[: m.start("what") - m.start()])]
        if said == ["whichever"] and re.search(r"\b(?:is|are) the \w+(?:est|most|er)\b", request[m.end() :]):
            continue  # "whichever item on the table is the rightmost one"
        if said == ["whichever"] and _MEANT.match(request[m.start("what") :]):
            continue  # "whichever of those he means"
        if said == ["whichever"] and _ranked(words, request, m.start(), scene):
            continue  # "whichever of the yellow ones is further left"
        of_places = (
            "where" in said
            or bool(_SPOTS & set(said))
            or bool(said[:1] == ["any"] and {w for s in said for w in singulars(s)} & scene.generic(False))
        )
        of_places = of_places or any(
            t.text in scene.generic(False) or t.text.removesuffix("s") in _SPOTS
            for t in takewhile(lambda t: t.text not in {"to", "onto", "into", "for", "on"}, tokens(m.group("what")))
        )
        which = said[-1:] == ["which"] and tokens(m.group("what"))[:1] and tokens(m.group("what"))[0].text == "of"
        of_places = of_places or (not which and _of_places_alone(request, m.start(), scene))
        if of_places != movable or (not movable and not of_places):
            return True
    return False


def _ranked(words: Sequence[Token], request: str, at: int, scene: Scene) -> bool:
    """Whether "whichever" begins a phrase that a rank tells."""
    where = {o.id: o.place for o in scene.map.objects}
    k = next((k for k, t in enumerate(words) if t.start >= at), 0)
    return predicated(words, k, request, scene, where) is not None


def _of_places_alone(request: str, at: int, scene: Scene) -> bool:
    """Whether the sentence that leaves a choice open speaks of places and of no thing: "left of it or right of it, as
    it suits you"."""
    words = tokens(request)
    begin, end = sentence_at(words, next((k for k, t in enumerate(words) if t.start >= at), len(words)))
    said = words[begin:end]
    things = any(t.text in scene.colours or scene.word(t, True).text for t in said)
    places = scene.generic(False) | _SPOTS
    sides = any(a.text in {"left", "right"} and b.text == "of" for a, b in pairwise(said))
    return not things and (sides or any(t.text in places for t in said))
