"""What an order's verb comes to: a deed, a step of the gripper's, the same again, or nothing that is a goal."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import pairwise, takewhile

from llmbt_atl.template import Template
from llmbt_compiler.parsing.acts import Acting
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Open, Stop
from llmbt_compiler.parsing.mentions import mentioned_in
from llmbt_compiler.parsing.model import Extent, NoteKind
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.statements import describes, predicate
from llmbt_compiler.parsing.verbs import Shape, Verb, read_verb, shape_of
from llmbt_compiler.parsing.words import lemmas, lexicon, tokens
from llmbt_ir.diagnostics import Severity

__all__ = ["Ordering"]

_STAYS = re.compile(r"\W*(?:where (?:it|they)|alone|untouched|unchanged|as (?:it|they)|in place)\b", re.IGNORECASE)
_IS = re.compile(
    r"\s+(?:(?:is|are|stands?|lies|lie|sits?)\s+(?:now\s+|currently\s+|still\s+|already\s+)*(?:on|in|at)"
    r"|(?:stays?|remains?)(?:\s+where)?|(?:should|must|may|is|are|need|does|do)\s*(?:not|n['’]t))\b",
    re.IGNORECASE,
)
_SAYS = re.compile(
    r"\W*(?:the\s+)?(?P<thing>[^,;:.]{2,60}?)\s+(?:stays?|remains?|(?:is|are)\s+(?:still|already|now|currently))\b",
    re.IGNORECASE,
)
_IDENTIFIES = re.compile(r"\s+(?:is|are|was|were)\s+(?:the|a|an|one\s+of)\b", re.IGNORECASE)
_PLACES = re.compile(
    r"\b(?:swap|switch|trade|exchange|change)\s+(?:places|positions|spots|slots|locations)\b", re.IGNORECASE
)
_LEAVES = re.compile(r"\s+(?:\w+\s+){0,2}?(?:leaves?|exits?)\s+(?!on\b|at\b|in\b)", re.IGNORECASE)
_ARE = re.compile(r"\s+(?:is|are)\s+(?:the\s+)?(?=\w+\s+\d|\w+_\d)", re.IGNORECASE)


_GOING = frozenset({"go", "belong", "end", "come"})
_WENT = frozenset({"went", "gone", "came", "ended", "going", "coming"})
_ENDING = frozenset({".", ";", ":", "!", "?"})
_BESIDE = frozenset({
    "when", "once", "after", "before", "until", "till", "as", "that", "which", "because", "since", "whether", "while",
    "where", "usually", "normally", "often", "used", "previously", "would", "might", "may", "could", "does", "did",
})  # fmt: skip
_ADVERBS = frozenset({"already", "just", "now", "also", "previously", "both", "all", "earlier", "once", "before"})
_MODAL = frozenset({"should", "must", "shall", "will", "to", "once", "after", "when", "until", "wish", "want", "like"})
_SURE = re.compile(r"\b(?:make\s+sure|ensure|see\s+to\s+it|be\s+sure)\s+that\b", re.IGNORECASE)


@dataclass
class Ordering(Acting):
    """Decides by the verb what a clause is."""

    def clause(self, clause: Clause) -> None:
        robot = [p for p in clause.phrases if self.of_robot(p)]
        things = Group(*(tuple(p for p in ps if p not in robot) for ps in _sides(clause)))
        if not clause.action:
            self.ellipsis(clause, things)
            return
        verb = self.verb(clause)
        if clause.negated:
            self.left_out(clause, "says what not to do")
            return
        if clause.heading:
            self.mention(things)
            self.left_out(clause, "tells beforehand what follows")
            return
        if self.idiom(clause):
            self.left_out(clause, "changes no goal")
            return
        if clause.conditional:
            self.contingency(clause, verb)
            return
        if self.past(clause):
            self.mention(things)
            self.left_out(clause, "is said to have been done")
            return
        if describes(
            self.now.text, clause.extent, min((p.extent.start for p in things.phrases), default=clause.extent.end)
        ):
            self.complain("E314", "it is said how things are, and not what is to be done", clause.extent, "do what?")
            return
        things = self.alone(verb, things)
        if self.goes(clause, verb, things):
            self.ellipsis(clause, things)
        elif verb.is_("again") and not verb.templates:
            self.again(clause, things)
        elif verb.is_("closing") and not self.held(things, verb) and (robot or verb.lemma != "wrap"):
            self.close(clause, things)
        elif verb.is_("opening") and (robot or not things.targets or not verb.templates or _release(verb)):
            self.open(clause, verb, things, bool(robot))
        elif any(p.kind == "Target" for p in robot) and not things.targets:
            self.moves(clause, things)
        elif verb.is_("exchange") and not things.targets and not any(self.places_of(p) for p in things.phrases):
            self.left_out(clause, "changes no goal")  # "switch to standby mode"
        elif verb.is_("exchange"):
            self.exchange(clause, things)
        elif verb.is_("leaving") and self.moved_here(clause, things):
            words = clause.extent.cut(self.now.text)
            self.complain("E304", f"`{words}`: the step moves it", clause.extent, "which?", "say what is to be moved")
        elif verb.is_("leaving") and things.targets and not things.destinations and self.stays(clause, things):
            if not self.ledger.pending:
                self.mention(things)
            self.left_out(clause, "changes no goal")
        elif verb.lemma == "leave" and any(
            not p.preposition and p.extent.start > clause.extent.end and not _pointing(p)
            for p in (*things.destinations, *things.locations)
        ):
            self.unknown_action(clause, verb)  # "parcel 21 should leave slot B3"
        elif verb.templates and not self.of_itself(verb, things):
            self.act(clause, verb, things)
        else:
            self.without_template(clause, verb, things)

    def goes(self, clause: Clause, verb: Verb, things: Group) -> bool:
        """ "Object 1 goes to position 11", "the crates belong in rack A": a thing, said before the verb, is to be where
        the words behind it say."""
        lex = lexicon()
        if not (_lemmas(verb.text) & _GOING and verb.text.casefold() not in _WENT and things.targets):
            return False
        first, to = things.targets[0], things.destinations
        if not to or first.extent.start > clause.extent.start or to[0].extent.start < clause.extent.end:
            return False
        belongs = "belong" in _lemmas(verb.text)
        if any(not lex.is_(p.preposition, "onto", "at") or p.preposition == "for" for p in to[:1]):
            return False
        if belongs and to[0].preposition == "to":
            return False  # whose it is
        begin = max((t.end for t in tokens(self.now.text, 0, first.extent.start) if t.text in _ENDING), default=0)
        begin = max((m.end() for m in _SURE.finditer(self.now.text, begin, first.extent.start)), default=begin)
        words = [t.text for t in tokens(self.now.text, begin, first.extent.start)]
        later = [i for i, (a, b) in enumerate(pairwise(words)) if a == "after" and b in {"that", "this"}]
        lead = set(words[later[-1] + 2 :] if later else words)
        inner = {t.text for t in tokens(self.now.text, first.extent.end, clause.extent.start)}
        return not any(w in _BESIDE or lex.is_(w, "negation", "conditional") for w in lead | inner)

    def past(self, clause: Clause) -> bool:
        """ "Object 6 has been moved to position 31": what was done before is no order; "should have been" is one."""
        lead = [t.text for t in tokens(self.now.text, 0, clause.extent.start)]
        while lead and (lead[-1].endswith("ly") or lead[-1] in _ADVERBS):
            lead.pop()
        been = lead[-2:-1] and lead[-1] == "been" and lead[-2] in {"has", "have", "had"}
        told = (been or lead[-1:] in (["was"], ["were"])) and bool(clause.phrases)
        return bool(told) and not any(w in _MODAL or lexicon().is_(w, "conditional") for w in lead)

    def alone(self, verb: Verb, things: Group) -> Group:
        """ "Drive to the desk with it": what is in the hand comes along, and is not put down there; a person is given
        it."""
        if not verb.is_("motion") or not things.destinations:
            return things
        place = self.quiet_place(things.destinations[-1])
        if place is None or place in {ANYWHERE, ORIGIN} or self.scene[place].person:
            return things
        along = [p for p in things.targets if p.preposition == "with" and self.on_hand(Group((p,)))]
        return replace(things, targets=tuple(p for p in things.targets if p not in along))

    def of_itself(self, verb: Verb, things: Group) -> bool:
        """Whether a verb that may also be said of a thing is said of the robot: "rest a while", "stand by"."""
        if things.targets or not verb.is_("idle", "own") or verb.is_("leaving"):
            return False
        return "_" in verb.lemma or not (self.ledger.pending and things.destinations)

    def idiom(self, clause: Clause) -> bool:
        """ "Take a look", "have a break": the noun tells what is done. "Do nothing with the apple"."""
        after = [t.text for t in tokens(self.now.text, clause.extent.end)][:4]
        if after[:1] == ["nothing"] and clause.action.casefold() == "do":
            return True
        return bool(after) and any(lexicon().is_(w, "idioms") for w in after[: 4 if after[0] in {"a", "an"} else 1])

    def moved_here(self, clause: Clause, things: Group) -> bool:
        """ "Empty the tray onto the pallet, but leave parcel 17": what the step moved is not to be."""
        lead = [t.text for t in tokens(self.now.text, 0, clause.extent.start)][-2:]
        ids = {i for p in things.targets for i in self.quiet(p)}
        moved = {e.target for e in self.ledger.moves if e.step.number == self.now.number}
        return "but" in lead and not (things.destinations or things.locations) and bool(ids & moved)

    def stays(self, clause: Clause, things: Group) -> bool:
        """ "Leave object 6 where it is", or what is not in the hand."""
        ids = [i for p in things.targets for i in self.quiet(p)]
        apart = bool(ids) and not things.locations and not set(ids) & (set(self.ledger.pending) | self.ledger.handled)
        apart = apart and self.missed(clause) is None
        return apart or any(_STAYS.match(self.now.text, p.extent.end) for p in things.targets)

    def verb(self, clause: Clause) -> Verb:
        words = [t.text for t in tokens(clause.action) if t.word]
        head = words[0] if words else clause.action.strip()[:40].casefold() or "?"
        rest = tuple(words[1:])
        if head == "re" and rest:
            head, rest = rest[0], rest[1:]
        head = self.meant(clause, head)
        verb = read_verb(head, (*rest, *clause.particles), self.scene.library)
        if verb.classes and all(self.shape(t) is Shape.OTHER for t in verb.templates):
            verb = replace(verb, templates=())  # a skill that looks makes no goal
        if verb.corrected:
            self.note(NoteKind.CORRECTED, f"`{head}` is read as `{verb.lemma}`", clause.extent)
        return verb

    def meant(self, clause: Clause, head: str) -> str:
        """The verb that an idiom stands for: "make your way to", "have object 4 placed on"."""
        after = [t.text for t in tokens(self.now.text, clause.extent.end)[:2]]
        if head in {"make", "find"} and after[1:] == ["way"]:
            return "go"
        targets = [p.extent.end for p in clause.phrases if p.kind == "Target" and p.extent.start > clause.extent.end]
        if head in {"have", "make", "let", "get"} and targets and _PLACES.search(self.now.text, max(targets)):
            return "swap"  # "have the milk and the newspaper switch places"
        if head not in {"have", "get", "want", "need", "see"} or not targets:
            return head
        done = next((t.text for t in tokens(self.now.text, targets[0]) if t.text not in {"to", "be"}), "")
        participle = done.endswith(("ed", "en")) or done in {"put", "set", "brought", "sent", "laid"}
        verb = read_verb(done, (), self.scene.library) if participle else None
        return done if verb is not None and verb.templates and not verb.corrected else head

    def contingency(self, clause: Clause, verb: Verb) -> None:
        """ "If it falls, pick it up": the tree does so by itself; a condition of another kind is told."""
        self.left_out(clause, "depends on a condition; a goal holds or is brought about, whatever happens")
        if any(shape_of(t, self.scene.library) in {Shape.PLACE, Shape.FREE} for t in verb.templates):
            self.complain(
                "W321", "a conditional step is left out", clause.extent, "", "say it without `if`",
                severity=Severity.WARNING,
            )  # fmt: skip

    def ellipsis(self, clause: Clause, things: Group) -> None:
        """A step without an action: as the step before, if that put something somewhere."""
        ends = [p.extent.end for p in things.targets]
        said = _SAYS.match(self.now.text) if not things.targets else None
        if said is not None and mentioned_in(said["thing"], self.scene):
            self.used.append(Extent(0, len(self.now.text)))
            self.left_out(clause, "is said to be so; nothing is to be done")
            return
        told = ends and (
            _IS.match(self.now.text, ends[-1])
            or _IDENTIFIES.match(self.now.text, ends[0])
            or (len(ends) > 1 and _ARE.match(self.now.text, ends[0]))
        )
        if told:
            self.mention(Group(things.targets))
            self.left_out(clause, "is said to be so; nothing is to be done")
            return
        if ends and _LEAVES.match(self.now.text, ends[0]):
            self.unknown_action(clause, read_verb("leave", (), self.scene.library))
            return
        templates = self.last or tuple(sorted(self.placing(), key=lambda t: "_" in t.name))
        if things.targets and not things.destinations and self.likewise():
            self.again(clause, things)
            return
        if things.targets and things.destinations and templates and not self.predicate(things):
            self.note(NoteKind.INFERRED, f"no action is named: read as `{templates[0].name}`", clause.extent)
            self.act(clause, Verb("", templates[0].name, templates), things)
            return
        self.complain("E305", "no action is named", clause.extent, "do what?", "begin the step with a verb")

    def predicate(self, things: Group) -> str:
        """The first word between a thing and its place that says something else than that it goes there."""
        place = min(p.extent.start for p in things.destinations)
        ends = [p.extent.end for p in things.targets if p.extent.end <= place]
        return predicate(self.now.text, max(ends), place, self.scene) if ends else ""

    def likewise(self) -> bool:
        """Whether a step without an action says that it is as the one before ("same for object 2", "object 2 too")."""
        return any(lexicon().is_(t.text, "likewise", "same") for t in tokens(self.now.text))

    def without_template(self, clause: Clause, verb: Verb, things: Group) -> None:
        if verb.is_("wishing") and things.targets and things.destinations:
            self.ellipsis(clause, things)  # "I want object 3 on position 22"
        elif ((verb.is_("idle") and not verb.is_("motion")) or (verb.is_("own") and not things.targets)) or (
            verb.is_("hand") and things.targets and self.quiet(things.targets[0])
        ):
            self.mention(things)
            self.left_out(clause, "changes no goal")
            self.idle = verb.is_("checking")
            self.forbidden(clause, verb)
        elif verb.is_("motion") and not things.targets:
            self.moves(clause, things)
        elif verb.is_("removing") and any(self.quiet(p) for p in things.targets) and self.placing():
            self.act(clause, Verb(verb.text, verb.lemma, self.placing()), things)  # "clear the cup off to the desk"
        elif verb.is_("reaching") and all(self.quiet(p) or self.places_of(p) for p in things.targets):
            self.mention(things)
            self.left_out(clause, "changes no goal")
        else:
            self.unknown_action(clause, verb)

    def forbidden(self, clause: Clause, verb: Verb) -> None:
        """ "Avoid placing anything on position 11": what is named up to the next mark is not to be done."""
        after = tokens(self.now.text, clause.extent.end)
        if verb.is_("refraining") and after and after[0].text.endswith("ing"):
            self.use(*takewhile(lambda t: t.word or t.number is not None, after))

    def close(self, clause: Clause, things: Group) -> None:
        """Closing the gripper picks up what it is closed around, or what was approached just before."""
        around = [i for p in things.phrases for i in self.quiet(p)]
        if not around and not self.ledger.pending and self.approached is not None:
            around = [self.approached]
        pick = next((t for t in self.scene.library.templates.values() if self.shape(t) is Shape.PICK), None)
        if any(p.kind == "Target" for p in things.targets) and not around:
            self.unknown_action(clause, read_verb("close", (), self.scene.library))
            return
        if pick is not None and len(around) == 1 and around[0] not in self.ledger.pending:
            self.take(clause, pick, around, weak=True)
        self.left_out(clause, "changes no goal")

    def open(self, clause: Clause, verb: Verb, things: Group, gripper: bool) -> None:
        """Opening the gripper puts down what it holds where it was taken to."""
        if things.targets and not gripper and not _release(verb):
            self.unknown_action(clause, verb)
            return
        pending = tuple(self.ledger.pending)
        placing = self.placing()
        known = pending or (not gripper and bool(things.targets) and all(self.quiet(p) for p in things.targets))
        if known and things.destinations and placing:
            self.act(clause, Verb("", placing[0].name, placing), things)
            return
        if pending and self.ledger.carried is not None and placing:
            self.note(NoteKind.INFERRED, f"{', '.join(pending)} is let go at {self.ledger.carried}", clause.extent)
            self.put(clause, placing, pending, (self.ledger.carried,))
            return
        if pending and not all(e.weak for e in self.ledger.pending.values()):
            self.complain(
                "E305", f"{', '.join(pending)} is let go, but where?", clause.extent, "no place is named",
                "name the place where it is to be put",
            )  # fmt: skip
            for i in pending:
                self.ledger.pending.pop(i)
            return
        self.left_out(clause, "changes no goal")

    def again(self, clause: Clause, things: Group) -> None:
        """ "Do the same for objects 2 and 4": as before, if the place before holds more than one thing."""
        targets = [p for p in things.phrases if not p.about("talk")]
        if not targets and self.until(clause):
            return
        spoken = (replace(g, targets=tuple(p for p in g.targets if not p.about("talk"))) for g in clause.groups)
        groups = [g for g in spoken if g.phrases]
        pairs = [g for g in groups if g.targets and g.destinations]
        templates = self.last or (self.placing() if self.ledger.moves else ())
        if len(pairs) > 1 and len(pairs) == len(groups) and templates:  # "for object 5 at 22 and object 6 at 23"
            self.note(NoteKind.INFERRED, f"as before: read as `{templates[0].name}`", clause.extent)
            for group in pairs:
                self.bring(clause, templates, group, ())
            return
        to = tuple(p for p in targets if not self.quiet(p) and self.places_of(p))
        if to and self.last and len(to) < len(targets):  # "repeat it for object 2 on position 12"
            things = Group(tuple(p for p in targets if p not in to), to)
            self.note(NoteKind.INFERRED, f"as before: read as `{self.last[0].name}`", clause.extent)
            self.bring(clause, self.last, things, ())
            return
        ids = tuple(dict.fromkeys(i for p in targets for i in self.quiet(p)))
        fresh = tuple(i for i in ids if i not in self.ledger.handled)
        if not ids and targets and not targets[0].about("rest"):
            self.find(targets[0])
        if not fresh:
            self.left_out(clause, "changes no goal")
            return
        if self.container is None or not self.last:
            self.complain(
                "E305", f"the same for {', '.join(fresh)}, but where?", clause.extent, "no place is named",
                "name the place of each",
            )  # fmt: skip
            return
        self.note(NoteKind.INFERRED, f"{', '.join(fresh)}: also to {self.container}", clause.extent)
        self.put(clause, self.last, fresh, (self.container,))

    def until(self, clause: Clause) -> bool:
        """ "Repeat this until all green blocks are there": for those that are left. Another end to it is E305, where
        something is left."""
        words = tokens(self.now.text, clause.extent.end)
        at = next((i for i, t in enumerate(words) if t.text in {"until", "till"}), None)
        if at is None:
            return False
        said = tuple(takewhile(lambda t: t.text not in {"is", "are", "have", "has"}, words[at + 1 :]))
        found = resolve_objects(said, self.scene, self.talk()) if said else None
        left = [i for i in found.ids if i not in self.ledger.handled] if isinstance(found, Found) else []
        if not left:
            return False
        self.use(*said)
        there = any(t.text == "there" for t in words[at + 1 + len(said) :][:2])
        if there and self.container is not None and self.last:
            self.note(NoteKind.INFERRED, f"{', '.join(left)}: also to {self.container}", clause.extent)
            self.put(clause, self.last, tuple(left), (self.container,))
            return True
        self.complain(
            "E305", f"the same for {', '.join(left[:6])}, but where?", clause.extent, "no place is named",
            "name the place of each",
        )  # fmt: skip
        return True

    def act(self, clause: Clause, verb: Verb, things: Group) -> None:
        """A verb with a template: each group of its phrases fills one condition or more."""
        templates = verb.templates
        lowered = verb.is_("hand") and things.destinations and self.ledger.pending
        if not things.targets and verb.is_("motion") and not self.travels(templates) and not lowered:
            self.moves(clause, things)
            return
        placing = {Shape.PLACE, Shape.TRAVEL}.issuperset(self.shape(t) for t in templates[:1])
        hovering = [p for p in things.destinations if lexicon().is_(p.relation, "hover")]
        if (
            placing
            and hovering
            and len(hovering) == len(things.destinations)
            and self.ledger.pending
            and self.on_hand(things)
        ):
            self.mention(Group(things.targets))  # "move object 6 over position 14", which is in the hand
            self.carry_to(replace(hovering[0], relation=""))
            self.left_out(clause, "changes no goal")
            return
        if verb.is_("hand"):
            real = tuple(p for p in things.destinations if not p.relation and self.places_of(p))
            if self.in_hand(things) and not real:
                self.mention(things)
                self.left_out(clause, "changes no goal")
                return
            things = replace(things, destinations=real)
        groups = clause.groups or (Group(),)
        for i, group in enumerate(groups):
            self.following, self.leading = i > 0, self.led(groups[i + 1]) if i + 1 < len(groups) else ()
            if i and self.led(group):
                continue
            kept = Group(*(tuple(p for p in ps if p in things.phrases and not p.excluded) for ps in _of(group)))
            excluded = tuple(p for p in group.targets if p.excluded)
            if len(groups) > 1 and not kept.phrases:
                continue
            try:
                self.group(clause, templates, kept, excluded)
            except Open:
                continue
            except Stop:
                self.lost = True
                self.targets = ((), -9)

    def led(self, group: Group) -> tuple[Phrase, ...]:
        """ "The two balls on level 2, the white one first": what is to come first."""
        after = [t.text for p in group.targets[-1:] for t in tokens(self.now.text, p.extent.end)[:1]]
        return group.targets if after == ["first"] and len(group.phrases) == 1 else ()

    def on_hand(self, things: Group) -> bool:
        """Whether the targets are what is in the hand, or none are named."""
        return all(set(self.quiet(p)) <= set(self.ledger.pending) and self.quiet(p) for p in things.targets)

    def group(
        self, clause: Clause, templates: tuple[Template, ...], group: Group, excluded: tuple[Phrase, ...]
    ) -> None:
        templates = tuple(t for t in templates if self.shape(t) is not Shape.OTHER) or templates
        shape = self.shape(templates[0])
        if shape is Shape.TRAVEL:
            self.travel_or_carry(clause, templates, group, excluded)
        elif shape is Shape.PICK and self.likewise_there(group):
            self.bring(clause, self.placing(), group, excluded)
        elif shape is Shape.PICK:
            self.pick(clause, templates, group, excluded)
        elif shape is Shape.FREE:
            self.clear(clause, templates, group, excluded)
        elif shape is Shape.PLACE:
            self.bring(clause, templates, group, excluded)
        elif shape is Shape.CHANGE:
            self.change(clause, templates[0], group, excluded)
        else:
            self.unknown_action(clause, Verb(clause.action, clause.action))

    def travel_or_carry(
        self, clause: Clause, templates: tuple[Template, ...], group: Group, excluded: tuple[Phrase, ...]
    ) -> None:
        """ "Move the milk to the bar" where "move" is the robot's own verb: the target makes it a placing."""
        if not group.targets:
            self.travel(clause, templates[0], group)
        elif (group.destinations or self.to_origin(clause)) and self.placing():
            self.bring(clause, self.placing(), group, excluded)
        elif self.quiet(group.targets[0]) and not group.destinations:
            self.mention(group)
            self.left_out(clause, "changes no goal")
        else:
            self.travel(clause, templates[0], Group((), group.targets))


def _lemmas(word: str) -> frozenset[str]:
    return frozenset(lemmas(word.casefold()))


def _pointing(phrase: Phrase) -> bool:
    """ "Leave it there"."""
    return len(phrase.parts) == 1 and lexicon().is_(phrase.parts[0].text, "there")


def _sides(clause: Clause) -> tuple[tuple[Phrase, ...], tuple[Phrase, ...], tuple[Phrase, ...]]:
    return (
        tuple(p for g in clause.groups for p in g.targets),
        tuple(p for g in clause.groups for p in g.destinations),
        tuple(p for g in clause.groups for p in g.locations),
    )


def _of(group: Group) -> tuple[tuple[Phrase, ...], tuple[Phrase, ...], tuple[Phrase, ...]]:
    return group.targets, group.destinations, group.locations


def _release(verb: Verb) -> bool:
    """Whether a verb lets go of its target, as the library has it or by its name."""
    return verb.lemma in {"release", "let_go", "ungrasp", "unclamp"}
