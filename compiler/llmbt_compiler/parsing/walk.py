"""The paper's parser: each keyword read in turn; an action opens a condition found by its Post, the names
fill it.

`parse` is a pure function. It goes through the clauses of the steps in order, keeps what was said and done so
far in a `Ledger`, and gives every complaint at once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from llmbt_atl.library import Library
from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.beside import done_before, goes_unread, mentioned, restrictions, unread
from llmbt_compiler.parsing.clauses import clauses
from llmbt_compiler.parsing.doubts import corrects, doubts
from llmbt_compiler.parsing.explained import explanation, without
from llmbt_compiler.parsing.frames import among
from llmbt_compiler.parsing.gist import gist
from llmbt_compiler.parsing.ground import Stop
from llmbt_compiler.parsing.headings import headed
from llmbt_compiler.parsing.identified import identified
from llmbt_compiler.parsing.lacking import lacking
from llmbt_compiler.parsing.ledger import Entry
from llmbt_compiler.parsing.mentions import mentioned_in
from llmbt_compiler.parsing.model import Extent, LabelledStep, Move, NoteKind, ParseResult
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.orders import Ordering
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.relabel import relabelled
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.scoped import left_out_first
from llmbt_compiler.parsing.sequence import in_time
from llmbt_compiler.parsing.space import arrangement, certainty, compared, related, stepped
from llmbt_compiler.parsing.statements import asks_a_fact, courteous, states_a_fact
from llmbt_compiler.parsing.verbs import read_verb
from llmbt_compiler.parsing.weigh import Trial, shares, weigh
from llmbt_compiler.parsing.whichever import emptied, narrowed, whichever
from llmbt_compiler.parsing.words import lexicon, tokens
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import Severity, nearest
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["THRESHOLD", "parse"]

THRESHOLD = 0.5
"""Steps that the tagger is less sure of become diagnostics."""
_OFTEN = 3
"""An object that is moved again so often is told of."""
_MOST = 500
_GOING = frozenset({
    "goes", "go", "takes", "take", "comes", "come", "joins", "join", "belongs", "follows", "replaces", "moves",
    "should", "shall", "must", "ought", "likewise", "too",
})  # fmt: skip
_FORMAL = frozenset({"E301", "E302", "E303", "E305", "E306", "E314"})
"""Complaints that another way to put a step may settle."""
_LONGEST = 10_000
_POINTED = re.compile(
    r"^\W*(?:(?:do\s+you|can\s+you|you)\s+)?(?:see|know|spot|notice|remember|look\s+at|take\s+a\s+look\s+at|there(?:['\u2019]s|\s+is))\s+"
    r"(?P<thing>(?:the|that|this|a|an|my|our)\s[^,;:.!?]{2,100}?)(?:\s+(?:over\s+there|right|yes|eh|huh))?[\s,?.!]*$",
    re.IGNORECASE,
)
"""A remark that does nothing but point a thing out."""


def parse(
    steps: Iterable[LabelledStep],
    semantic_map: SemanticMap,
    library: Library,
    *,
    threshold: float = THRESHOLD,
    partial: bool = False,
    source: str = "steps.json",
    snap: bool = True,
) -> ParseResult:
    """Goals from labelled steps, in the order of the steps; every complaint at once.

    `partial`: a step below the threshold is left out with a warning instead of an error. `snap`: keywords are brought
    to the names of the map (slips of the pen, names that a keyword cuts, of several readings the one that the map bears
    out); without it they are taken as the tagger gives them. Diagnostics E301-E314 and W320-W322 (docs/parsing.md),
    their spans with the step's number as the line and columns counted from 1.
    """
    walker = _Walker(Scene(semantic_map, library, snap), source, threshold=threshold, partial=partial)
    listed = tuple(steps)
    walker.named = walker.destinations(listed)
    for step in listed:
        walker = walker.after(step)
    return walker.result()


def _joined(step: LabelledStep) -> bool:
    """Whether a step's destinations are joined by "and": two places are said, and it is no slip of the tagger's."""
    ends = [s for s in step.spans if s.label is Kind.DESTINATION]
    return len(ends) > 1 and any(t.text == "and" for t in tokens(step.text[ends[0].end : ends[-1].start]))


@dataclass
class _Walker(Ordering):
    """Goes through the steps; of several readings of one it takes what the map bears out."""

    threshold: float = THRESHOLD
    partial: bool = False

    def destinations(self, steps: Sequence[LabelledStep]) -> frozenset[str]:
        """The places that the steps name as destinations: a free position is first sought
        among the others.
        """
        out: set[str] = set()
        for step in steps[:_MOST]:
            for clause in clauses(relabelled(step, self.scene)) if len(step.text) <= _LONGEST else ():
                for p in clause.phrases:
                    found = resolve_places(p.parts, self.scene, Talk()) if p.kind == "Destination" else None
                    if isinstance(found, Found) and not found.vague:
                        out.update(found.ids)
        return frozenset(out)

    def after(self, step: LabelledStep) -> _Walker:
        """The walker after a step, which may take back what was said before it."""
        before, handled = self.errors(), self.ledger.handled
        walker = self.as_said(step)
        if (before or handled) and walker.errors() <= before and corrects(step.text):
            walker.corrected(step, handled)
        return walker

    def as_said(self, step: LabelledStep) -> _Walker:
        """The walker after a step; one that is not understood, or asks for nothing, is read by its gist, if any."""
        named = self.by_name(step) if len(step.text) <= _LONGEST else step
        if isinstance(named, Fault):
            self.now, self.lost, self.targets = step, True, ((), -9)
            self.fault(named)
            return self
        step = named
        before, acts, stood = self.errors(), self.ledger.acts, self.ledger.standing()
        kept = self.fork()
        walker = self.identified(step)
        if walker.errors() <= before and (walker.ledger.acts > acts or walker.ledger.standing()[:3] != stood[:3]):
            return walker
        told = {d.code for d in walker.diagnostics[len(kept.diagnostics) :] if d.severity is Severity.ERROR}
        if not told <= _FORMAL:
            return walker  # which one, or that it cannot be, is no question of form
        plain = gist(step, self.scene, kept.talk()) if len(step.text) <= _LONGEST else None
        if plain is None:
            return walker
        other = kept.read(plain)
        if other.errors() > before or other.ledger.standing() == stood:
            return walker
        other.note(NoteKind.CORRECTED, f"read as `{plain.text}`", Extent(0, len(step.text)))
        return other

    def identified(self, step: LabelledStep) -> _Walker:
        """The walker after a step; where a description fits several things and their name follows, the name counts."""
        before, kept = self.errors(), self.fork()
        walker = self.explained(step)
        told = [d.code for d in walker.diagnostics[len(kept.diagnostics) :] if d.severity is Severity.ERROR]
        plain = identified(step, self.scene) if {"E304", "E314"} & set(told) and len(step.text) <= _LONGEST else None
        if plain is None:
            return walker
        other = kept.explained(plain)
        return other if other.errors() <= before else walker

    def corrected(self, step: LabelledStep, earlier: frozenset[str]) -> None:
        """Complain of a step that takes back what one before it ordered, and is no order to put the same thing
        elsewhere. `earlier`: the things that something had been done with."""
        again = {e.target for e in self.ledger.moves if e.step.number == step.number}
        again |= {i for i, e in self.ledger.pending.items() if e.step.number == step.number}
        if again and again <= earlier:
            return
        self.now = step
        title = f"`{step.text[:60]}` puts otherwise what was said before it"
        self.complain("E314", title, Extent(0, len(step.text)), "", "say only what is to be done")

    def by_name(self, step: LabelledStep) -> LabelledStep | Fault:
        """The step with the names of things and places in place of comparisons and of counts; the fault of one that
        names nothing, or too much."""
        found: LabelledStep | Fault = emptied(narrowed(whichever(step, self.scene), self.scene), self.scene)
        for settle in (compared, stepped):
            found = settle(found, self.scene, self.talk()) if not isinstance(found, Fault) else found
        return found

    def explained(self, step: LabelledStep) -> _Walker:
        """The walker after a step. Where it is not understood, what it adds to a name that is clear without it is
        passed over, unless that names something else."""
        extent = explanation(step, self.scene) if len(step.text) <= _LONGEST and {",", "("} & set(step.text) else None
        if extent is None:
            return self.read(step)
        before, whole, plain = self.errors(), self.fork().read(step), self.fork()
        if whole.errors() <= before or any(d.code == "E307" for d in whole.diagnostics[len(self.diagnostics) :]):
            return whole
        plain = plain.read(without(step, extent))
        if plain.errors() > before:
            return whole
        plain.note(NoteKind.LEFT_OUT, f"`{extent.cut(step.text).strip(' ,')}` only explains", extent)
        return plain

    def read(self, step: LabelledStep) -> _Walker:
        """The walker after a step: of the ways to read it, the one that the probabilities and the map bear out."""
        if len(step.readings) < 2 or len(step.text) > _LONGEST or not self.scene.snap:
            self.step(step)
            return self
        trials: list[Trial[_Walker]] = []
        for reading in step.readings:
            walker = self.fork()
            errors = walker.errors()
            walker.step(replace(step, spans=reading.spans, confidence=1.0, readings=()))
            clean = walker.errors() <= errors
            trials.append(Trial(walker, reading.probability, clean, walker.ledger.standing()))
        if any(
            d.code in {"E312", "E343"} and _joined(step) for d in trials[0].value.diagnostics[len(self.diagnostics) :]
        ):
            return trials[0].value
        chosen = weigh(trials, self.ledger.standing(), self.threshold, self.lesser(step))
        if chosen is None:
            self.now = step
            self.unsure(step, trials)
            return self
        if chosen is not trials[0]:
            chosen.value.note(NoteKind.CORRECTED, "the step is read as the map has it", Extent(0, len(step.text)))
        return chosen.value

    def lesser(self, step: LabelledStep) -> Callable[[_Walker, _Walker], bool]:
        """Whether what one walker came to is a part of what another did: it missed what the step asks for besides.
        Never so where the step says what is not meant."""
        said = {t.text for t in tokens(step.text)}
        if any(lexicon().is_(w, "negation", "except", "instead", "conditional") for w in said):
            return lambda _a, _b: False
        done = self.ledger.acts

        def less(a: _Walker, b: _Walker) -> bool:
            (some, held, _, _), (all_, kept, _, _) = a.ledger.standing(), b.ledger.standing()
            moved = {e.target for e in b.ledger.goals}
            return a.ledger.acts > done and kept <= held <= kept | moved and some < all_

        return less

    def errors(self) -> int:
        return sum(d.severity is Severity.ERROR for d in self.diagnostics)

    def passed_over(self, step: LabelledStep, whole: Extent) -> bool:
        """A step that is too long, too uncertain, or a question for information is not read; why is noted."""
        if len(step.text) > _LONGEST:
            self.complain("E313", f"step {step.number} is longer than {_LONGEST} characters", Extent(-1, -1))
        elif courteous(step.text):
            self.note(NoteKind.LEFT_OUT, "the step names nothing to be done", whole)
        elif certainty(step) < self.threshold and step.spans:
            self.unsure(step)
        elif asks_a_fact(step.text) or states_a_fact(step.text) or ("?" in step.text and _POINTED.match(step.text)):
            self.note(NoteKind.LEFT_OUT, "the step asks or says how things are; nothing is to be done", whole)
            self.mentioned = self.pointed_out(step)
            self.remarked(forbidden=False)
        else:
            return False
        return True

    def step(self, step: LabelledStep) -> None:
        self.now = step
        whole = Extent(0, len(step.text))
        if self.passed_over(step, whole):
            return
        spared = left_out_first(step, self.scene)
        self.spared = spared[0] if spared is not None else ()
        if spared is not None:
            step = without(step, spared[1])
        step = relabelled(step, self.scene)
        if step.text != self.now.text:
            self.now = replace(self.now, text=step.text)
        self.mentioned, self.used = mentioned(step, self.scene, self.scene.objects), []
        self.around = mentioned(step, self.scene, self.scene.places)
        self.ordered = arrangement(step.text) is not None
        chosen = among(step, self.scene)
        self.among = chosen[0] if chosen is not None else ()
        if chosen is not None:
            step = replace(step, spans=tuple(s for s in step.spans if s.start >= chosen[1].end))
            self.used.append(chosen[1])
        under = headed(step, self.scene)
        if under is not None:
            step, place, extent = under
            self.place = (place, self.turn)
            self.used.append(extent)
        found = clauses(step)
        self.use(*(t for c in found for p in c.phrases for t in p.parts))
        told = {t.text for t in tokens(step.text)} if not found else set()
        forbidden = any(lexicon().is_(w, "negation") for w in told - {"instead"}) and told.isdisjoint(
            {"but", "instead", "rather"}
        )
        if not found and not forbidden and (self.names_both(step) or self.names_mover(step)):
            self.complain("E305", "no action is named", whole, "do what?", "begin the step with a verb")
            return
        if not found:
            self.note(NoteKind.LEFT_OUT, "the step names nothing to be done", whole)
            self.mentioned = self.pointed_out(step)
            self.remarked(forbidden=forbidden)
            return
        before = (self.ledger.acts, self.targets, self.place)
        earlier = len(self.diagnostics)
        asks = False
        for clause, (start, end) in in_time(found[:_MOST], step.text, spoken_of=self.spoken_of()):
            self.idle, self.barred = False, set()
            try:
                for part in related(self, clause, start, end):
                    self.clause(part)
            except Stop:
                asks = True
                continue
            asks = asks or not self.idle
            if self.idle and not self.orders_within(step.text, start, end):
                self.used.append(Extent(start, end))
        self.overlooked(step, earlier, asks=asks)
        if before != (self.ledger.acts, self.targets, self.place):
            self.turn += 1

    def pointed_out(self, step: LabelledStep) -> tuple[str, ...]:
        """The thing that a remark points out ("see the yellow block next to the red one?"): its head, as if it were to
        be taken, and not what it is told by; of other remarks, what they name."""
        m = _POINTED.match(step.text)
        named = mentioned(step, self.scene, self.scene.objects)
        if m is None:
            return named
        text = f"Take {m['thing']}."
        head = next((t for t in tokens(text, 5) if not lexicon().is_(t.text, "articles")), None)
        if head is None:
            return named
        end = 5 + len(m["thing"])
        spans = (
            KeywordSpan(0, 4, Kind.ACTION, "Take"),
            KeywordSpan(head.start, end, Kind.TARGET, text[head.start : end]),
        )
        trial = self.fork()
        before, had = trial.errors(), set(trial.ledger.pending)
        trial.step(LabelledStep(step.number, text, spans, 1.0))
        taken = tuple(i for i in trial.ledger.pending if i not in had)
        return taken if trial.errors() <= before else ()

    def remarked(self, *, forbidden: bool) -> None:
        """ "The milk is on the shelf. | Grab it": what a remark was about is what "it" means."""
        if self.mentioned and not forbidden and not self.ledger.pending:
            self.targets = (self.mentioned, self.turn)

    def spoken_of(self) -> bool:
        """Whether "it" means something already."""
        return bool(self.talk().targets or self.ledger.pending)

    def overlooked(self, step: LabelledStep, earlier: int, *, asks: bool) -> None:
        """Complain of what the step names or tells and no clause made anything of. `earlier` diagnostics are not of
        this step; `asks`: it is an order."""
        spans = [d.span for d in self.diagnostics[earlier:] if d.span is not None]
        faulty = [Extent(s.column - 1, s.end_column - 1) for s in spans]
        for fault in lacking(step, self.scene, faulty):
            self.fault(fault)
        for extent in unread(step, self.scene, self.used):
            if self.stands_at(step, extent):
                continue
            words = extent.cut(step.text)
            self.complain(
                "E314", f"`{words}` is named, and what for is not understood", extent, "", "say it in a step of its own"
            )
        for extent in goes_unread(step, self.scene):
            title = f"`{extent.cut(step.text)}` is told, and no step does it"
            self.complain("E314", title, extent, "", "say it in a step of its own")
        for extent, thing, place in done_before(step, self.scene):
            if not self.scene.within(self.ledger.where.get(thing), place):
                title = f"`{extent.cut(step.text)}` is told, and no step does it"
                self.complain("E314", title, extent, "", "say it in a step of its own")
        for extent in doubts(step, self.scene) if asks else ():
            title = f"`{extent.cut(step.text)}` leaves open whether it is to be done"
            self.complain("E314", title, extent, "", "say what is to be done")
        for extent in restrictions(step) if asks else ():
            title = f"`{extent.cut(step.text)}` restricts what may be done, which goals cannot say"
            self.complain("E314", title, extent, "", "say which thing is to go where")

    def stands_at(self, step: LabelledStep, extent: Extent) -> bool:
        """Whether words right behind an object say where it stands ("the red block (object 6) in the sorting area")."""
        before = [t.text for t in tokens(step.text[: extent.start]) if not lexicon().is_(t.text, "articles")]
        found = resolve_places(tokens(extent.cut(step.text)), self.scene, Talk())
        if not before or not lexicon().is_(before[-1], "at", "from") or not isinstance(found, Found):
            return False
        there = {self.ledger.where.get(i) for i in mentioned_in(step.text[: extent.start], self.scene)}
        return len(found.ids) == 1 and any(self.scene.within(p, found.ids[0]) for p in there)

    def names_both(self, step: LabelledStep) -> bool:
        """Whether a step without keywords names a thing and a place by their numbers."""
        parts = tokens(step.text)
        pairs = [(a, b) for a, b in pairwise(parts) if b.number is not None and a.word]
        quiet = Talk()
        return any(isinstance(resolve_objects(p, self.scene, quiet), Found) for p in pairs) and any(
            isinstance(resolve_places(p, self.scene, quiet), Found) for p in pairs
        )

    def names_mover(self, step: LabelledStep) -> bool:
        """Whether a step without keywords begins with a thing and says that it goes or is to go somewhere."""
        parts = tokens(step.text)
        at = next((i for i, t in enumerate(parts[:8]) if t.text in _GOING), 0)
        return at > 0 and isinstance(resolve_objects(parts[:at], self.scene, Talk()), Found)

    def orders_within(self, text: str, start: int, end: int) -> bool:
        """Whether behind a comma or an "and" of these words a verb of the library stands: an order that was missed."""
        pairs = pairwise(tokens(text, start, end))
        heads = (b.text for a, b in pairs if a.text in {",", ";"} or lexicon().is_(a.text, "joints"))
        return any(v.templates and not v.corrected for v in (read_verb(w, (), self.scene.library) for w in heads))

    def newly(self, other: _Walker) -> str:
        """The goals that another walker has and this one has not."""
        known = {e.condition for e in self.ledger.goals}
        return ", ".join(str(e.condition) for e in other.ledger.goals if e.condition not in known) or "nothing"

    def unsure(self, step: LabelledStep, trials: Sequence[Trial[_Walker]] = ()) -> None:
        """E306: the words, and what they may come to."""
        if not step.spans:
            self.complain("E306", f"step {step.number} is not understood", Extent(0, len(step.text)), "do what?")
            return
        worst = min(step.spans, key=lambda s: s.confidence)
        names = [e.id for e in (*self.scene.objects, *self.scene.places)]
        vocabulary = self.scene.library.verbs if worst.label == "Action" else names
        near = nearest(worst.text[:60], vocabulary)
        read = "; ".join(f"{s.label}: {s.text[:60]}" for s in step.spans[:8])
        label = f"{certainty(step):.2f} is below {self.threshold:.2f}; read as {read}"
        if trials:
            shared = shares(trials, self.newly)
            read = "; ".join(f"{words} ({p:.2f})" for words, p in shared[:3])
            label = f"{shared[0][1]:.2f} is not enough; read as {read}"
        hint = f"nearest: {', '.join(near)}; " if near else ""
        self.complain(
            "E306",
            f"step {step.number} is not understood with enough certainty",
            Extent(worst.start, worst.end),
            label,
            hint + ("the step is left out" if self.partial else "say it in simpler words"),
            candidates=near,
            severity=Severity.WARNING if self.partial else Severity.ERROR,
        )
        self.lost = True
        self.targets = ((), -9)

    def result(self) -> ParseResult:
        for entry in self.ledger.settle():
            self.complain(
                "E305",
                f"{entry.target} is picked up and never put anywhere",
                entry.extent,
                "where is it to go?",
                f"did you mean {self.ledger.carried}?" if self.ledger.carried else "name the place",
                candidates=(self.ledger.carried,) if self.ledger.carried else (),
                step=entry.step,
            )
        for entry in self.ledger.goals:
            times = self.ledger.moved[str(entry.target)]
            if times >= _OFTEN:
                self.complain(
                    "W322", f"{entry.target} is moved {times + 1} times", entry.extent, "only the last place stands",
                    "is that what is meant?", severity=Severity.WARNING, step=entry.step,
                )  # fmt: skip
        seen: dict[Condition, Entry] = {}
        for entry in self.ledger.goals:
            seen.setdefault(entry.condition, entry)
        goals = tuple(e.goal() for e in seen.values())
        if not goals and not any(d.severity is Severity.ERROR for d in self.diagnostics):
            self.now = LabelledStep(0, "")
            told = "; ".join(n.text for n in self.notes[:3])
            self.complain("E340", "no step asks for anything that changes the scene", Extent(-1, -1), "", told)
        notes = (*self.notes, *self.ledger.notes)
        moves = tuple(
            Move(e.target, e.place, e.goal(), e.note is not None)
            for e in self.ledger.moves
            if e.target is not None and e.place is not None
        )
        return ParseResult(goals, tuple(sorted(notes, key=lambda n: n.step_number)), tuple(self.diagnostics), moves)
