"""The paper's text filter: of a reply, the steps are kept, and greetings, explanations and closing remarks
dropped.

Contract: any text comes in; a `Steps` with at least one step, or a `Question`, comes out, or diagnostics.
Time is linear in the length of the reply, which is bounded.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from llmbt_compiler.reasoning.layout import Item, Kind, View, joined, json_items, lay_out, view
from llmbt_compiler.reasoning.prompt import clean
from llmbt_compiler.reasoning.steps import Dropped, Question, Step, Steps
from llmbt_compiler.reasoning.wording import (
    Sense,
    Sort,
    asks,
    assigns,
    commanded,
    dangles,
    is_side_heading,
    overrides,
    references,
    sense,
    tells_of_places,
)
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span

__all__ = ["MAX_REPLY_CHARS", "MAX_STEPS", "filter_steps"]

MAX_REPLY_CHARS = 60_000
MAX_STEPS = 200
MAX_STEP_CHARS = 1_000
_NAME = 4
"""Words that the name of a thing has at most, in a heading."""
ANEW = "record the reply again (--record --replace), or write one by hand: llmbt cassette author"

_QUESTION = re.compile(r"^[ \t>*_#`~-]*QUESTION\b[ \t*_]*:[ \t*_]*", re.IGNORECASE | re.MULTILINE)
_SENTENCE_END = re.compile(
    r"[.!?][\"'”)\]]*(?:\s+(?=[\"'“(\[]?[A-Z0-9])|\s*$)|\n(?=[\"'“(\[]?[A-Z])|"
    r"\n(?=[a-z]+[ _]#?\d+\s*(?::|→|->|=>))|;\s+"
)
_ABBREVIATION = re.compile(r"\b(?:e\.g|i\.e|etc|approx|no|nr|pos|fig|vs|cf)\.$", re.IGNORECASE)
_THEN = re.compile(r"\s*[,;]\s+(?:and\s+)?(?=then\b)|\s+(?=and then\b)", re.IGNORECASE)
_ARROW = re.compile(r"\s*(?:→|⇒|->|=>)\s*(?=[A-Za-z])")
_OPEN = re.compile(
    r"\W*[a-z]+(?:\s+(?:up|down|over|back))?\s+(?:from|off|on|onto|in|into|to|at|it|them)\b|.*\bthere\b",
    re.IGNORECASE | re.DOTALL,
)
"""A command that leaves out what it is about, or where: its heading says it."""
_STUMP = re.compile(r"[.!?:;)][ \t]*[\r\n]\s*\d{1,3}[.)]?\s*\Z")
_ON_NUMBER = re.compile(
    r"\b(?:on|onto|in|into|to|at|over)\s+(?:\w+\s+){0,3}?(?:\w*[ _-]?\d+|\w*\d+-?[A-Za-z]|[a-z]+[ _-][A-Z]{1,3})$"
)
_WHERE_TO = re.compile(r"\b(?:on|onto|into|in|to|at|upon)\s", re.IGNORECASE)
_ONE_THING = re.compile(r"(?:it|they|\w+[ _]#?\d+)\b", re.IGNORECASE)
_TRAILING = re.compile(r"(?:\s*[,;]?\s*\band|[,;\s]+)$", re.IGNORECASE)
_BREAKS_OFF = re.compile(r"[^\s.!?:]\x20+\Z")
"""A model ends its words with a mark or a line break; a space waits for the next one."""
_ENDED = re.compile(r"[.!?:;][\"'”)\]]*$")


@dataclass(frozen=True, slots=True)
class _Found:
    """A sentence that may be a step: its text, what it is, and its number in the reply."""

    view: View
    sort: Sort
    number: int | None = None


def filter_steps(reply: str, source: str = "reply.json") -> Steps | Question:
    """The steps of a reply, or the question it asks.

    Errors: E110 empty, E111 too long, E112 no text (binary), E113 nothing but markup, E114 no steps in it,
    E115 it tells its reader to set rules aside, E116 it stops in the middle, E117 a number is missing in its
    list, E118 too many steps, E119 a question without words.
    """
    text = _Reply(reply, source)
    _check_text(text)
    question = _asked(text)
    if question is not None:
        return question
    items = json_items(reply)
    structured = items is not None
    if items is None:
        items = lay_out(reply)
    if structured and len(items) == 1 and items[0].kind is Kind.HEADING:
        return text.question(items[0].view)
    if not any(re.search(r"\w", i.view.text) for top in items for i in top.all()):
        raise text.fault("E113", "the reply has markup and no words")
    told = overrides(reply)
    if told is not None:
        raise text.fault(
            "E115",
            "the reply tells its reader to set rules aside instead of giving steps",
            *told.span(),
            help_="look where these words come from: a name in the scene, the request or the recording",
        )
    kept, dropped = _select(items, structured)
    if not kept:
        implied = next((s for s in _sentences_of(items) if asks(s.text)), None)
        if implied is not None:
            return text.question(implied)
        if _cut_json(reply):
            raise text.fault("E116", "the reply is JSON that stops in the middle")
        raise text.fault("E114", "no steps in the reply", 0, min(len(reply), 80))
    if len(kept) > MAX_STEPS:
        first = kept[MAX_STEPS].view
        raise text.fault(
            "E118",
            f"the reply has {len(kept)} steps, more than {MAX_STEPS}",
            first.start,
            first.end,
            help_="ask for less at once",
        )
    _check_whole(text, items, kept)
    return Steps(tuple(_step(text, f, i) for i, f in enumerate(kept, 1)), tuple(dropped[:MAX_STEPS]))


# --- checks of the reply as a text --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Reply:
    """The reply and the name it goes by in diagnostics."""

    text: str
    source: str

    def position(self, at: int) -> tuple[int, int, str]:
        """Line and column, from 1, and the line itself; \\n, \\r\\n and \\r all end one."""
        breaks = list(re.finditer(r"\r\n|\r|\n", self.text[:at]))
        begin = breaks[-1].end() if breaks else 0
        rest = re.compile(r"[\r\n]|\Z").search(self.text, begin)
        line = self.text[begin : rest.start() if rest else len(self.text)]
        return len(breaks) + 1, at - begin + 1, "".join(c if c.isprintable() else " " for c in line[:200])

    def fault(self, code: str, title: str, start: int = 0, end: int = 0, *, help_: str = ANEW) -> LlmbtError:
        """A diagnostic about a part of the reply."""
        line, column, text = self.position(start)
        width = max(1, min(end - start, len(text) - column + 1))
        span = Span(self.source, line, column, column + width, text)
        return LlmbtError(Diagnostic(code, title, span if column <= 200 else Span(self.source, line), help=help_))

    def question(self, asked: View) -> Question:
        """A sentence as what the reply asks."""
        text = clean(asked.text, MAX_STEP_CHARS)
        return Question(text, asked.start, asked.end, self.position(asked.start)[0])


def _check_text(reply: _Reply) -> None:
    size = len(reply.text)
    odd = len(re.findall("[\x00-\x08\x0e-\x1f\x7f-\x84\x86-\x9f\ufffd]", reply.text))
    code, title = "", ""
    if size > MAX_REPLY_CHARS:
        code, title = "E111", f"the reply has {size} characters, more than {MAX_REPLY_CHARS}"
    elif not reply.text.strip():
        code, title = "E110", "the reply is empty"
    elif "\x00" in reply.text or (odd > 3 and odd * 50 > size):
        code, title = "E112", f"the reply is no text: {odd} of its {size} characters are not"
    if code:
        raise LlmbtError(Diagnostic(code, title, Span(reply.source), help=ANEW))


def _asked(reply: _Reply) -> Question | None:
    """A line that begins with QUESTION:, to the end of its paragraph."""
    found = _QUESTION.search(reply.text)
    if found is None:
        return None
    end = re.compile(r"\r?\n\s*\r?\n|\Z").search(reply.text, found.end())
    said = view(reply.text, [(found.end(), end.start() if end else len(reply.text))])
    if not re.search(r"\w", said.text):
        raise reply.fault("E119", "the reply asks a question without words", *found.span())
    return reply.question(said)


def _cut_json(reply: str) -> bool:
    body = re.sub(r"\A\s*(?:```|~~~)\w*\s*", "", reply)
    return body[:1] in ("[", "{") and body.rstrip("`~ \n\r")[-1:] not in ("]", "}")


def _check_whole(reply: _Reply, items: list[Item], kept: list[_Found]) -> None:
    """E116, E117: the end is there, and so is every number of the list."""
    last = kept[-1].view
    if not reply.text[last.end :].strip(" \t\r\n*_`~\"')]}") and _is_cut([f.view.text for f in kept]):
        raise reply.fault("E116", "the reply stops in the middle of its last step", last.start, last.end)
    if _BREAKS_OFF.search(reply.text):
        raise reply.fault("E116", "the reply stops in the middle of a line", last.start, last.end)
    end = items[-1]
    stump = end.kind is Kind.NUMBER and not end.children and (end.view.start > last.end or not end.view.text)
    if _STUMP.search(reply.text) or (stump and not _ENDED.search(end.view.text)):
        at = len(reply.text.rstrip())
        raise reply.fault("E116", "the reply stops where its last step begins", at - 1, at)
    previous, stride = 0, 0
    for item in items:
        if item.kind is Kind.NUMBER and item.number is not None:
            number, jump = item.number, item.number - previous
            if jump > 1 and jump != stride:
                after = f"{number} follows {previous}" if previous else f"the first is {number}"
                title = f"step {previous + 1} is missing: {after}"
                raise reply.fault("E117", title, item.view.start, item.view.end)
            previous, stride = number, jump


# --- what is kept -------------------------------------------------------------------------------------------


def _select(items: list[Item], structured: bool) -> tuple[list[_Found], list[Dropped]]:
    """The sentences that are steps, in their order, and those that are not."""
    groups = _groups(items)
    listed = [(side, group) for side, kind, group in groups if kind != Kind.PROSE]
    steps = {id(g): _of_list(g) for _, g in listed}
    good = {i for i, found in steps.items() if any(f.sort.sense is Sense.ACTION for f in found)}
    if not good:  # verbs that nobody knows: let the parser complain about them
        good = {i for i, found in steps.items() if any(f.sort.sense is Sense.UNKNOWN for f in found)}
    if not good:
        good = {i for i, found in steps.items() if found}
    main = {id(g) for side, g in listed if not side and id(g) in good} or good
    numbered = any(id(g) in main and any(i.kind is Kind.NUMBER for i in g) for _, g in listed)
    kept: list[_Found] = []
    for side, kind, group in groups:
        if kind == Kind.PROSE:
            kept += [] if side else _of_prose(group, beside_list=bool(main))
        elif id(group) in main:
            found = steps[id(group)]
            loose = numbered and not any(i.kind in (Kind.NUMBER, Kind.ROW) for i in group)
            kept += [f for f in found if not loose or (f.sort.sense is Sense.ACTION and references(f.view.text))]
    if any(f.sort.sense is Sense.ACTION for f in kept):
        kept = [
            f
            for f in kept
            if f.sort.sense is not Sense.PASSIVE or f.number is not None or f.sort.led or assigns(f.view.text)
        ]
    if not structured and not main and any(not f.sort.first_person for f in kept):
        kept = [f for f in kept if not f.sort.first_person or commanded(f.view.text) is not None]
    return kept, _dropped(items, kept)


def _groups(items: list[Item]) -> list[tuple[bool, Kind, list[Item]]]:
    """Runs of list items and of prose; a list that begins again at 1 is another. The flag: it stands under a
    heading like `Notes`, and is said around the steps. Items in a fence count only where nothing stands
    outside."""
    groups: list[tuple[bool, Kind, list[Item]]] = []
    outside = any(not i.fenced and i.kind in (Kind.NUMBER, Kind.ROW) for i in items)
    side, fresh, last_number = False, True, 0
    for item in items:
        if item.kind is Kind.HEADING:
            side, fresh = is_side_heading(item.view.text), True
            groups.append((side, Kind.PROSE, [item]))
            continue
        if item.fenced and outside:
            continue
        kind = Kind.PROSE if item.kind is Kind.PROSE else Kind.NUMBER
        if kind is Kind.PROSE:
            title = item.view.text.rstrip()
            side = is_side_heading(title) if title.endswith(":") else side and not fresh
        again = item.number is not None and item.number <= 1 < last_number
        last_number = item.number if item.number is not None else last_number
        if fresh or not groups or groups[-1][1] is not kind or again:
            groups.append((side, kind, []))
        groups[-1][2].append(item)
        fresh = False
    return groups


def _is_cut(steps: list[str]) -> bool:
    """Whether the last of these stops in the middle. One that only lacks the full stop of the others does not: it
    ends as another does, or on a numbered place (of which the map will tell whether it is one)."""
    *others, last = steps
    if dangles(last):
        return True
    if not others or _ENDED.search(last) or not all(_ENDED.search(o) for o in others):
        return False
    endings = {_ending(o) for o in others}
    return _ending(last) not in endings and _ON_NUMBER.search(last[-80:]) is None


def _ending(step: str) -> str:
    return re.sub(r"\d+", "#", " ".join(step.rstrip(" .!?:;").split()[-2:])).lower()


def _of_list(items: Iterable[Item]) -> list[_Found]:
    found: list[_Found] = []
    for item in items:
        found += _of_row(item) if item.kind is Kind.ROW else _of_item(item, item.number)
    return found


def _of_item(item: Item, number: int | None) -> list[_Found]:
    """The steps of a list item: its own sentences, or those under it where the item is only their heading."""
    own = _own(item.view, number)
    below: list[_Found] = []
    for child in item.children:
        below += _of_item(child, number if child.number is None or item.kind is Kind.NUMBER else child.number)
    below = [f for f in below if f.sort.sense in (Sense.ACTION, Sense.UNKNOWN)]
    if below and own and not any(f.sort.sense is Sense.ACTION for f in own):
        below = _headed(_trim(item.view), below)
    acts_below = [f for f in below if f.sort.sense is Sense.ACTION]
    if not below:
        heading = item.view.text.rstrip().endswith(":") and not references(item.view.text)
        return [] if heading else own
    if not own or (acts_below and not any(f.sort.sense is Sense.ACTION for f in own)):
        return acts_below or below
    if not acts_below:
        return own
    ours = frozenset[tuple[str, str]]().union(*(references(f.view.text) for f in own))
    theirs = frozenset[tuple[str, str]]().union(*(references(f.view.text) for f in acts_below))
    if theirs <= ours and ours:
        return own
    if ours <= theirs or item.view.text.rstrip().endswith(":") or item.view.bold >= len(item.view.text) - 1:
        return acts_below
    return own + acts_below


def _own(whole: View, number: int | None) -> list[_Found]:
    """The steps of an item's own text: `**head**: tail` is looked at in both parts."""
    head, tail = _head_and_tail(whole)
    if head is None or tail is None:
        return _acts(whole, number)
    heads = _acts(head, number)
    acts = [f for f in _acts(tail, number) if f.sort.sense is Sense.ACTION]
    if not acts:
        explains = heads and (whole.bold or sense(tail.text).sense is not Sense.UNKNOWN) and not assigns(whole.text)
        return heads if explains else _acts(whole, number)
    ours, theirs = references(head.text), frozenset().union(*(references(f.view.text) for f in acts))
    if not any(f.sort.sense is Sense.ACTION for f in heads):
        return _headed(head, acts)
    if ours < theirs:
        return acts
    if theirs < ours or (ours == theirs and (ours or len(head.text.split()) > 2)):
        return heads
    return acts if ours == theirs else heads + acts


