"""From an action's word to the templates it may mean: the library's verbs, forms,
particles, synonyms, slips.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from llmbt_atl.library import Library
from llmbt_atl.template import Role, Template
from llmbt_compiler.parsing.words import closest, lemmas, lexicon
from llmbt_ir.diagnostics import nearest

__all__ = ["Shape", "Verb", "read_verb", "shape_of", "travel_template"]


class Shape(StrEnum):
    """What a template does to the world, as its roles and its Post say it."""

    PICK = "pick"
    PLACE = "place"
    FREE = "free"
    TRAVEL = "travel"
    CHANGE = "change"
    OTHER = "other"


@dataclass(frozen=True, slots=True)
class Verb:
    """A verb as the library understands it: its templates, best first; `classes` are the
    lists it stands in.
    """

    text: str
    lemma: str
    templates: tuple[Template, ...] = ()
    classes: frozenset[str] = frozenset()
    corrected: bool = False
    alternatives: tuple[str, ...] = ()

    def is_(self, *names: str) -> bool:
        """Whether it stands in one of the lists."""
        return not self.classes.isdisjoint(names)


def shape_of(template: Template, library: Library) -> Shape:
    """TRAVEL has no target; PLACE brings its target to a destination, FREE puts it aside; PICK takes a target into the
    hand, which is what a PLACE needs of it; CHANGE does something else to it. One that only looks is OTHER.
    """
    if template.senses:
        return Shape.OTHER
    target = template.param(Role.TARGET)
    destination, location = template.param(Role.DESTINATION), template.param(Role.LOCATION)
    goals = [p for p in template.post if library.conditions[p.name].goal]
    if target is None:
        return Shape.TRAVEL if (destination or location) and goals else Shape.OTHER
    if destination is not None and any({target.name, destination.name} <= set(p.params()) for p in goals):
        return Shape.PLACE
    about = [p for p in goals if target.name in p.params()]
    if any(len(p.params()) > 1 for p in about):
        return Shape.FREE
    if not about:
        return Shape.OTHER
    held = _held(library)
    return Shape.PICK if not held or any(p.name in held for p in about) else Shape.CHANGE


def _held(library: Library) -> frozenset[str]:
    """The conditions that templates which bring a target somewhere need of it alone: that it is in the hand."""
    return frozenset(
        p.name
        for t in library.templates.values()
        if (target := t.param(Role.TARGET)) is not None and t.param(Role.DESTINATION) is not None
        for p in (*t.start, *t.hold)
        if p.params() == (target.name,) and not p.negated and library.conditions[p.name].goal
    )


def travel_template(library: Library) -> Template | None:
    """The template by which the robot goes somewhere, if it can."""
    return next((t for t in library.templates.values() if shape_of(t, library) is Shape.TRAVEL), None)


def _forms(word: str, particles: Sequence[str]) -> Iterator[str]:
    for lemma in lemmas(word):
        yield from (f"{lemma}_{p}" for p in particles)
    yield from lemmas(word)


def _templates(form: str, library: Library) -> tuple[Template, ...]:
    verbs = library.verbs
    names = (form, *lexicon().synonyms.get(form, ()))
    found = {t.name: t for n in names if (t := verbs.get(n)) is not None}
    return tuple(found.values())


def _classes(lemma: str, particles: Sequence[str]) -> frozenset[str]:
    forms = {lemma, *(f"{lemma}_{p}" for p in particles)}
    return frozenset(name for name, words in lexicon().verbs.items() if not words.isdisjoint(forms))


def _known(word: str, particles: Sequence[str], library: Library) -> tuple[str, tuple[Template, ...], frozenset[str]]:
    """The form that is known, its templates, and the lists it stands in: the library
    comes before the lists.
    """
    for form in _forms(word, particles):
        stem = form.split("_")[0]
        classes = _classes(stem, particles)
        templates = _templates(form, library)
        if stem != form:
            if not templates and not _classes(form, ()):
                continue
            templates += tuple(t for t in _templates(stem, library) if t not in templates)
        if templates or classes:
            return form, templates, classes
    return word, (), frozenset()


def read_verb(text: str, particles: Sequence[str], library: Library) -> Verb:
    """The verb of an action. `particles` are those that belong to it ("up", "down").

    A word that neither the library nor the lists know is held against the library's verbs: one near word is a
    slip of the pen (`corrected`), two equally near are none.
    """
    word = text.casefold()
    lemma, templates, classes = _known(word, particles, library)
    if templates or classes:
        return Verb(text, lemma, templates, classes, alternatives=nearest(lemma, library.verbs))
    lists = lexicon().verbs
    vocabulary = {*library.verbs, *lists["idle"], *lists["motion"], *lists["other"], *lexicon().synonyms}
    near = closest(word, vocabulary)
    alternatives = tuple(dict.fromkeys((*(n for n in near if n in library.verbs), *nearest(word, library.verbs))))
    if len(near) == 1:
        lemma, templates, classes = _known(near[0], particles, library)
        return Verb(text, lemma, templates, classes, True, alternatives)
    return Verb(text, word, alternatives=alternatives)
