"""What a clause's targets and places come to: exceptions taken out, one of several told apart, the place of a thing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import dropwhile, pairwise

from llmbt_atl.template import Role
from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.beside import mentions
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Grounding, Stop
from llmbt_compiler.parsing.model import Extent, NoteKind
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.phrase import conjuncts
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.whereabouts import whose_place
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["Resolving"]

_BEGINNING = frozenset({"starting", "beginning"})
_POINTING = ("pronouns", "plural_pronouns")
_WHOLE = frozenset({"everything", "whatever", "all", "what"})
_TELLING = frozenset({"with", "that", "which", "who", "whose", "i", "we", "you", "they"})


@dataclass
class Resolving(Grounding):
    """The targets of a group and where they are to go."""

    def one_target(self, phrase: Phrase, at: tuple[str, ...], picking: bool, before: Sequence[Found]) -> Found:
        aside = self.aside(phrase)
        talk = self.talk() if not aside else replace(self.talk(), targets=(), pending=())
        found = self.narrowed(phrase, talk, at, picking)
        begins = bool(phrase.after) and not phrase.aside and phrase.after[0].text in _BEGINNING
        if aside and begins and isinstance(found, Found) and set(aside) <= set(found.ids):
            found = replace(found, ids=(*aside, *(i for i in found.ids if i not in aside)))  # "starting with object 4"
        elif aside and isinstance(found, Found):
            found = self.agree(phrase, found, aside)
            told = replace(phrase, parts=phrase.aside or phrase.after)  # "the two balls, white and orange, ..."
            found = (self.in_words(told, found) or found) if isinstance(found, Found) else found
        elif aside and isinstance(found, Fault) and found.code == "E304":
            common = tuple(i for i in found.candidates if i in aside)
            found = Found(common) if len(common) == 1 or common == aside else found
        pointing = len(phrase.parts) == 1 and lexicon().is_(phrase.parts[0].text, "pronouns", "plural_pronouns")
        if isinstance(found, Fault) and pointing and before:  # "object 1: pick it up"
            found = before[-1]
        if isinstance(found, Fault) and phrase.parts[-1].text == "one" and before:
            found = self.other_one(phrase, before[-1], talk) or found
        several = isinstance(found, Fault) and found.code == "E304"
        if isinstance(found, Fault) and several and phrase.apposed and before:
            found = before[-1] if set(before[-1].ids) <= set(found.candidates) else found
        if isinstance(found, Fault):
            raise self.fault(found)
        self.told(found, phrase)
        if pointing and set(found.ids) <= set(self.mentioned):
            self.named_beside(found.ids)
        return found

    def other_one(self, phrase: Phrase, before: Found, talk: Talk) -> Found | None:
        """ "The large saline bottle and the small one": one of what was named before."""
        last, adjectives = phrase.parts[-1], self.scene.colours | lexicon().sizes.keys()
        names = [o.name for o in self.scene.map.objects if o.id in before.ids[:1]]
        said = before.words or tuple(t.text for t in tokens(names[0]) if t.word and t.number is None)
        noun = tuple(Token(w, last.start, last.end) for w in said if w not in adjectives)
        found = resolve_objects((*phrase.parts[:-1], *noun), self.scene, talk) if noun else None
        return found if isinstance(found, Found) and not set(found.ids) & set(before.ids) else None

    def exception(self, clause: Clause) -> list[str]:
        """What "except ..." takes out, where the tagger left it unlabelled."""
        for length in range(min(len(clause.exception), 12), 0, -1):
            found = resolve_objects(clause.exception[:length], self.scene, self.talk())
            if isinstance(found, Found):
                self.told_apart(clause.exception, length, found)
                self.use(*clause.exception[:length])
                return list(found.ids)
            places = resolve_places(clause.exception[:length], self.scene, self.talk())
            if isinstance(places, Found) and not {ANYWHERE, ORIGIN} & set(places.ids):
                self.use(*clause.exception[:length])
                self.barred |= {p for i in places.ids for p in (i, *(q.id for q in self.scene.map.inside(i)))}
                return []  # "anywhere on level 2 except position 21"
        found = resolve_objects(clause.exception[:1], self.scene, self.talk())
        raise self.fault(found) if isinstance(found, Fault) else Stop

    def told_apart(self, words: Sequence[Token], length: int, found: Found) -> None:
        """E304 where what is left out is told by more than the words understood ("the one with a scratch")."""
        plain = {"one", "ones", *self.scene.generic(True)}
        bare = all(t.text in plain or lexicon().is_(t.text, "articles") for t in words[:length])
        more = [t.text for t in words[length : length + 1] if t.text in _TELLING]
        if found.chosen or (bare and more):
            extent = Extent(words[0].start, words[-1].end)
            said = extent.cut(self.now.text)
            self.complain("E304", f"what `{said}` leaves out is not clear", extent, "which?", "name the objects")
            raise Stop

    def told_once(self, targets: tuple[Phrase, ...]) -> tuple[Phrase, ...]:
        """Without those that a name right after them makes clear: "the second one, object 5"."""
        gone = []
        cut = next(
            (i for i, (a, b) in enumerate(pairwise(targets), 1) if self.parted(a, b) and _counting(b, self.scene)), 0
        )
        ids = tuple(dict.fromkeys(i for p in targets[:cut] for i in self.quiet(p)))
        if len(ids) > 1:  # "objects 3 and 5: the first one to position 33, the second one to position 34"
            self.listed, self.targets, self.among, targets = (ids, self.turn), (ids, self.turn), ids, targets[cut:]
        for phrase, name in pairwise(targets):
            if self.parted(phrase, name) and self.detailed(phrase, targets):
                gone.append(phrase)
                continue
            if not name.apposed or phrase.aside or not any(t.number for t in name.parts):
                continue
            vague = resolve_objects(phrase.parts, self.scene, self.talk())
            ids = self.quiet(name)
            if isinstance(vague, Fault) and vague.code == "E304" and ids and set(ids) <= set(vague.candidates):
                gone.append(phrase)
        return tuple(p for p in targets if p not in gone)

    def parted(self, before: Phrase, after: Phrase) -> bool:
        return ":" in self.now.text[before.extent.end : after.extent.start]

    def detailed(self, phrase: Phrase, targets: Sequence[Phrase]) -> bool:
        """Whether the targets behind a phrase are all of what it means ("the blocks: green on level 1, ...")."""
        whole = resolve_objects(phrase.parts, self.scene, Talk(self.ledger.where))
        known = whole.ids if isinstance(whole, Found) else whole.candidates if whole.code == "E304" else ()
        later = [p for p in targets if p.extent.start > phrase.extent.start]
        found = [set(self.quiet(p)) for p in later]
        return len(known) > 1 and all(ids and ids < set(known) for ids in found)

    def either(self, phrase: Phrase) -> None:
        """E304 where a phrase is told as one of several ("object 1 or object 2"): which one is not ours to say."""
        if phrase.vague:
            words = phrase.extent.cut(self.now.text)
            self.complain("E304", f"how many of `{words}`?", phrase.extent, "which?", "say which ones")
            raise Stop
        inside = any(t.text == "or" for t in phrase.parts)
        if not inside and phrase.preposition != "or":
            return
        words = phrase.extent.cut(self.now.text)
        self.complain("E304", f"`{words}` or another?", phrase.extent, "which?", "say which one")
        raise Stop

    def objects(
        self,
        clause: Clause,
        group: Group,
        locations: Sequence[Phrase],
        excluded: tuple[Phrase, ...],
        *,
        picking: bool,
    ) -> Found:
        """The objects of a group's targets, narrowed by where they are said to be; the
        exceptions taken out.
        """
        if not group.targets:
            at = [self.quiet_place(p) for p in locations]
            if self.lost and not at:
                raise Stop
            if picking and self.approached is not None and not self.ledger.pending:  # "approach the drum. Grasp, lift."
                return Found((self.approached,))
            self.complain("E305", "no object is named", clause.extent, "what?", "name the object")
            raise Stop
        at_ids = self.from_where(group, locations)
        found: list[Found] = []
        for phrase in _each(self.told_once(group.targets), self.now.text):
            self.either(phrase)
            ordered = self.in_words(phrase, found[-1]) if found and phrase.apposed else None
            if ordered is not None:
                found[-1] = ordered
                continue
            one = self.one_target(phrase, at_ids, picking, found)
            found.append(one)
        ids = tuple(dict.fromkeys(i for f in found for i in f.ids))
        without = [i for p in excluded for i in self.find(p).ids]
        if clause.exception:
            without += self.exception(clause)
        without += self.spared if set(self.spared) < set(ids) else ()
        ids = self.led_by(tuple(i for i in ids if i not in without))
        if not ids:
            self.complain("E305", "no object is left to act on", clause.extent, "what?")
            raise Stop
        self.targets, self.lost, self.approached = (ids, self.turn), False, None
        if len(ids) > 1:
            self.listed = (ids, self.turn)
        pointing = all(lexicon().is_(t.text, *_POINTING) for p in group.targets for t in p.parts)
        self.whole = self.whole if pointing else any(t.text in _WHOLE for p in group.targets for t in p.parts)
        words = tuple(w for f in found for w in f.words)
        self.described = words or self.described
        return Found(ids, words=words)

    def in_words(self, phrase: Phrase, whole: Found) -> Found | None:
        """ "The two balls, white and orange": the things named before, in the order in which adjectives tell them."""
        groups = conjuncts(phrase.parts)
        said = [{t.text for t in g if not lexicon().is_(t.text, "articles")} for g in groups]
        if len(groups) < 2 or len(groups) != len(whole.ids) or not all(w and w <= self.scene.colours for w in said):
            return None
        each = [[i for i in whole.ids if all(self.scene.fits(self.scene[i], w) for w in words)] for words in said]
        ids = tuple(e[0] for e in each if len(e) == 1)
        return replace(whole, ids=ids) if set(ids) == set(whole.ids) else None

    def led_by(self, ids: tuple[str, ...]) -> tuple[str, ...]:
        """These things with those first that the step says come first."""
        for phrase in self.leading:
            found = resolve_objects(phrase.parts, self.scene, replace(self.talk(), targets=ids))
            first = [i for i in (found.ids if isinstance(found, Found) else found.candidates) if i in ids]
            if first:
                self.use(*phrase.parts)
                return (*first, *(i for i in ids if i not in first))
        return ids

    def where_to(self, phrase: Phrase, container: Phrase | None = None) -> Found:
        """The places of a destination; what follows it ("on shelf level 1") has to agree."""
        self.either(phrase)
        there = all(lexicon().is_(t.text, "there") for t in phrase.parts)
        if there and self.ledger.vacated is not None and self.now.text[phrase.extent.end :].lstrip()[:7] == "instead":
            return Found((self.ledger.vacated,))  # "take A off position 12 and put it aside; set B there instead"
        told = self.place_of_thing(phrase)
        if told is not None:
            return told
        if phrase.relation:
            self.relation(phrase)
        phrase = self.with_noun(phrase)
        parts = phrase.parts
        outer = tuple(container.parts) if container is not None else ()
        inner = self.inner(phrase) if not outer else None
        if inner is not None:
            return inner
        if not outer and (phrase.trail or phrase.aside):
            outer = self.agreeing(phrase)
        if outer:
            joint = Token("on", parts[-1].end, parts[-1].end)
            parts = (*parts, joint, *outer)
        found = resolve_places(parts, self.scene, self.talk())
        if isinstance(found, Found) and len(parts) == 1 and lexicon().is_(parts[0].text, "there"):
            self.pointed_at(found.ids)
        if isinstance(found, Fault) and found.code == "E302":
            objects = resolve_objects(phrase.parts, self.scene, self.talk())
            if isinstance(objects, Found) and objects.ids:
                if self.stackable(objects.ids):
                    return objects
                found = Fault(
                    "E302", f"{', '.join(objects.ids[:6])} is an object, not a place", phrase.extent,
                    "not a place of the map", "name the place where it is to go",
                )  # fmt: skip
        own = phrase.parts[0].text in {"its", "their"} and isinstance(found, Found) and found.ids == (ORIGIN,)
        if own and len(phrase.parts) == 2 and not set(self.targets[0]) & self.ledger.handled:
            said = phrase.extent.cut(self.now.text)
            found = Fault("E305", f"`{said}`: it was never taken from there", phrase.extent, "where?", "name the place")
        if isinstance(found, Fault):
            raise self.fault(found)
        self.told(found, phrase)
        return found

    def pointed_at(self, places: Sequence[str]) -> None:
        """Where the step names such a place outside its keywords, that was read by "there"."""
        parts = tokens(self.now.text)
        for first, last in mentions(parts, self.scene):
            name = tuple(t for t in parts if first.start <= t.start <= last.start)
            named = {e.id for e in exactly_named(name, self.scene.places)}
            if named and named <= set(places):
                self.use(*name)

    def with_noun(self, phrase: Phrase) -> Phrase:
        """ "From the top level to the middle one", "slot 1 of rack B ... the second one": with the noun of the place
        that was named before. What the phrase says is remembered."""
        lex = lexicon()
        before = [
            s for s in self.now.spans if s.end <= phrase.extent.start and s.label in {Kind.DESTINATION, Kind.LOCATION}
        ]
        noun = _noun(tokens(self.now.text, before[-1].start, before[-1].end)) if before else self.kind
        self.kind = _noun(phrase.parts) or self.kind
        last = phrase.parts[-1]
        ranked = any(t.text in lex.ordinals or lex.is_(t.text, "top", "bottom", "middle", "last") for t in phrase.parts)
        told = ranked or any(t.text in self.scene.vocabulary(False) for t in phrase.parts[:-1])
        if told and not ranked and before:  # "from the noon slot to the evening one"
            noun = tuple(t for t in tokens(before[-1].text) if t.word and t.number is None)[-1:]
        if last.text != "one" or not told or not noun or not self.scene.word(noun[0], False).text:
            return phrase
        return replace(phrase, parts=(*phrase.parts[:-1], *(replace(t, start=last.start, end=last.end) for t in noun)))

    def place_of_thing(self, phrase: Phrase) -> Found | None:
        """The place that a phrase tells by a thing ("the level that object 3 is on"); None where it does not."""
        told = whose_place(phrase.parts, self.now.text)
        if told is None:
            return None
        noun, thing, before = told
        things = resolve_objects(thing, self.scene, self.talk())
        if isinstance(things, Fault) and before:  # of several such things the one that was moved
            moved = tuple(i for i in things.candidates if i in self.ledger.handled)
            things = Found(moved) if len(moved) == 1 else things
        if isinstance(things, Fault):
            raise self.fault(things)
        at = {self.origin.get(i) if before else self.ledger.where.get(i) for i in things.ids}
        place = at.pop() if len(at) == 1 else None
        around = (place, *self.scene.map.containers(place)) if place is not None else ()
        words = [w for t in noun if (w := self.scene.word(t, False).text)]
        generic = not noun or all(w in self.scene.generic(False) for w in words)
        fitting = [p for p in around if all(self.scene.fits(self.scene[p], w) for w in words)]
        still = any(self.ledger.where.get(i) == place for i in things.ids)
        if generic and still and fitting and self.scene.single(fitting[0]):
            fitting = []  # a slot that the other thing stands on
        if not fitting:
            said = phrase.extent.cut(self.now.text)
            self.complain("E305", f"`{said}` is no place of the map", phrase.extent, "where?", "name the place")
            raise Stop
        self.note(NoteKind.INFERRED, f"`{phrase.extent.cut(self.now.text)}` is {fitting[0]}", phrase.extent)
        return Found((fitting[0],))

    def inner(self, phrase: Phrase) -> Found | None:
        """ "Rack B, slot 2": the one place in the container that the words after the comma name, if they do."""
        lex = lexicon()
        after = tuple(dropwhile(lambda t: lex.is_(t.text, "inner", "articles"), phrase.after))
        for length in range(min(len(after), 4), 0, -1):
            words = after[:length]
            joint = Token("on", words[-1].end, words[-1].end)
            found = resolve_places((*words, joint, *phrase.parts), self.scene, self.talk())
            exact = isinstance(found, Found) and len(found.ids) == 1 and not found.vague and not found.corrected
            if exact and isinstance(found, Found):
                counted = any(t.number is not None or t.text in lex.ordinals for t in words)
                if not counted or found.ids[0] == ORIGIN:
                    return None
                self.use(*words)
                return found
        return None

    def stackable(self, ids: Sequence[str]) -> bool:
        """Whether the library puts things on things."""
        slots = [s for t in self.placing() if (s := t.param(Role.DESTINATION)) is not None]
        return any(all(self.scene.is_a(i, s.type) for i in ids) for s in slots)

    def agreeing(self, phrase: Phrase) -> tuple[Token, ...]:
        """The tokens after a destination that name a place."""
        for group in (phrase.aside, phrase.trail):
            for length in range(min(len(group), 6), 0, -1):
                found = resolve_places(group[:length], self.scene, Talk())
                if isinstance(found, Found) and len(found.ids) == 1 and not found.corrected:
                    self.use(*group[:length])
                    return group[:length] if found.ids != self.places_of(phrase) else ()
        return ()

    def all_there(self, targets: Sequence[Phrase], phrase: Phrase) -> bool:
        """Whether the targets stand where a phrase says: then it tells them apart and is no destination."""
        place = self.quiet_place(phrase)
        if place is None or not targets:
            return False
        ids = [i for p in targets for i in self.quiet(p)]
        if not ids:
            found = resolve_objects(targets[0].parts, self.scene, self.talk(), at=(place,))
            return isinstance(found, Found)
        return all(self.scene.within(self.ledger.where.get(i), place) for i in ids)

    def contains(self, outer: Phrase, inner: Phrase) -> bool:
        a, b = self.quiet_place(outer), self.quiet_place(inner)
        return a is not None and b is not None and a != b and self.scene.within(b, a)

    def narrows(self, outer: Phrase, inner: Phrase) -> bool:
        """Whether words behind a comma name a place, or any free one, of the place before it, and nowhere else."""
        lead = {t.text for t in tokens(self.now.text, outer.extent.end, inner.extent.start)}
        plain = all(lexicon().is_(w, "at", "articles") or w in {",", "using"} for w in lead)
        a = self.quiet_place(outer)
        joint = Token("on", inner.extent.end, inner.extent.end)
        found = resolve_places((*inner.parts, joint, *outer.parts), self.scene, self.talk())
        if not plain or a is None or a in {ANYWHERE, ORIGIN} or not isinstance(found, Found) or found.corrected:
            return False
        return all(i != a and self.scene.within(i, a) for i in found.ids) or (found.vague and found.ids == (a,))

    def outer(self, destinations: list[Phrase], locations: list[Phrase]) -> Phrase | None:
        """A level tagged apart from its position ("position 12 | shelf level 1"): no place of its own. One told before
        its position ("shelf level 2, position 23") goes without saying."""
        for before, after in pairwise(destinations):
            between = self.now.text[before.extent.end : after.extent.start].strip()
            if between in {",", ", at", ", in", ", on", "at", "-"} and self.contains(before, after):
                destinations.remove(before)
                return None
            if len(destinations) == 2 and between[:1] == "," and self.narrows(before, after):
                destinations.remove(before)
                return before  # "rack A, slot 3", "rack B, using the first free slots"
        for phrase in (*destinations[1:], *locations):
            ends = [d for d in destinations if d is not phrase and d.extent.end <= phrase.extent.start]
            gap = self.now.text[ends[-1].extent.end : phrase.extent.start].split() if ends else []
            if ends and len(gap) <= 2 and phrase.preposition in {"on", "of", "in", "at", ","} and ends[-1].trail == ():
                if phrase.preposition == "," and phrase in destinations and not self.contains(phrase, ends[-1]):
                    continue
                (destinations if phrase in destinations else locations).remove(phrase)
                return phrase
        return None


def _each(targets: Sequence[Phrase], text: str) -> tuple[Phrase, ...]:
    """The targets, without the "both" of "both the coke and the water"."""
    if len(targets) != 2 or [t.text for t in targets[0].parts[:1]] != ["both"] or len(targets[0].parts) < 2:
        return tuple(targets)
    first, then = targets
    linked = [t.text for t in tokens(text, first.extent.end, then.extent.start)]
    several = any(t.text == "of" or t.text.endswith("s") for t in first.parts[1:2]) or then.parts[0].text == "both"
    if linked[:1] != ["and"] or several:
        return tuple(targets)
    return replace(first, parts=first.parts[1:]), then


def _counting(phrase: Phrase, scene: Scene) -> bool:
    """ "The first one", "the former", "one", "the red one": one of several named before."""
    lex = lexicon()
    words = [t for t in phrase.parts if not lex.is_(t.text, "articles")]
    if words[-1:] and words[-1].text == "one" and {t.text for t in words[:-1]} <= scene.colours | lex.sizes.keys():
        return True
    return all(t.text in lex.ordinals or t.text in {"one", "former", "latter", "other"} for t in words)


def _noun(parts: Sequence[Token]) -> tuple[Token, ...]:
    """The noun of a place, with what it is of: "slot of rack B" of "the first slot of rack B", "level" of "level 2"."""
    lex = lexicon()
    lists = ("articles", "top", "bottom", "middle", "last", "vacant", "pronouns", "there")
    kept = tuple(dropwhile(lambda t: lex.is_(t.text, *lists) or t.text in lex.ordinals, parts))
    kept = kept[:1] if not any(t.text in {"of", "on", "in"} for t in kept) else kept
    return kept if kept and kept[0].word and kept[0].text != "one" else ()
