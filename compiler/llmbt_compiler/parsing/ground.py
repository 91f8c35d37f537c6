"""The names of a clause held against the map, with what the step says around them; and
the telling of faults.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from llmbt_atl.template import Template
from llmbt_compiler.parsing.beside import mentions
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.model import Extent, LabelledStep, Note, NoteKind
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import Shape, Verb, shape_of
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic, Severity, Span

__all__ = ["Grounding", "Open", "Stop"]

_LONG = 2000
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


def _listing(phrase: Phrase) -> bool:
    return any(t.number is not None for t in phrase.parts)