def _headed(head: View, acts: list[_Found]) -> list[_Found]:
    """The first command with its heading before it, where it needs that to be understood ("Potato chips: pick up from
    the table"); a heading that is longer than a name stays away."""
    first, *rest = acts
    if len(head.text.split()) > _NAME or not _OPEN.match(first.view.text):
        return acts
    return [replace(first, view=_joined_by_colon(head, first.view)), *rest]


def _joined_by_colon(head: View, text: View) -> View:
    """Both, with a colon that stands for whatever parts them in the reply."""
    mark = View(":", head.origin[-1:])
    return View(f"{head.text}: {text.text}", (*head.origin, *mark.origin, *mark.origin, *text.origin))


def _head_and_tail(whole: View) -> tuple[View | None, View | None]:
    """An item parted at its colon, or where its leading bold ends; a short head only."""
    text = whole.text
    if 0 < whole.bold < len(text):
        cut = whole.bold
        after = re.compile(r"\s*(?::|[-–—]\s|\.?\s*\n)?\s*").match(text, cut)
        rest = after.end() if after else cut
        marked = text[:cut].rstrip().endswith((":", ".")) or rest - cut > 1 or text[cut : cut + 1] == ":"
        if marked and rest < len(text):
            return _trim(whole.part(0, cut)), whole.part(rest, len(text))
        return None, None
    colon = text.find(": ")
    if colon > 0 and len(text[:colon].split()) <= 8 and "." not in text[:colon]:
        return whole.part(0, colon), whole.part(colon + 1, len(text))
    return None, None


