"""What a sentence of a reply is: an instruction, or something said around the instructions.

Words alone, no library: a verb that no library has must get through, so that it is complained about where it
counts.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum

__all__ = [
    "Sense",
    "Sort",
    "asks",
    "assigns",
    "commanded",
    "dangles",
    "is_side_heading",
    "overrides",
    "references",
    "sense",
    "tells_of_places",
]

_VERBS = frozenset(
    """
    pick grasp grab take lift fetch get collect retrieve seize grip hold clutch place put set move
    transfer stack sort arrange position lay deposit store bring carry relocate shift deliver load
    unload transport stow return swap exchange switch clear remove empty release drop recover go
    navigate drive walk travel proceed approach reach open close wait check verify ensure confirm
    inspect find locate identify scan detect wipe clean pour fill turn rotate push pull slide press
    insert unscrew screw cut mix stir serve hand give offer pass throw align lower raise repeat continue
    start begin stop tidy organize organise group distribute separate unstack pile line reposition
    rearrange restore replace leave keep make perform execute use select choose let free
    """.split()  # noqa: SIM905  (a list of this length reads best as text)
)
_NOUNS = "place position stack store hold grip pass hand load turn lift move return cut line group drop start stop"
_NOUN_SUBJECT = re.compile(
    rf"(?:{_NOUNS.replace(' ', '|')})s?\b(?:\s+(?:\d+|[a-z]|\w*_\w+))?\s+(?:is|are|was|were|has|have|will|"
    rf"should|must)\b",
    re.IGNORECASE,
)
_CONNECTIVE = re.compile(
    r"(?:(?:first(?:ly| of all)?|second(?:ly)?|third(?:ly)?|fourth(?:ly)?|fifth|sixth|seventh|eighth|then|"
    r"next|now|"
    r"finally|lastly|last|afterwards?|after that|after this|subsequently|once (?:done|that is done|finished)|"
    r"to (?:begin|start)(?: with)?|following this|also|similarly|likewise|again|and|so|please|simply|just|"
    r"in (?:the same way|addition))\b\s*[,:;–—-]?\s+)",
    re.IGNORECASE,
)
_LABELLED = re.compile(r"\([^()]{1,40}\)\s+(?=\w)")
_ADVERB = re.compile(r"(?:very\s+)?[a-z]{2,}ly,?\s+", re.IGNORECASE)
_SUBJECT = re.compile(
    r"(?:you|we|i|the (?:robot(?: arm)?|arm|manipulator|gripper|system)|robot|let us|let['’]s|"
    r"it)(?:['’](?:ll|d|m))?\s+"
    r"(?:(?:will|should|can|must|need to|needs to|have to|has to|would|shall|may|could|are going to|"
    r"is going to|"
    r"am going to|going to)\s+)?(?:(?:then|now|first|next|also|finally)\s+)?",
    re.IGNORECASE,
)
_FIRST_PERSON = re.compile(r"(?:i|we)\b", re.IGNORECASE)
_CLAUSE = re.compile(r"(?:after|once|when|as soon as|before|while|having)\b[^,.;\n]{1,120},\s*", re.IGNORECASE)
_LEAD = re.compile(r"(?:using|with|from|by|to|in|on|at|for|starting)\b[^,.;:\n]{1,120}[,:]\s*", re.IGNORECASE)
_CONDITION = re.compile(
    r"(?:if|unless|in case|should (?:the|any|an?)|whenever|otherwise|optionally|alternatively)\b",
    re.IGNORECASE,
)
_NEGATION = re.compile(
    r"(?:do not|don['’]t|never|avoid|refrain|no need|there is no need|make sure not|be careful not|not)\b",
    re.IGNORECASE,
)
_STAYS = re.compile(
    r"(?:leave|keep)\b.{0,80}\b(?:where (?:it is|they are)|in place|untouched|as (?:is|it is|they are)|"
    r"unchanged|alone|"
    r"(?:its|their) (?:current|original) (?:place|position|location)s?)\b",
    re.IGNORECASE,
)
_REMARK = re.compile(
    r"(?:sure|certainly|of course|hello|hi|hey|greetings|okay|ok|great|absolutely|alright|all right|"
    r"understood|got it|"
    r"thanks?|thank you|no problem|let me know|let me|feel free|i hope|hope|please (?:let|note|confirm|be|"
    r"feel)|note|"
    r"enjoy|good luck|in (?:summary|conclusion|short|total)|to summari[sz]e|summary|that['’]?s (?:it|all)|"
    r"these (?:steps|are)|the following|as requested|by following|following these|remember|keep in mind|"
    r"below|"
    r"happy to|glad|here (?:is|are|['’]s)|here['’]s|if you|is there|would you like|do you|can i|shall i|"
    r"warning|tip|"
    r"important|disclaimer|best regards|regards|cheers|you['’]re welcome|have a|with this|done|all done|"
    r"after these|"
    r"once (?:all|these|every|complete)[^,]{0,60}, (?:the|all|your|every|you)\b|continue this|"
    r"(?:steps?|plan|instructions?|solution|answer|output|result)\s*:?\s*$)\b",
    re.IGNORECASE,
)
_STATEMENT = re.compile(
    r"(?:the|this|that|these|those|it|its|there|they|he|she|all|each|every|both|some|any|my|your|our|as|"
    r"because|since|"
    r"so that|thus|therefore|hence|which|where|why|how|what|who|no|yes|none|everything|nothing|result|goal|"
    r"reason|"
    r"explanation|purpose|note|an?)\b|(?:\w+\s+){0,3}\w+\s+(?:is|are|was|were|has been|have been|has|have)\b",
    re.IGNORECASE,
)
_PASSIVE = re.compile(
    r".{1,80}?\b(?:(?:should|must|will|can|needs? to|has to|have to) )?(?:be |is |are |gets? |goes |go |"
    r"belongs? )"
    r"(?:\w+ed |put |set )?(?:on|onto|to|in|into|at|by)\b",
    re.IGNORECASE,
)
_LONG = 500
"""Characters of a sentence that are looked at for a command."""
_HANDLING = frozenset(
    """
    pick grasp grab take lift fetch get collect retrieve seize grip hold put place set move transfer stack
    sort arrange position lay deposit store bring carry relocate shift deliver load transport stow return swap
    exchange switch clear remove release drop insert slide push pull hand give distribute group
    """.split()  # noqa: SIM905  (a list of this length reads best as text)
)
_IDIOM = re.compile(
    r"(?:tak(?:e|ing) (?:a (?:look|moment)|note|care|place|the following|these)|get(?:ting)? (?:started|to work|going)|"
    r"hold(?:ing)? on|mov(?:e|ing) on|put(?:ting)? (?:it )?(?:differently|simply|together))\b",
    re.IGNORECASE,
)
_NUMBERED_NOUN = re.compile(
    r"(?:position|place|stack|group|line|level)s?[ _]#?\d+\w*\s*(?:$|[.,:;)\]→=<-]|(?:gets?|receives?|takes?|holds?|"
    r"is|are|"
    r"on|in|of|for|and|will|should|must|has|to|at)\b)",
    re.IGNORECASE,
)
_INTERJECTION = re.compile(
    r"(?:sure(?: thing)?|certainly|of course|okay|ok|alright|all right|absolutely|great|yes|no problem|understood|"
    r"got it|"
    r"right|well|hello|hi|hey)\b(?: there)?\s*[,!:;–—-]+\s*",
    re.IGNORECASE,
)
_ADVICE = re.compile(
    r"(?:(?:i|we)(?:['’]d|\s+would|\s+can|\s+could)?\s+(?:suggest|recommend|advise|propose|start|begin)(?:\s+off)?\s+"
    r"(?:(?:that|you|we|to|by|with|the robot|should)\s+)*|"
    r"(?:the|your|my|our|a)\s+(?:\w+\s+){0,2}?(?:step|move|action|thing|suggestion|recommendation|advice|"
    r"proposal)(?:\s+to do)?\s+(?:is|would be|will be)\s+"
    r"(?:to\s+)?|"
    r"(?:what|all) (?:you|we|the robot) (?:need|needs|have|has|should|must|"
    r"can)?\s*(?:to )?do(?:es)? is\s*:?\s+(?:to\s+)?|"
    r"(?:you|we|i|one|the robot|robot|the arm)(?:['’](?:ll|d|ve))?\s+(?:(?:will|would|may|might|just|only|simply|"
    r"first|then|"
    r"also|now|next|can|could|should|must|has|have|is|are|am|is then|got)\s+)*(?:(?:want|wants|like|need|needs|have|"
    r"has|ought|"
    r"are|is|am|got|going|supposed|better)\s+(?:to\s+)?)?(?:(?:first|then|now|next|also|simply|just)\s+)*|"
    r"(?:it is|it['’]s|it would be|it will be)\s+(?:best|good|easiest|necessary|time|better|important|possible|"
    r"sensible)\s+"
    r"to\s+|"
    r"(?:go ahead and|(?:be|make) sure (?:to|you)|remember to|do(?: not|n['’]t) forget to|try to|feel free to|"
    r"proceed to|"
    r"continue to|kindly|have the robot|let the robot|tell the robot to|make the robot|get the robot to)\s+|"
    r"(?:start|begin|finish|end|conclude|continue|proceed|go on)(?:\s+(?:off|out))?\s+(?:by|with)\s+)",
    re.IGNORECASE,
)
_AT_PLACE = re.compile(r"\b(?:on|onto|into|in|to|at|upon|inside|towards?|→)\s|->|=>", re.IGNORECASE)
_PAST = re.compile(
    r"\b(?:has|have|had)\s+(?:\w+\s+)?been\b|\b(?:was|were)\b|\b(?:because|since|so that|as a result|ensures?|means|"
    r"reason)\b",
    re.IGNORECASE,
)
_ASSIGNED = re.compile(
    r"(?:[^\s,;:]+\s+){1,8}?(?:then |also |now )?(?:(?:(?:should|must|will|shall|can|has to|have to|needs? to|"
    r"ought to|is to|"
    r"are to) )?(?:then |also )?(?:go|goes|belongs?|be (?:put|set|laid|brought|carried|\w+ed))|(?:is|are|"
    r"gets?) (?:then |also |"
    r"to be |going )?(?:put|set|laid|brought|placed|moved|transferred|carried|delivered|stored|assigned|stacked))\s+"
    r"(?:\w+ )??(?:on|onto|to|in|into|at|inside|upon)\b",
    re.IGNORECASE,
)
_POINTED = re.compile(
    r"(?:place:\s*)?(?:[a-z]{1,20}[ _]){0,3}(?:#?\d+|block|cube|one|object)s?\s*(?:→|->|=>|:|=)\s*(?:(?:on|to|"
    r"in) )?(?:the )?"
    r"(?:[a-z]{1,20}[ _]){0,3}#?[a-z]{0,3}\d+\b",
    re.IGNORECASE,
)
_ARROW = re.compile(r"[^,;:.→]{2,40}\s*(?:→|->|=>)\s*[^,;:.→]{2,60}$")
_IT_GOES = re.compile(r"it\s+(?:(?:should|must|will) )?(?:then |now )?(?:go|goes|belongs?)\s", re.IGNORECASE)
_RECEIVES = re.compile(r"[^,;:]{1,60}\b(?:gets|receives)\s+[^,;]{2,}", re.IGNORECASE)
_LABEL = re.compile(
    r"(?:object|block|item|level|shelf|position|place|area|green|yellow|red|blue|colou?r|robot|gripper|arm|"
    r"total|final|"
    r"initial|current|time|status|difficulty|duration|target|destination|location|source|from|to)s?\b",
    re.IGNORECASE,
)
_SIDE_HEADING = re.compile(
    r"(?:\W*)(?:\w+\s+){0,2}?(?:notes?|assumptions?|explanations?|reasoning|summary|results?|tips?|caution|"
    r"warnings?|"
    r"preparation|safety|why|rationale|analysis|overview|understanding|context|considerations?|legend|"
    r"layout|inventory|"
    r"(?:final|end|initial|current|resulting) (?:state|arrangement|positions?|layout|setup|configuration|"
    r"placement)|"
    r"scene|objects?|places?|before you (?:start|begin)|verification|checks?|outcome|thought(?:s| process)?|"
    r"disclaimer|limitations?|alternatives?|key (?:points|takeaways))\b",
    re.IGNORECASE,
)
_OVERRIDE = re.compile(
    r"\b(?:ignore|disregard|forget|override|bypass|discard)\b[^.\n]{0,60}\b"
    r"(?:instructions?|rules?|prompts?|guidelines?|restrictions?|system message|constraints?)\b",
    re.IGNORECASE,
)
_ASKS = re.compile(
    r"(?:sorry\W+|hm+\W+|before [^,]{1,60},\s*)?(?:which|what|where|who|how many|in what|on which|to which|"
    r"at which|from which|"
    r"should|could you|can you|do you (?:mean|want)|did you|are you|is (?:it|the|there an?)|does)\b",
    re.IGNORECASE,
)
_DANGLING = re.compile(
    r"\b(?:and|or|the|a|an|on|onto|to|of|at|in|into|from|with|then|its|for|by|as|"
    r"(?:pick|lift|take|grab|move|go|back)(?:ing|s|es)? up|pick|(?:and|then|to|,) +(?:place|put))\W*$|"
    r"^\W*(?:place|put|pick|up)\W*$",
    re.IGNORECASE,
)
_FRAGMENT = re.compile(
    r"\b(?:and|then)\s+(?!(?:go|put|set|lay|get|use|let|sit)\b)[a-z]{1,3}$|"
    r"\b(?:posi\w{0,3}|shel|leve|starti\w?|sorti\w?|beginni\w?|respecti\w{0,4}|objec)$"
)
_NAMED_BY_LETTER = re.compile(r"[A-Za-z]{2,}[ _-][A-Z]\W*$")
_REFERENCE = re.compile(r"\b([a-z]+?)s?[ _]?#?(\d+)((?:(?:\s*,\s*|\s*,?\s+(?:and|or|to|&)\s+)\d+\b)*)", re.IGNORECASE)


class Sense(StrEnum):
    """What a sentence does."""

    ACTION = "action"
    UNKNOWN = "unknown"
    PASSIVE = "passive"
    REMARK = "remark"
    EXPLANATION = "explanation"
    PROHIBITION = "prohibition"
    CONDITION = "condition"
    EMPTY = "empty"


@dataclass(frozen=True, slots=True)
class Sort:
    """What a sentence is; `cut` characters of connective or subject come before the instruction itself.
    `led`: it had a connective; `first_person`: it says what the speaker is going to do."""

    sense: Sense
    cut: int = 0
    led: bool = False
    first_person: bool = False


def sense(text: str) -> Sort:
    """What one sentence is."""
    line = text.replace("\n", " ")
    at, led = _past_connectives(line)
    around = _around(line, at)
    if around is not None:
        return Sort(around)
    subject = _SUBJECT.match(line, at)
    if subject is not None and _IT_GOES.match(line, at):
        return Sort(Sense.PASSIVE, at, led)
    if subject is not None:
        begin = _verb_at(line, subject.end())
        first_person = _FIRST_PERSON.match(line, at) is not None
        return Sort(Sense.EXPLANATION) if begin is None else Sort(Sense.ACTION, begin, led, first_person)
    return Sort(_told(line, at), at, led)


def _past_connectives(line: str) -> tuple[int, bool]:
    """Where the sentence itself begins, and whether anything came before it."""
    at, led = 0, False
    for _ in range(4):
        found = None if _REMARK.match(line, at) else _CONNECTIVE.match(line, at) or _CLAUSE.match(line, at)
        found = found or _LABELLED.match(line, at)
        if found is None:
            break
        at, led = found.end(), True
    return at, led


def _around(line: str, at: int) -> Sense | None:
    """What a sentence is that instructs nobody to do anything."""
    if not re.search(r"\w", line):
        return Sense.EMPTY
    if _REMARK.match(line, at):
        return Sense.REMARK
    if _CONDITION.match(line, at):
        return Sense.CONDITION
    return Sense.PROHIBITION if _NEGATION.match(line, at) or _STAYS.match(line, at) else None


def _told(line: str, at: int) -> Sense:
    """What a sentence is that begins with its verb, or says how things are."""
    passive = _PASSIVE.match(line, at) is not None and bool(references(line))
    noun = _NOUN_SUBJECT.match(line, at) is not None
    lead = _LEAD.match(line, at)
    if not noun and (_verb_at(line, at) is not None or (lead and _verb_at(line, lead.end()) is not None)):
        return Sense.ACTION
    if passive:
        return Sense.PASSIVE
    if noun or _STATEMENT.match(line, at):
        return Sense.EXPLANATION
    words = line[at:].split()
    bare = len(words) > 1 and words[0].strip(",").isalpha() and not _LABEL.match(line, at)
    return Sense.UNKNOWN if bare or references(line) else Sense.EXPLANATION


def _verb_at(line: str, at: int) -> int | None:
    """Where an instruction's verb stands, after an adverb at most; None where no known verb does."""
    if _NUMBERED_NOUN.match(line, at):
        return None
    adverb = _ADVERB.match(line, at)
    for begin in (at, adverb.end()) if adverb else (at,):
        word = re.compile(r"[A-Za-z]+(?![A-Za-z'’])").match(line, begin)
        if word is not None and _base(word.group().lower()):
            return at
    return None


