"""Problems of many flavours, written for these tests, each with how it ends."""

from __future__ import annotations

HANOI = """(define (domain hanoi) (:requirements :strips)
(:predicates (clear ?x) (on ?x ?y) (smaller ?x ?y))
(:action move :parameters (?disc ?from ?to)
 :precondition (and (smaller ?disc ?to) (on ?disc ?from) (clear ?disc) (clear ?to))
 :effect (and (clear ?from) (on ?disc ?to) (not (on ?disc ?from)) (not (clear ?to)))))"""


def hanoi(n: int) -> str:
    """The tower of n discs from the first peg to the third; d1 is the largest disc."""
    pairs = [(i, j) for i in range(1, n + 1) for j in range(i + 1, n + 1)]
    smaller = " ".join([f"(smaller d{j} d{i})" for i, j in pairs])
    smaller += "".join(f" (smaller d{i} {p})" for i in range(1, n + 1) for p in "abc")
    tower = " ".join(f"(on d{i} d{i - 1})" for i in range(2, n + 1))
    return (
        f"(define (problem h) (:domain hanoi) (:objects a b c {' '.join(f'd{i}' for i in range(1, n + 1))})\n"
        f"(:init {smaller} (on d1 a) {tower} (clear d{n}) (clear b) (clear c))\n(:goal (and (on d1 c) {tower})))"
    )


SOKOBAN = """(define (domain sokoban) (:requirements :typing :strips)
(:types cell dir box)
(:predicates (adj ?a ?b - cell ?d - dir) (at ?c - cell) (box-at ?b - box ?c - cell) (free ?c - cell))
(:action move :parameters (?a ?b - cell ?d - dir) :precondition (and (at ?a) (adj ?a ?b ?d) (free ?b))
 :effect (and (at ?b) (not (at ?a)) (free ?a) (not (free ?b))))
(:action push :parameters (?p ?a ?b - cell ?d - dir ?x - box)
 :precondition (and (at ?p) (adj ?p ?a ?d) (adj ?a ?b ?d) (box-at ?x ?a) (free ?b))
 :effect (and (at ?a) (not (at ?p)) (free ?p) (not (free ?b)) (box-at ?x ?b) (not (box-at ?x ?a)))))"""


def sokoban(drawing: str) -> str:
    """# wall, $ box, . where boxes go in the order of reading, @ who pushes."""
    seen = {(x, y): c for y, row in enumerate(drawing.split("\n")) for x, c in enumerate(row) if c != "#"}
    names = {at: f"c{at[0]}-{at[1]}" for at in seen}
    steps = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}
    adj = [
        f"(adj {names[x, y]} {names[x + dx, y + dy]} {d})"
        for x, y in seen
        for d, (dx, dy) in steps.items()
        if (x + dx, y + dy) in seen
    ]
    boxes, goals = ([names[at] for at, c in seen.items() if c == sign] for sign in "$.")
    free = [f"(free {names[at]})" for at, c in seen.items() if c in " ."]
    here = next(names[at] for at, c in seen.items() if c == "@")
    lie = " ".join(f"(box-at b{i} {c})" for i, c in enumerate(boxes))
    want = " ".join(f"(box-at b{i} {c})" for i, c in enumerate(goals))
    return (
        f"(define (problem s) (:domain sokoban)\n(:objects {' '.join(names.values())} - cell {' '.join(steps)} - dir"
        f" {' '.join(f'b{i}' for i in range(len(boxes)))} - box)\n"
        f"(:init {' '.join(adj)} (at {here}) {lie} {' '.join(free)})\n(:goal (and {want})))"
    )