def _trim(head: View) -> View:
    return head.part(0, len(head.text.rstrip(" :–—-")))


def _acts(whole: View, number: int | None) -> list[_Found]:
    """The sentences of a listed text that may be steps; the first decides, further ones only where they
    act."""
    found: list[_Found] = []
    for sentence in (part for s in _sentences(whole) for part in _by_arrows(s)):
        sort = sense(sentence.text)
        if sort.sense in (Sense.UNKNOWN, Sense.PASSIVE, Sense.EXPLANATION) and found:
            if assigns(sentence.text) and _ONE_THING.match(sentence.text):
                found.append(_Found(sentence, sort, number))
            continue
        if sort.sense in (Sense.ACTION, Sense.UNKNOWN, Sense.PASSIVE) or assigns(sentence.text):
            found.append(_Found(sentence.part(sort.cut, len(sentence.text)), sort, number))
    return found


def _by_arrows(sentence: View) -> list[View]:
    """ "Pick up object 1 → place on position 21" has two steps, if what stands on each side is one."""
    text = sentence.text
    cuts = [0, *(e for m in _ARROW.finditer(text) for e in m.span()), len(text)]
    parts = [sentence.part(a, b) for a, b in zip(cuts[::2], cuts[1::2], strict=True)]
    return parts if all(p.text and sense(p.text).sense is Sense.ACTION for p in parts) else [sentence]


