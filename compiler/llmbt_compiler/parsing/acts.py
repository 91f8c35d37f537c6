"""What each kind of template makes of a clause: Holding, Free, Near or another change, entered into the ledger."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from llmbt_atl.template import Role, Template
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Stop
from llmbt_compiler.parsing.ledger import Entry
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.placing import Placing, extent_of, goal_pattern
from llmbt_compiler.parsing.verbs import Shape, Verb, travel_template
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["Acting"]

_POINTING = ("pronouns", "plural_pronouns")
_WHITHER = frozenset({"to", "onto", "into", "towards"})
_SOMEBODY = frozenset(
    {"whoever", "whomever", "wherever", "where", "anyone", "anybody", "somebody", "someone", "everyone"}
)
_PAUSES = frozenset({";", ",", ".", "-", "–", "—", ":"})
_SOURCE = frozenset({"from", "off", "of", "out"})
_GATHERING = frozenset({"gather", "collect", "assemble", "group", "concentrate", "unite", "amass"})
_RECEIVING = frozenset({"gets", "receives"})
_COMMAS = frozenset({"", ",", ".", ":", ">", "→", "⇒", "and", "then", "is"})


@dataclass
class Acting(Placing):
    """The deeds besides placing."""

    def travels(self, templates: Sequence[Template]) -> bool:
        return bool(templates) and self.shape(templates[0]) is Shape.TRAVEL

    def held(self, things: Group, verb: Verb) -> bool:
        return bool(verb.templates) and bool(things.targets)

    def in_hand(self, things: Group) -> bool:
        """Whether the targets are held already, or have been dealt with."""
        ids = [i for p in things.targets for i in self.quiet(p)]
        return bool(ids) and all(i in self.ledger.handled for i in ids)

    def mention(self, things: Group) -> None:
        """What a step without a goal speaks of can be referred to."""
        found = [resolve_objects(p.parts, self.scene, self.talk()) for p in things.targets]
        named = tuple(i for f in found if isinstance(f, Found) and not f.chosen for i in f.ids)
        if len(set(named)) > 1:
            self.listed = (tuple(dict.fromkeys(named)), self.turn)
        for phrase in things.phrases:
            ids = self.quiet(phrase)
            if ids:
                self.targets, self.approached, self.lost = (
                    (ids, self.turn),
                    ids[0] if len(ids) == 1 else None,
                    False,
                )
            elif phrase.kind == "Destination" or (phrase.preposition not in _SOURCE and self.places_of(phrase)):
                self.carry_to(phrase)

    def carry_to(self, phrase: Phrase) -> None:
        """With something in the hand, a way to a place tells where it is going."""
        outer = self.agreeing(phrase) if phrase.trail or phrase.aside else ()
        place = self.quiet_place(
            replace(phrase, parts=outer) if outer and self.quiet_place(phrase) == ANYWHERE else phrase
        )
        if place is not None and place not in {ANYWHERE, ORIGIN} and not phrase.about("home"):
            self.place = (place, self.turn)
            if self.ledger.pending:
                self.ledger.carried = place

    def moves(self, clause: Clause, things: Group) -> None:
        """The robot moves: Near where the library knows how to go somewhere, else a note."""
        travel = travel_template(self.scene.library)
        somewhere = [p for p in (*things.destinations, *things.locations) if not p.about("home")]
        if travel is not None and somewhere and any(self.quiet_place(p) for p in somewhere):
            self.travel(clause, travel, replace(things, targets=()))
            return
        home = len(somewhere) < len(things.destinations)
        if travel is not None and somewhere and not home and not any(self.quiet(p) for p in somewhere):
            self.travel(clause, travel, replace(things, targets=()))
            return
        self.mention(things)
        self.left_out(clause, "changes no goal")

    def travel(self, clause: Clause, template: Template, group: Group) -> None:
        """Near: whatever phrase there is fills its slot, be it tagged destination or location."""
        phrases = (*group.destinations, *group.locations)
        if phrases and all(p.about("home") and self.quiet_place(p) is None for p in phrases):
            self.left_out(clause, "changes no goal")
            return
        if not phrases:
            self.left_out(clause, "changes no goal")
            return
        if self.ledger.pending and self.placing() and self.with_it(clause, phrases):
            self.bring(clause, self.placing(), Group((), phrases[:1]), ())
            return
        slot = template.param(Role.LOCATION) or template.param(Role.DESTINATION)
        pattern = next(p for p in template.post if self.scene.library.conditions[p.name].goal)
        assert slot is not None
        for phrase in phrases[:1]:
            objects = self.quiet(phrase) if self.quiet_place(phrase) is None else ()
            where = self.ledger.where.get(objects[0]) if len(objects) == 1 else None
            if objects:
                self.mention(Group((phrase,)))
            ids = (where,) if where is not None else self.where_to(phrase).ids
            if objects and where is None:
                self.left_out(clause, "changes no goal")
                return
            for place in ids:
                if place in {ANYWHERE, ORIGIN}:
                    self.left_out(clause, "changes no goal")
                    continue
                condition = pattern.bind({slot.name: place})
                self.ledger.go(Entry(condition, self.now, extent_of(clause, group), place=place))
                self.place = (place, self.turn)
                if self.ledger.pending:
                    self.ledger.carried = place

    def with_it(self, clause: Clause, phrases: Sequence[Phrase]) -> bool:
        """Whether what is in the hand is said to come along to somebody ("come back to me with them")."""
        after = tokens(self.now.text, max(clause.extent.end, *(p.extent.end for p in phrases)))[:2]
        place = self.quiet_place(phrases[0])
        along = [t.text for t in after[:1]] == ["with"] and len(after) == 2 and lexicon().is_(after[1].text, *_POINTING)
        return along and place is not None and place not in {ANYWHERE, ORIGIN} and self.scene[place].person

    def take(self, clause: Clause, template: Template, ids: Sequence[str], *, weak: bool = False) -> None:
        target = template.param(Role.TARGET)
        assert target is not None
        pattern = goal_pattern(template, self.scene.library, {target.name})
        assert pattern is not None
        for i in ids:
            self.fit(i, target.type, clause.extent)
            extent = extent_of(clause, Group(tuple(g for g in clause.phrases if g.kind == "Target")))
            entry = Entry(pattern.bind({target.name: i}), self.now, extent, target=i, weak=weak)
            self.ledger.take(entry)
        self.targets, self.lost = (tuple(ids), self.turn), False

    def pick(self, clause: Clause, templates: tuple[Template, ...], group: Group, excluded: tuple[Phrase, ...]) -> None:
        """A target is taken; a destination with "to" or for somebody makes it a placing."""
        lex = lexicon()
        group = self.there(group)
        to = [p for p in (*group.destinations, *group.locations) if lex.is_(p.preposition, "onto")]
        to += [p for p in group.destinations if not p.preposition or p.preposition in _COMMAS]
        to += [p for p in group.locations if p.preposition in _PAUSES and self.elsewhere(group.targets, p)]
        to += [p for p in group.destinations if p.preposition == "that" and self.one_person(p)]  # "see that he gets it"
        gets = clause.action.casefold() in _RECEIVING
        who = [p for p in to if not p.preposition and p.extent.end <= clause.extent.start and self.one_person(p)]
        if who and not gets:  # "the user takes the coke"
            said = who[0].extent.cut(self.now.text)
            self.complain("E314", f"`{said}` is named, and what for is not understood", who[0].extent)
            raise Stop
        to = [
            p
            for p in to
            if not (p.preposition in _COMMAS and p.extent.start < clause.extent.start) or (gets and self.one_person(p))
        ]
        if not to and group.targets:
            to = [p for p in group.destinations if lex.is_(p.preposition, "at") and self.elsewhere(group.targets, p)]
        if not to and group.targets and clause.action.casefold() in _GATHERING:
            around = (*group.locations, *group.destinations)
            there = [p for p in around if lex.is_(p.preposition, "at") and self.few_at(group.targets, p)]
            to += there[-1:]
            group = Group(group.targets, (*_but(group.destinations, to), *to), _but(group.locations, to))
        if to and self.placing() and (group.targets or self.ledger.pending):
            rest = tuple(p for p in (*group.locations, *group.destinations) if p not in to)
            self.bring(clause, self.placing(), Group(group.targets, tuple(to), rest), excluded)
            return
        gathered = [p for p in group.locations if lex.is_(p.preposition, "at") and self.gathers(group.targets, p)]
        if gathered and not to and self.placing():  # "gather all cubes in the sorting area"
            rest = tuple(p for p in group.locations if p not in gathered)
            self.bring(clause, self.placing(), Group(group.targets, tuple(gathered), rest), excluded)
            return
        behind = self.missed(clause, group) if self.placing() and not to else None
        if behind is not None and lex.is_(behind.preposition, "onto") and group.targets:
            self.bring(clause, self.placing(), replace(group, destinations=(behind,)), excluded)
            return
        returned = "back" in clause.particles and "up" not in clause.particles and not group.destinations
        if self.placing() and group.targets and not to and (returned or self.to_origin(clause)):
            self.bring(clause, self.placing(), group, excluded)  # "take it back to where it was"
            return
        above = [p for p in group.phrases if p.kind != "Target" and lex.is_(p.relation, "hover")]
        locations = tuple(p for p in (*group.locations, *group.destinations) if p not in above)
        found = self.objects(clause, group, locations, excluded, picking=True)
        self.told_whither(group)
        self.take(clause, templates[0], found.ids)
        for phrase in above:  # "hold it above position 21"
            self.carry_to(phrase)

    def one_person(self, phrase: Phrase) -> bool:
        """Whether a phrase names a person of the map."""
        place = self.quiet_place(phrase)
        return place is not None and place not in {ANYWHERE, ORIGIN} and self.scene[place].person

    def gathers(self, targets: Sequence[Phrase], phrase: Phrase) -> bool:
        """Whether all of some things are spoken of, and none of them is at the place that a phrase names."""
        place = self.quiet_place(phrase) if not phrase.relation else None
        if place is None or place in {ANYWHERE, ORIGIN} or not all(p.about("all") or p.about("both") for p in targets):
            return False
        ids = [i for p in targets for i in self.quiet(p)]
        return len(ids) > 1 and not any(self.scene.within(self.ledger.where.get(i), place) for i in ids)

    def few_at(self, targets: Sequence[Phrase], phrase: Phrase) -> bool:
        """Whether none of what is to be gathered stands on the place yet, or but one of several: then it is where they
        are to go."""
        place = self.quiet_place(phrase) if not phrase.relation else None
        if place is None or place in {ANYWHERE, ORIGIN}:
            return False
        ids = [i for p in targets for i in self.quiet(p)]
        there = sum(self.scene.within(self.ledger.where.get(i), place) for i in ids)
        return bool(ids) and there <= (len(ids) > 1)

    def told_whither(self, group: Group) -> None:
        """E305 where words behind the last target say to whom or where it goes, and were not understood ("take the coke
        to whoever is at the desk"): without them it would only be picked up."""
        after = tokens(self.now.text, max((p.extent.end for p in group.phrases), default=len(self.now.text)))[:2]
        said = [t.text for t in after]
        if len(after) < 2 or said[0] not in _WHITHER or any(u.start <= after[1].start < u.end for u in self.used):
            return
        if said[1] in _SOMEBODY or (lexicon().is_(said[1], "articles") and not after[1].owner):
            extent = Extent(after[0].start, after[1].end)
            self.complain(
                "E305", f"`{extent.cut(self.now.text)} ...` names no place", extent, "where?", "name the place"
            )

    def there(self, group: Group) -> Group:
        """ "Go to position 23, grasp the block there": the word tells where the thing is, if it is."""
        here = tuple(p for p in group.destinations if all(lexicon().is_(t.text, "there") for t in p.parts))
        place = self.quiet_place(here[0]) if len(here) == 1 and not here[0].preposition else None
        if place is None or len(group.targets) != 1 or place == ANYWHERE:
            return group
        found = resolve_objects(group.targets[0].parts, self.scene, self.talk(), at=(place,), picking=True)
        standing = isinstance(found, Found) and all(
            self.scene.within(self.ledger.where.get(i), place) for i in found.ids
        )
        return Group(group.targets, _but(group.destinations, here), (*group.locations, *here)) if standing else group

    def elsewhere(self, targets: Sequence[Phrase], phrase: Phrase) -> bool:
        """Whether a phrase names a place at which none of the targets is or was."""
        ids = [i for p in targets for i in self.quiet(p)]
        place = self.quiet_place(phrase) if not phrase.relation else None
        if not ids or place is None or place in {ANYWHERE, ORIGIN}:
            return False
        return not any(self.scene.within(w, place) for i in ids for w in (self.ledger.where.get(i), self.origin.get(i)))

    def change(self, clause: Clause, template: Template, group: Group, excluded: tuple[Phrase, ...]) -> None:
        """A target is made what the template's Post says, wherever it is."""
        target = template.param(Role.TARGET)
        assert target is not None
        pattern = goal_pattern(template, self.scene.library, {target.name})
        assert pattern is not None
        found = self.objects(clause, group, (*group.locations, *group.destinations), excluded, picking=False)
        for i in found.ids:
            self.fit(i, target.type, clause.extent)
            self.ledger.add(Entry(pattern.bind({target.name: i}), self.now, extent_of(clause, group)))

    def clear(
        self, clause: Clause, templates: tuple[Template, ...], group: Group, excluded: tuple[Phrase, ...]
    ) -> None:
        """ "Clear position 12" is Free; "remove object 3 from position 22" puts it aside."""
        template = templates[0]
        lex = lexicon()
        away = [p for p in group.destinations if lex.is_(p.preposition, "onto", "at") and group.targets]
        group = replace(group, targets=tuple(self.contents(p) for p in group.targets)) if away else group
        if away and self.placing():
            self.bring(clause, self.placing(), replace(group, destinations=tuple(away)), excluded)
            return
        locations = (*group.locations, *(p for p in group.destinations if p not in away))
        listed = tuple(p for p in group.destinations if lex.is_(p.preposition, "joints") or p.preposition == ",")
        group = replace(group, targets=(*group.targets, *listed), destinations=_but(group.destinations, listed))
        places = [p for p in group.targets if not self.quiet(p) and self.places_of(p)]
        if places or (not group.targets and locations):
            self.free(clause, template, places or list(locations))
            if len(places) < len(group.targets):
                self.clear(clause, templates, replace(group, targets=_but(group.targets, places)), excluded)
            return
        found = self.objects(clause, group, locations, excluded, picking=True)
        target = template.param(Role.TARGET)
        assert target is not None
        pattern = next(
            p for p in template.post if target.name in p.params() and self.scene.library.conditions[p.name].goal
        )
        aside = next(p for p in template.params if p.name in pattern.params() and p.name != target.name)
        buffer = self.scene.buffer(aside.type)
        if buffer is None:
            self.targets, self.lost = (found.ids, self.turn), False
            self.left_out(clause, "is done where something is in the way; it is to end up nowhere in particular")
            return
        for i in found.ids:
            self.fit(i, target.type, clause.extent)
            condition = pattern.bind({target.name: i, aside.name: buffer})
            self.ledger.put(Entry(condition, self.now, extent_of(clause, group), target=i, place=buffer))
        self.place = (buffer, self.turn)

    def contents(self, phrase: Phrase) -> Phrase:
        """ "Empty the tray onto the pallet": a place that is emptied to somewhere stands for all that is on it."""
        if self.quiet(phrase) or not self.places_of(phrase):
            return phrase
        first = phrase.parts[0]
        return replace(phrase, parts=(replace(first, text="everything"), replace(first, text="on"), *phrase.parts))

    def free(self, clause: Clause, template: Template, phrases: Sequence[Phrase]) -> None:
        slot = template.param(Role.LOCATION)
        pattern = goal_pattern(template, self.scene.library, {slot.name}) if slot is not None else None
        if pattern is None or slot is None:
            self.unknown_action(clause, Verb(clause.action, clause.action))
            return
        type_ = self.scene.library.conditions[pattern.name].params[0].type
        for phrase in phrases:
            for place in self.where_to(phrase).ids:
                spots = (place,) if self.scene.is_a(place, type_) else self.scene.spots(place, type_)
                for spot in spots:
                    extent = clause.extent | phrase.extent
                    self.ledger.free(Entry(pattern.bind({slot.name: spot}), self.now, extent, place=spot))
                self.place = (place, self.turn)


def _but(phrases: Sequence[Phrase], gone: Sequence[Phrase]) -> tuple[Phrase, ...]:
    return tuple(p for p in phrases if p not in gone)