def _base(word: str) -> bool:
    return word in _VERBS or (word.endswith("s") and (word[:-1] in _VERBS or word[:-2] in _VERBS))


def commanded(text: str) -> int | None:
    """Where the command of a sentence begins that handles things, after whatever leads up to it ("To do this, first",
    "Sure,", "I would", "Start by"): a verb of handling with a number or a place after it. None where there is none.
    """
    line = text[:_LONG].replace("\n", " ")
    at, by = 0, False
    for _ in range(8):
        if _CONDITION.match(line, at) or (_NEGATION.match(line, at) and not _ADVICE.match(line, at)):
            return None
        if _handles(line, at, by):
            return at
        found = next(
            (m for p in (_INTERJECTION, _CONNECTIVE, _CLAUSE, _ADVICE, _LEAD, _ADVERB) if (m := p.match(line, at))),
            None,
        )
        if found is None:
            return None
        by = re.search(r"\b(?:by|with|suggest|recommend|propose|is|be)\s+$", found.group(), re.IGNORECASE) is not None
        at = found.end()
    return None


def _handles(line: str, at: int, by: bool) -> bool:
    word = re.compile(r"[A-Za-z]+(?![A-Za-z'’])").match(line, at)
    if word is None or _IDIOM.match(line, at) or _NUMBERED_NOUN.match(line, at) or _NOUN_SUBJECT.match(line, at):
        return False
    verb = word.group().lower()
    if by and verb.endswith("ing"):
        stem = verb[:-3]
        forms = {stem, stem + "e", stem[:-1]}
    else:
        forms = {verb, verb.removesuffix("s"), verb.removesuffix("es")}
    rest = line[word.end() :]
    return not forms.isdisjoint(_HANDLING) and bool(references(rest) or _AT_PLACE.search(rest))