def _of_row(item: Item) -> list[_Found]:
    """A table row, or an entry of JSON: the cell that is an instruction, else the cells one after the
    other."""
    if not item.children and len(item.pieces) > 1:
        cells = [c for c in _cells(item) if c.text]
        acts = [c for c in cells if sense(c.text).sense is Sense.ACTION and len(c.text.split()) > 1]
        if acts:
            best = max(acts, key=lambda c: (len(references(c.text)), len(c.text)))
            if references(best.text) or not any(references(c.text) for c in cells):
                return _acts(best, item.number)
        return _acts(joined(cells), item.number)
    return _acts(item.view, item.number)


def _cells(item: Item) -> list[View]:
    cells: list[View] = []
    at = 0
    for start, end in item.pieces:
        size = sum(1 for o in item.view.origin[at:] if start <= o < end and o >= start)
        while at < len(item.view.text) and item.view.origin[at] < start:
            at += 1
        cells.append(item.view.part(at, at + size))
        at += size
    return cells


def _of_prose(items: Iterable[Item], *, beside_list: bool) -> list[_Found]:
    """Steps told as prose. Beside a list only what plainly goes on with it: `Finally, place object 6 on
    ...`."""
    found: list[_Found] = []
    for item in items:
        if item.kind is Kind.HEADING and (beside_list or item.view.text.rstrip().endswith(":")):
            continue
        for sentence in _sentences(item.view):
            if sentence.text.rstrip().endswith((":", "?")):
                continue
            for part in _clauses(sentence):
                sort = sense(part.text)
                if not beside_list and sort.sense is not Sense.ACTION:
                    found += _told_in_prose(part, sort)
                    continue
                plain = sort.sense is Sense.ACTION and not (beside_list and sort.first_person)
                if plain and (not beside_list or (sort.led and references(part.text))):
                    found.append(_Found(part.part(sort.cut, len(part.text)), sort))
    return found


