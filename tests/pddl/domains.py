"""Classic domains with a problem each, written for these tests."""

from __future__ import annotations

BLOCKS = (
    """
; blocks world with four actions, without types, in mixed case
(define (domain Blocks)
  (:requirements :STRIPS)
  (:predicates (on ?x ?y) (ontable ?x) (clear ?x) (handempty) (holding ?x))
  (:action Pick-Up :parameters (?x)
    :precondition (and (CLEAR ?x) (ontable ?x) (handempty))
    :effect (and (not (ontable ?x)) (not (clear ?x)) (not (handempty)) (holding ?x)))
  (:action put-down :parameters (?x)
    :precondition (holding ?x)
    :effect (and (not (holding ?x)) (clear ?x) (handempty) (ontable ?x)))
  (:action stack :parameters (?x ?y)
    :precondition (and (holding ?x) (clear ?y))
    :effect (and (not (holding ?x)) (not (clear ?y)) (clear ?x) (handempty) (on ?x ?y)))
  (:action unstack :parameters (?x ?y)
    :precondition (and (on ?x ?y) (clear ?x) (handempty))
    :effect (and (holding ?x) (clear ?y) (not (clear ?x)) (not (handempty)) (not (on ?x ?y)))))
""",
    """
(define (problem tower) (:domain blocks)
  (:objects A B C D)
  (:init (ontable a) (on b a) (on c b) (clear c) (ontable d) (clear d) (handempty))
  (:goal (and (on a b) (on b c) (on c d))))
""",
)

GRIPPER = (
    """
(define (domain gripper)
  (:requirements :strips :typing)
  (:types room ball gripper)
  (:constants left right - gripper)
  (:predicates (at-robby ?r - room) (at ?b - ball ?r - room) (free ?g - gripper) (carry ?o - ball ?g - gripper))
  (:action move :parameters (?from ?to - room)
    :precondition (at-robby ?from)
    :effect (and (at-robby ?to) (not (at-robby ?from))))
  (:action pick :parameters (?obj - ball ?room - room ?gripper - gripper)
    :precondition (and (at ?obj ?room) (at-robby ?room) (free ?gripper))
    :effect (and (carry ?obj ?gripper) (not (at ?obj ?room)) (not (free ?gripper))))
  (:action drop :parameters (?obj - ball ?room - room ?gripper - gripper)
    :precondition (and (carry ?obj ?gripper) (at-robby ?room))
    :effect (and (at ?obj ?room) (free ?gripper) (not (carry ?obj ?gripper)))))
""",
    """
(define (problem four-balls) (:domain gripper)
  (:objects rooma roomb - room ball1 ball2 ball3 ball4 - ball)
  (:init (at-robby rooma) (free left) (free right)
         (at ball1 rooma) (at ball2 rooma) (at ball3 rooma) (at ball4 rooma))
  (:goal (and (at ball1 roomb) (at ball2 roomb) (at ball3 roomb) (at ball4 roomb))))
""",
)

LOGISTICS = (
    """
(define (domain logistics)
  (:requirements :strips :typing)
  (:types truck airplane - vehicle
          package vehicle - thing
          airport - location
          city location thing - object)
  (:predicates (in-city ?l - location ?c - city) (at ?t - thing ?l - location) (in ?p - package ?v - vehicle))
  (:action drive :parameters (?t - truck ?from ?to - location ?c - city)
    :precondition (and (at ?t ?from) (in-city ?from ?c) (in-city ?to ?c))
    :effect (and (not (at ?t ?from)) (at ?t ?to)))
  (:action fly :parameters (?a - airplane ?from ?to - airport)
    :precondition (at ?a ?from)
    :effect (and (not (at ?a ?from)) (at ?a ?to)))
  (:action load :parameters (?v - (either truck airplane) ?p - package ?l - location)
    :precondition (and (at ?v ?l) (at ?p ?l))
    :effect (and (not (at ?p ?l)) (in ?p ?v)))
  (:action unload :parameters (?v - vehicle ?p - package ?l - location)
    :precondition (and (at ?v ?l) (in ?p ?v))
    :effect (and (not (in ?p ?v)) (at ?p ?l))))
""",
    """
(define (problem two-cities) (:domain logistics)
  (:objects c1 c2 - city a1 a2 - airport p1 p2 - location t1 t2 - truck plane - airplane obj1 obj2 - package)
  (:init (in-city a1 c1) (in-city p1 c1) (in-city a2 c2) (in-city p2 c2)
         (at t1 p1) (at t2 a2) (at plane a2) (at obj1 p1) (at obj2 p2))
  (:goal (and (at obj1 p2) (at obj2 p1))))
""",
)

FERRY = (
    """
(define (domain ferry)
  (:requirements :strips :typing :equality :negative-preconditions :action-costs)
  (:types car location)
  (:predicates (at-ferry ?l - location) (at ?c - car ?l - location) (empty-ferry) (on ?c - car))
  (:functions (total-cost) - number)
  (:action sail :parameters (?from ?to - location)
    :precondition (and (not (= ?from ?to)) (at-ferry ?from))
    :effect (and (at-ferry ?to) (not (at-ferry ?from)) (increase (total-cost) 1)))
  (:action board :parameters (?car - car ?loc - location)
    :precondition (and (at ?car ?loc) (at-ferry ?loc) (empty-ferry))
    :effect (and (on ?car) (not (at ?car ?loc)) (not (empty-ferry))))
  (:action debark :parameters (?car - car ?loc - location)
    :precondition (and (on ?car) (at-ferry ?loc))
    :effect (and (at ?car ?loc) (empty-ferry) (not (on ?car)))))
""",
    """
(define (problem three-cars) (:domain ferry)
  (:objects l1 l2 l3 - location c1 c2 c3 - car)
  (:init (= (total-cost) 0) (at-ferry l1) (empty-ferry) (at c1 l1) (at c2 l2) (at c3 l3))
  (:goal (and (at c1 l2) (at c2 l3) (at c3 l1)))
  (:metric minimize (total-cost)))
""",
)

PAINT = (
    """
; negative preconditions, equality, and names that a tree file would take for something else
(define (domain paint-shop)
  (:requirements :strips :typing :negative-preconditions :equality)
  (:types part colour)
  (:predicates (Sequence ?ID - part) (painted ?name - part ?c - colour) (wet ?_p - part) (paint ?p - part))
  (:action paint :parameters (?name - part ?c - colour)
    :precondition (and (not (wet ?name)) (not (painted ?name ?c)) (Sequence ?name))
    :effect (and (painted ?name ?c) (wet ?name)))
  (:action strip :parameters (?id - part ?c - colour)
    :precondition (and (painted ?id ?c) (not (wet ?id)))
    :effect (not (painted ?id ?c)))
  (:action Inverter :parameters (?p ?q - part)
    :precondition (and (wet ?p) (not (wet ?q)) (not (= ?p ?q)))
    :effect (and (not (wet ?p)) (paint ?p)))
  (:action swap :parameters (?p ?q - part)
    :precondition (and (Sequence ?p) (not (Sequence ?q)) (not (= ?p ?q)))
    :effect (and (not (Sequence ?p)) (Sequence ?q))))
""",
    """
(define (problem two-parts) (:domain paint-shop)
  (:objects p1 p2 - part red blue - colour)
  (:init (sequence p1) (painted p1 blue))
  (:goal (and (painted p1 red) (not (painted p1 blue)) (painted p2 blue) (not (wet p2)))))
""",
)

CLASSICS = {"blocks": BLOCKS, "gripper": GRIPPER, "logistics": LOGISTICS, "ferry": FERRY, "paint": PAINT}