SNACK = """(define (domain child-snack) (:requirements :typing :equality)
(:types child bread content sandwich tray place)
(:constants kitchen - place)
(:predicates (bread-there ?b - bread) (content-there ?c - content) (made ?s - sandwich) (no-gluten-bread ?b - bread)
 (no-gluten-content ?c - content) (on-tray ?s - sandwich ?t - tray) (no-gluten ?s - sandwich) (allergic ?c - child)
 (not-allergic ?c - child) (served ?c - child) (waiting ?c - child ?p - place) (at ?t - tray ?p - place)
 (not-made ?s - sandwich))
(:action make-no-gluten :parameters (?s - sandwich ?b - bread ?c - content)
 :precondition (and (bread-there ?b) (content-there ?c) (no-gluten-bread ?b) (no-gluten-content ?c) (not-made ?s))
 :effect (and (not (bread-there ?b)) (not (content-there ?c)) (made ?s) (no-gluten ?s) (not (not-made ?s))))
(:action make :parameters (?s - sandwich ?b - bread ?c - content)
 :precondition (and (bread-there ?b) (content-there ?c) (not-made ?s))
 :effect (and (not (bread-there ?b)) (not (content-there ?c)) (made ?s) (not (not-made ?s))))
(:action put-on-tray :parameters (?s - sandwich ?t - tray) :precondition (and (made ?s) (at ?t kitchen))
 :effect (and (not (made ?s)) (on-tray ?s ?t)))
(:action serve-no-gluten :parameters (?s - sandwich ?c - child ?t - tray ?p - place)
 :precondition (and (allergic ?c) (on-tray ?s ?t) (waiting ?c ?p) (no-gluten ?s) (at ?t ?p))
 :effect (and (not (on-tray ?s ?t)) (served ?c)))
(:action serve :parameters (?s - sandwich ?c - child ?t - tray ?p - place)
 :precondition (and (not-allergic ?c) (waiting ?c ?p) (on-tray ?s ?t) (at ?t ?p))
 :effect (and (not (on-tray ?s ?t)) (served ?c)))
(:action move-tray :parameters (?t - tray ?p1 ?p2 - place) :precondition (and (at ?t ?p1) (not (= ?p1 ?p2)))
 :effect (and (not (at ?t ?p1)) (at ?t ?p2))))"""


def snack(no_gluten_breads: str) -> str:
    """Three children, two of them allergic; so many breads without gluten."""
    return f"""(define (problem s) (:domain child-snack) (:objects c1 c2 c3 - child b1 b2 b3 - bread k1 k2 k3 - content
 t1 - tray table1 table2 - place s1 s2 s3 - sandwich)
(:init (at t1 kitchen) (bread-there b1) (bread-there b2) (bread-there b3) (content-there k1) (content-there k2)
 (content-there k3) {no_gluten_breads} (no-gluten-content k1) (no-gluten-content k2) (allergic c1) (allergic c2)
 (not-allergic c3) (waiting c1 table2) (waiting c2 table1) (waiting c3 table1)
 (not-made s1) (not-made s2) (not-made s3))
(:goal (and (served c3) (served c1) (served c2))))"""


FUEL = """(define (domain fuel) (:requirements :typing)
(:types aircraft person city level - object)
(:predicates (at ?x - (either person aircraft) ?c - city) (in ?p - person ?a - aircraft)
 (fuel ?a - aircraft ?l - level) (next ?l1 ?l2 - level))
(:action board :parameters (?p - person ?a - aircraft ?c - city) :precondition (and (at ?p ?c) (at ?a ?c))
 :effect (and (not (at ?p ?c)) (in ?p ?a)))
(:action debark :parameters (?p - person ?a - aircraft ?c - city) :precondition (and (in ?p ?a) (at ?a ?c))
 :effect (and (not (in ?p ?a)) (at ?p ?c)))
(:action fly :parameters (?a - aircraft ?c1 ?c2 - city ?l1 ?l2 - level)
 :precondition (and (at ?a ?c1) (fuel ?a ?l1) (next ?l2 ?l1))
 :effect (and (not (at ?a ?c1)) (at ?a ?c2) (not (fuel ?a ?l1)) (fuel ?a ?l2))))"""