def _told_in_prose(part: View, sort: Sort) -> list[_Found]:
    """A sentence of a reply without a list that does not plainly begin with its verb: a step where a command stands
    behind what leads up to it, where it says where something is to go, or where it speaks of handling numbered
    things. Only what has none of these is said around the steps."""
    text = part.text
    at = commanded(text)
    if at is not None:
        return [_Found(part.part(at, len(text)), replace(sort, sense=Sense.ACTION, cut=at, first_person=False))]
    if sort.sense in (Sense.CONDITION, Sense.PROHIBITION, Sense.EMPTY, Sense.REMARK):
        return []
    led = sort.led and bool(references(text)) and sort.sense is not Sense.EXPLANATION
    led = led or (sort.led and sort.sense is Sense.UNKNOWN)
    unknown = sort.sense is Sense.UNKNOWN and _is_told_where(text)
    if led or unknown or assigns(text) or tells_of_places(text):
        return [_Found(part.part(sort.cut, len(text)), sort)]
    return []


def _is_told_where(text: str) -> bool:
    return len({noun for noun, _ in references(text)}) > 1 and _WHERE_TO.search(text) is not None


def _sentences_of(items: list[Item]) -> Iterable[View]:
    for top in items:
        for item in top.all():
            yield from _sentences(item.view)