def assigns(text: str) -> bool:
    """Whether a sentence says where something is to go: "object 1 goes to position 11", "object 1 -> position 11",
    "position 21 gets object 3". What has been, or is so because of something, does not."""
    line = text[:_LONG].replace("\n", " ")
    at, _ = _past_connectives(line)
    if _PAST.search(line) or _around(line, at) is not None:
        return False
    if _RECEIVES.match(line, at) and len(_nouns(line)) > 1:
        return True
    if _ARROW.match(line.rstrip(" .!"), at) is not None and references(line):
        return True
    return _ASSIGNED.match(line, at) is not None or (_POINTED.match(line, at) is not None and len(_nouns(line)) > 1)


def tells_of_places(text: str) -> bool:
    """Whether a text names numbered things of two kinds, one of them as where to: it may not be lost."""
    text = text[:_LONG]
    if _PAST.search(text) or len(_nouns(text)) < 2 or not _AT_PLACE.search(text):
        return False
    words = re.findall(r"[a-z]+", text.lower())
    return any(form in _HANDLING for w in words for form in (w, w.removesuffix("s"), w.removesuffix("ing")))


def _nouns(text: str) -> frozenset[str]:
    return frozenset(noun for noun, _ in references(text))


def references(text: str) -> frozenset[tuple[str, str]]:
    """The numbered things a text speaks of: ("object", "1"), ("level", "2")."""
    found = set()
    for match in _REFERENCE.finditer(text):
        noun = match.group(1).lower()
        for number in [match.group(2), *re.findall(r"\d+", match.group(3))]:
            found.add((noun, number))
    return frozenset(found)


def is_side_heading(text: str) -> bool:
    """Whether what stands under a heading is said around the steps (notes, reasoning, the final
    arrangement)."""
    return _SIDE_HEADING.match(text) is not None and "step" not in text.lower()


def asks(sentence: str) -> bool:
    """Whether a sentence asks the user for something that the request left open."""
    return sentence.rstrip(" \"'”").endswith("?") and _ASKS.match(sentence.strip()) is not None


def overrides(text: str) -> re.Match[str] | None:
    """Where a text tells its reader to set rules aside."""
    return _OVERRIDE.search(text)


def dangles(text: str) -> bool:
    """Whether a text ends in the middle: on a word that wants another, or with something left open."""
    if text.count("(") > text.count(")"):
        return True
    if _FRAGMENT.search(text):
        return True
    found = _DANGLING.search(text)
    if found is None or _NAMED_BY_LETTER.search(text[-60:]):
        return False
    return not (re.search(r"[.!?]\W*$", text) and re.search(r"\b(?:up|on|in|by)\W*$", text, re.IGNORECASE))