def flight(tank: int) -> str:
    """Two people change cities, with so many hops of fuel."""
    levels = range(5)
    return f"""(define (problem z) (:domain fuel)
(:objects plane - aircraft ann bob - person x y z - city {" ".join(f"l{i}" for i in levels)} - level)
(:init (at plane x) (at ann y) (at bob z) {" ".join(f"(next l{i} l{i + 1})" for i in levels[:-1])} (fuel plane l{tank}))
(:goal (and (at ann z) (at bob y))))"""


LIGHTS = """(define (domain lights) (:requirements :negative-preconditions)
(:predicates (l1) (l2) (l3))
(:action a1 :precondition (and (not (l1)) (not (l2))) :effect (and (l1) (l2)))
(:action a2 :precondition (and (l1) (not (l2))) :effect (and (not (l1)) (l2)))
(:action a3 :precondition (and (not (l1)) (l2)) :effect (and (l1) (not (l2))))
(:action a4 :precondition (and (l1) (l2)) :effect (and (not (l1)) (not (l2))))
(:action b1 :precondition (and (not (l2)) (not (l3))) :effect (and (l2) (l3)))
(:action b2 :precondition (and (l2) (not (l3))) :effect (and (not (l2)) (l3)))
(:action b3 :precondition (and (not (l2)) (l3)) :effect (and (l2) (not (l3))))
(:action b4 :precondition (and (l2) (l3)) :effect (and (not (l2)) (not (l3)))))"""

BRIDGES = """(define (domain bridges) (:predicates (at ?x) (bridge ?x ?y) (gold ?x) (got))
(:action cross :parameters (?x ?y) :precondition (and (at ?x) (bridge ?x ?y))
 :effect (and (at ?y) (not (at ?x)) (not (bridge ?x ?y))))
(:action take :parameters (?x) :precondition (and (at ?x) (gold ?x)) :effect (got)))"""


def bridges(extra: str) -> str:
    """Whoever crosses to d first never gets the gold of c."""
    return f"""(define (problem b) (:domain bridges) (:objects a b c d)
(:init (at a) (bridge a b) (bridge a d) (bridge b c) {extra} (gold c)) (:goal (and (got) (at d))))"""


PUZZLE = """(define (domain puzzle) (:requirements :typing) (:types tile pos)
(:predicates (at ?t - tile ?p - pos) (blank ?p - pos) (adj ?a ?b - pos))
(:action slide :parameters (?t - tile ?a ?b - pos) :precondition (and (at ?t ?a) (blank ?b) (adj ?a ?b))
 :effect (and (at ?t ?b) (blank ?a) (not (at ?t ?a)) (not (blank ?b)))))"""


