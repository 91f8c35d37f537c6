"""Planning problems of growing size, as PDDL, and our search alone as a program: for `make bench`."""

from __future__ import annotations

import random
from itertools import pairwise

BLOCKS = """(define (domain blocks)
  (:requirements :strips)
  (:predicates (on ?x ?y) (ontable ?x) (clear ?x) (handempty) (holding ?x))
  (:action pick-up :parameters (?x) :precondition (and (clear ?x) (ontable ?x) (handempty))
    :effect (and (not (ontable ?x)) (not (clear ?x)) (not (handempty)) (holding ?x)))
  (:action put-down :parameters (?x) :precondition (holding ?x)
    :effect (and (not (holding ?x)) (clear ?x) (handempty) (ontable ?x)))
  (:action stack :parameters (?x ?y) :precondition (and (holding ?x) (clear ?y))
    :effect (and (not (holding ?x)) (not (clear ?y)) (clear ?x) (handempty) (on ?x ?y)))
  (:action unstack :parameters (?x ?y) :precondition (and (on ?x ?y) (clear ?x) (handempty))
    :effect (and (holding ?x) (clear ?y) (not (clear ?x)) (not (handempty)) (not (on ?x ?y)))))
"""

PLACES = """(define (domain pick-and-place)
  (:requirements :strips :typing)
  (:types thing place)
  (:predicates (on ?t - thing ?p - place) (free ?p - place) (holding ?t - thing) (handempty))
  (:action pick :parameters (?t - thing ?p - place) :precondition (and (handempty) (on ?t ?p))
    :effect (and (holding ?t) (free ?p) (not (handempty)) (not (on ?t ?p))))
  (:action put :parameters (?t - thing ?p - place) :precondition (and (holding ?t) (free ?p))
    :effect (and (on ?t ?p) (handempty) (not (holding ?t)) (not (free ?p)))))
"""


def blocks_problem(n: int, seed: int) -> str:
    """Random towers to random towers."""
    rng = random.Random(seed)

    def towers() -> list[list[str]]:
        found: list[list[str]] = []
        for b in rng.sample([f"b{i}" for i in range(n)], n):
            k = rng.randrange(len(found) + 1)
            if k == len(found):
                found.append([b])
            else:
                found[k].append(b)
        return found

    def on(ts: list[list[str]]) -> str:
        return " ".join(f"(on {up} {low})" for t in ts for low, up in pairwise(t))

    first, last = towers(), towers()
    ends = " ".join(f"(ontable {t[0]}) (clear {t[-1]})" for t in first)
    names = " ".join(f"b{i}" for i in range(n))
    return (
        f"(define (problem b) (:domain blocks) (:objects {names})\n"
        f"(:init (handempty) {ends} {on(first)})\n(:goal (and {on(last)})))"
    )


def places_problem(n: int, k: int, seed: int) -> str:
    """`n` things on `k` places, each to another place; what is in the way has to go first."""
    rng = random.Random(seed)
    first, last = rng.sample(range(k), n), rng.sample(range(k), n)
    init = " ".join(f"(on t{i} p{p})" for i, p in enumerate(first))
    free = " ".join(f"(free p{p})" for p in range(k) if p not in first)
    goal = " ".join(f"(on t{i} p{p})" for i, p in enumerate(last))
    things, places = " ".join(f"t{i}" for i in range(n)), " ".join(f"p{i}" for i in range(k))
    return (
        f"(define (problem p) (:domain pick-and-place) (:objects {things} - thing {places} - place)\n"
        f"(:init (handempty) {init} {free})\n(:goal (and {goal})))"
    )


OURS = """
import sys, time
from pathlib import Path
from llmbt_atl.pddl import import_domain, import_problem, pddl_call
from llmbt_runtime.search import Plan, search
library = import_domain(Path(sys.argv[1]).read_text(), "d")
p = import_problem(Path(sys.argv[2]).read_text(), library)
start = time.perf_counter()
result = search(p.domain, p.facts, p.goals[0])
spent = time.perf_counter() - start
print("search", spent, "expanded", result.expansions)
if isinstance(result, Plan):
    print("plan length", len(result.actions))
"""