def _sentences(whole: View) -> list[View]:
    cuts = [0]
    for match in _SENTENCE_END.finditer(whole.text):
        stop = match.end()
        if not _ABBREVIATION.search(whole.text, max(0, match.start() - 8), match.start() + 1):
            cuts.append(stop)
    cuts.append(len(whole.text))
    parts = (whole.part(a, b) for a, b in itertools.pairwise(cuts))
    return [p for p in parts if p.text]


def _clauses(sentence: View) -> list[View]:
    """`Pick up object 1, then place it ...` has two steps, if what follows is one."""
    text = sentence.text
    ends = (m.end() for m in _THEN.finditer(text))
    cuts = [0, *(e for e in ends if sense(text[e:]).sense is Sense.ACTION), len(text)]
    parts = [sentence.part(a, b) for a, b in itertools.pairwise(cuts)]
    return [p.part(0, len(_TRAILING.sub("", p.text))) for p in parts if p.text]


def _step(reply: _Reply, found: _Found, place: int) -> Step:
    shown = found.view
    if len(shown.text) > MAX_STEP_CHARS:
        shown = shown.part(0, MAX_STEP_CHARS)
    runs: list[tuple[int, int]] = []
    for i, o in enumerate(shown.origin):
        if not runs or o - i != runs[-1][1] - runs[-1][0]:
            runs.append((i, o))
    line, column, _ = reply.position(shown.start)
    text = shown.text.replace("\n", " ")
    number = found.number if found.number is not None else place
    return Step(number, text, shown.start, shown.end, line, column, tuple(runs))


def _dropped(items: list[Item], kept: list[_Found]) -> list[Dropped]:
    """The sentences of which no part is kept."""
    taken = sorted((f.view.start, f.view.end) for f in kept)
    found: list[Dropped] = []
    i = 0
    for sentence in sorted(_sentences_of(items), key=lambda s: (s.start, s.end)):
        while i < len(taken) and taken[i][1] <= sentence.start:
            i += 1
        if i < len(taken) and taken[i][0] < sentence.end:
            continue
        why = sense(sentence.text).sense
        if why is Sense.EMPTY:
            continue
        reason = why.value if why not in (Sense.ACTION, Sense.UNKNOWN, Sense.PASSIVE) else "said beside the steps"
        found.append(Dropped(sentence.text.replace("\n", " ")[:200], sentence.start, sentence.end, reason))
    return found