def puzzle(tiles: str, width: int) -> str:
    """Tiles as digits row by row, 0 the blank; in order they are to stand, the blank last."""
    cells = range(len(tiles))
    adj = [
        f"(adj p{a} p{b})"
        for a in cells
        for b in cells
        if abs(a - b) == width or (abs(a - b) == 1 and a // width == b // width)
    ]
    lie = [f"(at t{t} p{i})" if t != "0" else f"(blank p{i})" for i, t in enumerate(tiles)]
    want = [f"(at t{i + 1} p{i})" for i in cells[:-1]]
    return (
        f"(define (problem p) (:domain puzzle) (:objects {' '.join(f't{i}' for i in cells[1:])} - tile"
        f" {' '.join(f'p{i}' for i in cells)} - pos)\n(:init {' '.join(adj)} {' '.join(lie)})\n"
        f"(:goal (and {' '.join(want)})))"
    )


VISIT = """(define (domain visit-all) (:requirements :typing) (:types place - object)
(:predicates (connected ?x ?y - place) (at-robot ?x - place) (visited ?x - place))
(:action move :parameters (?from ?to - place) :precondition (and (at-robot ?from) (connected ?from ?to))
 :effect (and (at-robot ?to) (not (at-robot ?from)) (visited ?to))))"""


def grid(n: int) -> str:
    """All cells of a square, from the middle."""
    cells = [(x, y) for x in range(n) for y in range(n)]
    ways = [f"(connected l{a}-{b} l{c}-{d})" for a, b in cells for c, d in cells if abs(a - c) + abs(b - d) == 1]
    return (
        f"(define (problem g) (:domain visit-all) (:objects {' '.join(f'l{x}-{y}' for x, y in cells)} - place)\n"
        f"(:init (at-robot l{n // 2}-{n // 2}) (visited l{n // 2}-{n // 2}) {' '.join(ways)})\n"
        "(:goal (forall (?p - place) (visited ?p))))"
    )


DRAWN = "#######\n#  .  #\n# $@$.#\n#     #\n#######"
CORNER = "######\n#$   #\n#  @.#\n######"
CHORES = """(define (domain chores)
(:requirements :equality :typing :negative-preconditions :disjunctive-preconditions)
(:types room item) (:constants hub - ROOM)
(:predicates (here ?r - room) (has ?i - item) (in ?i - item ?r - room) (dirty ?r - room))
(:action go :parameters (?a ?b - room)
 :precondition (and (here ?a) (not (= ?a ?b)) (or (= ?a hub) (= ?b hub))) :effect (and (not (here ?a)) (here ?b)))
(:action clean :parameters (?r - room) :precondition (and (here ?r) (dirty ?r) (not (= ?r hub)))
 :effect (not (dirty ?r)))
(:action clean-hub :parameters (?r ?i) :precondition (and (here hub) (= ?r hub) (has ?i) (dirty ?r))
 :effect (and (not (dirty ?r)) (not (has ?i))))
(:action get :parameters (?i - item ?r - room) :precondition (and (here ?r) (in ?i ?r))
 :effect (and (has ?i) (not (in ?i ?r)))))"""
CHORE = """(define (problem e) (:domain chores) (:objects r1 r2 r3 - room mop - item)
(:init (here r1) (dirty r1) (dirty r2) (dirty hub) (in mop r3))
(:goal (and (not (dirty r1)) (not (dirty r2)) (not (dirty hub)) (not (here hub))
 (not (exists (?i - item) (has ?i))))))"""

FLAVOURS: dict[str, tuple[str, str, str]] = {
    "hanoi": (HANOI, hanoi(4), "SUCCESS"),
    "sokoban": (SOKOBAN, sokoban(DRAWN), "SUCCESS"),
    "sokoban, a box in the corner": (SOKOBAN, sokoban(CORNER), "UNSOLVABLE"),
    "child-snack": (SNACK, snack("(no-gluten-bread b1) (no-gluten-bread b3)"), "SUCCESS"),
    "child-snack, a bread too few": (SNACK, snack("(no-gluten-bread b2)"), "UNSOLVABLE"),
    "fuel": (FUEL, flight(4), "SUCCESS"),
    "fuel, too little": (FUEL, flight(2), "UNSOLVABLE"),
    "lights": (LIGHTS, "(define (problem x) (:domain lights) (:init (l1)) (:goal (and (not (l1)) (l3))))", "SUCCESS"),
    "lights, an odd number": (
        LIGHTS,
        "(define (problem x) (:domain lights) (:init (l1)) (:goal (and (not (l1)) (not (l2)) (not (l3)))))",
        "UNSOLVABLE",
    ),
    "bridges that break": (BRIDGES, bridges("(bridge c a)"), "SUCCESS"),
    "bridges, no way back": (BRIDGES, bridges(""), "UNSOLVABLE"),
    "sliding tiles": (PUZZLE, puzzle("123405786", 3), "SUCCESS"),
    "sliding tiles, two swapped": (PUZZLE, puzzle("210453", 3), "UNSOLVABLE"),
    "visit all": (VISIT, grid(4), "SUCCESS"),
    "chores": (CHORES, CHORE, "SUCCESS"),
}
