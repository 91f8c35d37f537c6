"""Random STRIPS domains with problems, as PDDL text: types, `either`, constants, negation, equality, alternatives,
predicates without arguments, names in any capitals, comments."""

from __future__ import annotations

import random

__all__ = ["generated"]

TYPES = {"thing": "object", "box": "thing", "Key": "thing", "room": "object"}


class _Writer:
    """One domain; `plain` keeps to typing, negation and equality, in small letters."""

    def __init__(self, rng: random.Random, plain: bool) -> None:
        self.rng, self.plain = rng, plain
        self.kinds = ["thing", "room", "box"] if plain else ["thing", "room", "box", "object"]
        self.predicates = {
            f"p{i}": [rng.choice(self.kinds) for _ in range(rng.choice([0, 1, 1, 2]))] for i in range(rng.randint(2, 4))
        }
        self.constants = {"hall": "room", "master": "Key"} if rng.random() < 0.5 else {}
        self.objects = dict(self.constants)
        for kind, most in (("box", 2), ("Key", 1), ("room", 2), ("thing", 1)):
            self.objects |= {f"{kind.lower()}{i}": kind for i in range(rng.randint(0 if self.objects else 1, most))}

    def word(self, text: str) -> str:
        """In capitals now and then; a comment now and then."""
        if self.plain or self.rng.random() > 0.2:
            return text
        return self.rng.choice([text.upper(), text.title(), f"{text} ; (not (\n  "])

    def is_a(self, kind: str, wanted: str) -> bool:
        while kind not in (wanted, "object"):
            kind = TYPES[kind]
        return kind == wanted

    def atom(self, pool: dict[str, str]) -> str | None:
        """A predicate over names of a pool, each with its type, that fit it; None where none does."""
        names = list(self.predicates)
        for name in self.rng.sample(names, len(names)):
            fits = [[n for n, k in pool.items() if self.is_a(k, kind)] for kind in self.predicates[name]]
            if all(fits):
                return f"({' '.join([self.word(name), *map(self.rng.choice, fits)])})"
        return None

    def literal(self, pool: dict[str, str], negative: float) -> str:
        """An atom, a negated one, or an equality."""
        if pool and self.rng.random() < 0.15:
            pair = f"(= {self.rng.choice(list(pool))} {self.rng.choice(list(pool))})"
            return f"(not {pair})" if self.rng.random() < 0.8 else pair
        found = self.atom(pool)
        if found is None:
            return "(and)"
        return f"(not {found})" if self.rng.random() < negative else found

    def condition(self, pool: dict[str, str], most: int, *, goal: bool = False) -> str:
        parts = [self.literal(pool, 0.3) for _ in range(self.rng.randint(1, most))]
        if not self.plain and self.rng.random() < 0.3:
            head = self.rng.choice(["or", "imply", "or"] + (["forall", "exists"] if goal else []))
            if head in ("forall", "exists"):
                inside = self.literal({**pool, "?v": "room"}, 0.3)
                parts.append(f"({head} (?v - room) {inside})")
            else:
                parts.append(f"({head} {self.literal(pool, 0.3)} {self.literal(pool, 0.3)})")
        return parts[0] if len(parts) == 1 and self.rng.random() < 0.5 else f"({self.word('and')} {' '.join(parts)})"

    def action(self, number: int) -> str:
        rng = self.rng
        params: dict[str, str] = {}
        shown = []
        for i in range(rng.choice([0, 1, 2, 2, 3])):
            kind = rng.choice(self.kinds)
            params[f"?x{i}"] = kind
            if not self.plain and kind == "thing" and rng.random() < 0.3:
                shown.append(f"?x{i} - (either box key)")
            else:
                shown.append(f"?x{i} - {kind}")
        pool = params | self.constants
        adds = [a for _ in range(rng.randint(1, 2)) if (a := self.atom(pool))]
        ends = [f"(not {a})" for _ in range(rng.randint(0, 2)) if (a := self.atom(pool))]
        effects = [*adds, *ends]
        if not effects:
            return ""
        rng.shuffle(effects)
        before = f"\n  :precondition {self.condition(pool, 3)}" if rng.random() < 0.9 or self.plain else ""
        return (
            f" ({self.word(':action')} {self.word(f'do-{number}')} :parameters ({' '.join(shown)}){before}\n"
            f"  :effect (and {' '.join(effects)}))\n"
        )

    def text(self) -> tuple[str, str]:
        rng = self.rng
        requirements = ":strips :typing :negative-preconditions :equality"
        requirements += "" if self.plain else " :disjunctive-preconditions"
        types = " ".join(f"{k} - {above}" for k, above in TYPES.items())
        constants = " ".join(f"{n} - {k}" for n, k in self.constants.items())
        predicates = " ".join(
            f"({' '.join([n, *(f'?a{i} - {k}' for i, k in enumerate(kinds))])})" for n, kinds in self.predicates.items()
        )
        actions = "".join(self.action(i) for i in range(rng.randint(2, 5)))
        if not actions:
            return _Writer(rng, self.plain).text()
        domain = (
            f"(define (domain d)\n (:requirements {requirements})\n (:types {types})\n"
            + (f" (:constants {constants})\n" if constants else "")
            + f" (:predicates {predicates})\n{actions})\n"
        )
        own = " ".join(f"{n} - {k}" for n, k in self.objects.items() if n not in self.constants)
        facts = dict.fromkeys(a for _ in range(rng.randint(0, 6)) if (a := self.atom(self.objects)))
        goal = self.condition(self.objects, 3, goal=True)
        problem = (
            f"(define (problem p) (:domain d) (:objects {own})\n"
            f" (:init {' '.join(facts)})\n (:goal {goal if goal.startswith('(and') else f'(and {goal})'}))\n"
        )
        return domain, problem


def generated(seed: int, *, plain: bool = False) -> tuple[str, str]:
    """The domain and the problem of a seed; `plain` ones hold nothing but typing, negation and equality."""
    return _Writer(random.Random(f"pddl {seed}"), plain).text()
