"""The names of a clause held against the map, with what the step says around them; and
the telling of faults.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import dropwhile, pairwise

from llmbt_atl.template import Role, Template
from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.beside import mentions
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.model import Extent, LabelledStep, Note, NoteKind
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.phrase import conjuncts
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import Shape, Verb, shape_of
from llmbt_compiler.parsing.whereabouts import whose_place
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic, Severity, Span

__all__ = ["Grounding", "Open", "Stop"]

_LONG = 2000
_POINTING = ("pronouns", "plural_pronouns")
_WHOLE = frozenset({"everything", "whatever", "all", "what"})
_BEGINNING = frozenset({"starting", "beginning"})
_TELLING = frozenset({"with", "that", "which", "who", "whose", "i", "we", "you", "they"})
_VAGUE = frozenset({"position", "spot", "place", "location", "it", "stands", "is"})


class Stop(Exception):  # noqa: N818 - no error: what is wrong has been noted
    """A clause ends here; the reason has been noted."""


class Open(Stop):
    """What is to be done is known, and to what; only where it is to go is not, or not yet."""


@dataclass
class Grounding:
    """What the walk knows so far, and how a phrase is understood by it.

    `mentioned` are the objects, `around` the places that the step at hand names in words that are no keywords, `used`
    the words of it that were understood, `ordered` whether it asks for an order, `idle` whether
    the clause at hand only looks; `barred` are places that it excepts;
    `listed` is when several objects were named together last, and which, `whole` whether as one ("everything");
    `kind` is the noun of the place that was named last, `taken_off` where a thing was said to be, and when;
    `among` are the things that the step says it chooses from, `spared` those that it leaves out at its beginning.
    """

    scene: Scene
    source: str
    notes: list[Note] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    turn: int = 0
    targets: tuple[tuple[str, ...], int] = ((), -9)
    place: tuple[str | None, int] = (None, -9)
    described: tuple[str, ...] = ()
    lost: bool = False
    mentioned: tuple[str, ...] = ()
    around: tuple[str, ...] = ()
    used: list[Extent] = field(default_factory=list)
    ordered: bool = False
    idle: bool = False
    approached: str | None = None
    listed: tuple[tuple[str, ...], int] = ((), -9)
    barred: set[str] = field(default_factory=set)
    whole: bool = False
    kind: tuple[Token, ...] = ()
    among: tuple[str, ...] = ()
    spared: tuple[str, ...] = ()
    taken_off: tuple[str | None, int] = (None, -9)
    leading: tuple[Phrase, ...] = ()
    now: LabelledStep = field(default_factory=lambda: LabelledStep(0, ""))

    def __post_init__(self) -> None:
        self.ledger = Ledger({o.id: o.place for o in self.scene.map.objects})
        self.origin = dict(self.ledger.where)

    def shape(self, template: Template) -> Shape:
        """What a template does to the world."""
        return shape_of(template, self.scene.library)

    def placing(self) -> tuple[Template, ...]:
        """The templates that bring a thing to a place, in the library's order."""
        return tuple(t for t in self.scene.library.templates.values() if self.shape(t) is Shape.PLACE)

    def use(self, *parts: Token) -> None:
        """These words of the step have been understood."""
        self.used.extend(Extent(t.start, t.end) for t in parts)

    def note(self, kind: NoteKind, text: str, extent: Extent) -> None:
        self.notes.append(Note(self.now.number, kind, text, extent))

    def complain(
        self,
        code: str,
        title: str,
        extent: Extent,
        label: str = "",
        hint: str = "",
        *,
        candidates: Sequence[str] = (),
        severity: Severity = Severity.ERROR,
        step: LabelledStep | None = None,
    ) -> None:
        step = step or self.now
        text = step.text if len(step.text) <= _LONG else ""
        span = Span(self.source, step.number, extent.start + 1, extent.end + 1, text)
        self.diagnostics.append(Diagnostic(code, title, span, label, hint, severity, tuple(candidates)))

    def fault(self, fault: Fault) -> Stop:
        """Tell a fault; what is raised to leave the clause."""
        if fault.code:
            self.complain(fault.code, fault.title, fault.extent, fault.label, fault.help, candidates=fault.candidates)
        return Stop()

    def unknown_action(self, clause: Clause, verb: Verb) -> None:
        library = self.scene.library
        able = [t.name for t in library.templates.values() if t.verbs]
        near = f"; nearest: {', '.join(verb.alternatives)}" if verb.alternatives else ""
        self.complain(
            "E303",
            f"unknown action `{verb.text[:60]}`",
            clause.extent,
            f"no template of library `{library.name}` does this",
            f"it can {', '.join(able)}{near}  (llmbt atl show {library.name})",
            candidates=verb.alternatives,
        )
        self.lost = True
        self.targets = ((), -9)

    def left_out(self, clause: Clause, why: str) -> None:
        words = clause.extent.cut(self.now.text) or "the step"
        self.note(NoteKind.LEFT_OUT, f"`{words}` {why}", clause.extent)

    def talk(self) -> Talk:
        return Talk(
            self.ledger.where,
            self.ledger.handled,
            tuple(self.ledger.pending),
            self.targets[0] if self.turn - self.targets[1] <= 1 else (),
            self.described,
            self.place[0] if self.turn - self.place[1] <= 1 else None,
            self.lost,
            self.mentioned,
            self.around,
            self.ledger.vacated,
            self.listed[0] if self.turn - self.listed[1] <= 2 else (),
            self.whole,
            self.ledger.leaver,
            self.among,
        )

    def of_robot(self, phrase: Phrase) -> bool:
        """Whether a phrase is about a part of the robot and not about a thing that the scene calls so."""
        own = self.scene.vocabulary(True) | self.scene.vocabulary(False)
        return phrase.about("robot") and not any(t.text in own for t in phrase.parts if t.word)

    def quiet(self, phrase: Phrase) -> tuple[str, ...]:
        """The objects of a phrase, or none; nothing is said."""
        found = resolve_objects(phrase.parts, self.scene, self.talk())
        return found.ids if isinstance(found, Found) else ()

    def quiet_place(self, phrase: Phrase) -> str | None:
        found = resolve_places(phrase.parts, self.scene, self.talk())
        return found.ids[0] if isinstance(found, Found) and len(found.ids) == 1 else None

    def places_of(self, phrase: Phrase) -> tuple[str, ...]:
        found = resolve_places(phrase.parts, self.scene, self.talk())
        return found.ids if isinstance(found, Found) else ()

    def find(self, phrase: Phrase) -> Found:
        found = resolve_objects(phrase.parts, self.scene, self.talk())
        if isinstance(found, Fault):
            raise self.fault(found)
        return found

    def told(self, found: Found, phrase: Phrase) -> None:
        for text in found.corrected:
            self.note(NoteKind.CORRECTED, text, phrase.extent)
        for text in found.chosen:
            self.note(NoteKind.CHOSEN, text, phrase.extent)

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
        several = isinstance(found, Fault) and found.code == "E304"
        if isinstance(found, Fault) and several and phrase.apposed and before:
            found = before[-1] if set(before[-1].ids) <= set(found.candidates) else found
        if isinstance(found, Fault):
            raise self.fault(found)
        self.told(found, phrase)
        if pointing and set(found.ids) <= set(self.mentioned):
            self.named_beside(found.ids)
        return found

    def named_beside(self, ids: Sequence[str]) -> None:
        """Where the step names things outside its keywords, that were read by "it"."""
        parts = tokens(self.now.text)
        for first, last in mentions(parts, self.scene):
            name = tuple(t for t in parts if first.start <= t.start <= last.start)
            if {e.id for e in exactly_named(name, self.scene.objects)} == set(ids):
                self.use(*name)

    def narrowed(self, phrase: Phrase, talk: Talk, at: tuple[str, ...], picking: bool) -> Found | Fault:
        """A phrase's objects; where unlabelled words after it say a place ("everything on the shelf"), those there."""
        at = at or (ANYWHERE,) if any(lexicon().is_(t.text, "at", "from") for t in phrase.parts[1:-1]) else at
        place, words = self.trailing(phrase) if phrase.trail and not at else (None, ())
        if place is None and phrase.trail[:1] and phrase.trail[0].text in {"it", "them"} and not at:
            place, words = talk.place, phrase.trail[:1]  # "everything on it"
            if place is None and phrase.about("all"):
                said = f"`{phrase.extent.cut(self.now.text)} ... {phrase.trail[0].text}`"
                return Fault(
                    "E305", f"{said} points to no place named before", phrase.extent, "where?", "name the place"
                )
        if place is not None:
            found = resolve_objects(phrase.parts, self.scene, talk, at=(place,), picking=picking)
            if isinstance(found, Found):
                self.use(*words)
                return found
        return resolve_objects(phrase.parts, self.scene, talk, at=at, picking=picking)

    def aside(self, phrase: Phrase) -> tuple[str, ...] | None:
        """The objects that a parenthesis after a target, or an apposition, names or describes; None where it says
        something else."""
        parts = tuple(t for t in phrase.aside if t.text not in {",", "."}) or phrase.aside or phrase.after
        if parts and parts[0].text == "not":  # "the white cylinder (not the ball)"
            self.use(*parts)
            return None
        if not parts or (not phrase.aside and not any(t.number or t.text in self.scene.colours for t in parts)):
            return None
        found = resolve_objects(parts, self.scene, Talk(self.ledger.where))
        known = isinstance(found, Found) or found.code == "E304"
        if known:
            self.use(*parts)
        return (found.ids if isinstance(found, Found) else found.candidates) if known else None

    def agree(self, phrase: Phrase, found: Found, aside: tuple[str, ...]) -> Found | Fault:
        """ "the red block (object 6)", "object 6 (red)": one has to lie in the other; the
        smaller is meant.
        """
        if set(found.ids) <= set(aside):
            return found
        if set(aside) <= set(found.ids):
            return replace(found, ids=aside)
        if found.chosen and all(self.scene.fits(self.scene[i], w) for i in aside for w in found.words):
            return replace(found, ids=aside, chosen=())  # "a green block (object 2)"
        return Fault(
            "E307",
            f"`{phrase.extent.cut(self.now.text)}` is not what the parenthesis says",
            phrase.extent,
            f"this is {', '.join(found.ids)}, that is {', '.join(aside[:6])}",
            "name one of them",
            tuple(dict.fromkeys((*found.ids, *aside)))[:6],
        )

    def trailing(self, phrase: Phrase) -> tuple[str | None, tuple[Token, ...]]:
        """The place after "on" that follows a phrase unlabelled, if the words name one exactly; and the words."""
        for length in range(len(phrase.trail), 0, -1):
            found = resolve_places(phrase.trail[:length], self.scene, self.talk())
            if isinstance(found, Found) and len(found.ids) == 1 and not found.corrected:
                return found.ids[0], phrase.trail[:length]
        return None, ()

    def sure(self, group: Group) -> tuple[str, ...]:
        """The targets, if the words alone name them and no group of them."""
        ids: list[str] = []
        talk = self.talk()
        alone = replace(talk, targets=(), pending=())
        for p in group.targets:
            pointing = len(p.parts) == 1 and lexicon().is_(p.parts[0].text, "pronouns", "plural_pronouns")
            found = resolve_objects(p.parts, self.scene, talk if pointing else alone)
            if not isinstance(found, Found) or found.chosen or (len(found.ids) > 1 and not _listing(p)):
                return ()
            ids.extend(found.ids)
        return tuple(ids)

    def from_where(self, group: Group, locations: Sequence[Phrase]) -> tuple[str, ...]:
        """Where the targets are said to be. It tells objects apart; a known object elsewhere is a warning.

        A place that the scene lacks is an error, unless the words name none ("its current position").
        """
        out: list[str] = []
        for phrase in locations:
            if len(phrase.parts) == 1 and phrase.parts[0].text in {"it", "them"} and not self.sure(group):
                out.append(self.pointed_place(group, phrase))  # "everything on it"
                continue
            if all(lexicon().is_(t.text, "articles", "nowhere") or t.text in _VAGUE for t in phrase.parts):
                continue
            if phrase.about("home") or (len(phrase.parts) == 1 and phrase.parts[0].text == "here"):
                continue
            sure = self.sure(group)
            if phrase.relation or self.quiet(phrase):
                if not sure:
                    self.relation(phrase)
                continue
            found = resolve_places(phrase.parts, self.scene, self.talk())
            if isinstance(found, Fault):
                if found.code == "E304" and sure:
                    continue
                raise self.fault(found)
            ids = [i for i in found.ids if i not in {ANYWHERE, ORIGIN}]
            self.taken_off = (ids[0] if len(ids) == 1 else None, self.turn)
            if sure:
                self.check_there(sure, ids, phrase)
            else:
                out.extend(ids)
        return tuple(out)

    def pointed_place(self, group: Group, phrase: Phrase) -> str:
        """The place that "it" means in what tells where things are; E305 where none was named before."""
        place = self.talk().place
        if place is None or place in {ANYWHERE, ORIGIN}:
            said = " ... ".join(p.extent.cut(self.now.text) for p in (*group.targets[:1], phrase))
            self.complain(
                "E305", f"`{said}` points to no place named before", phrase.extent, "where?", "name the place"
            )
            raise Stop
        return place

    def check_there(self, ids: Sequence[str], places: Sequence[str], phrase: Phrase) -> None:
        for i in ids:
            where = self.ledger.where.get(i)
            if i in self.ledger.pending or not places:
                continue
            if not any(self.scene.within(where, p) or self.scene.within(self.origin[i], p) for p in places):
                self.complain(
                    "W320",
                    f"{i} is not on {', '.join(places)}",
                    phrase.extent,
                    f"it is on {where}" if where else "it is on no place of the map",
                    severity=Severity.WARNING,
                )

    def relation(self, phrase: Phrase) -> None:
        words = phrase.extent.cut(self.now.text)
        self.complain(
            "E309",
            f"`{phrase.relation or phrase.preposition} ... {words}`: this relation is not understood here",
            phrase.extent,
            "which place is meant?",
            "name the place itself",
        )
        raise Stop

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
        if last.text != "one" or not ranked or not noun or not self.scene.word(noun[0], False).text:
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


def _listing(phrase: Phrase) -> bool:
    return any(t.number is not None for t in phrase.parts)
