"""Legal domains that importers stumble over, each with a problem, written for these tests."""

from __future__ import annotations

LOGISTICS = (
    """;;;; logistics without types: everything is a predicate, in CAPITALS, spread over lines
(DEFINE (DOMAIN LOGISTICS-STRIPS)
(:REQUIREMENTS :STRIPS)
(:PREDICATES (OBJ ?OBJ) (TRUCK ?T)
  (LOCATION ?L)(AIRPLANE ?A)(CITY ?C)(AIRPORT ?A)
             (AT ?O ?L) (IN ?O1 ?O2) (IN-CITY ?O ?C))
(:ACTION LOAD-TRUCK
 :PARAMETERS (?OBJ ?TRUCK ?LOC)
 :PRECONDITION (AND (OBJ ?OBJ) (TRUCK ?TRUCK) (LOCATION ?LOC) (AT ?TRUCK ?LOC) (AT ?OBJ ?LOC))
 :EFFECT (AND (NOT (AT ?OBJ ?LOC)) (IN ?OBJ ?TRUCK)))
(:ACTION LOAD-AIRPLANE :PARAMETERS (?OBJ ?PLANE ?LOC)
 :PRECONDITION (AND (OBJ ?OBJ) (AIRPLANE ?PLANE) (LOCATION ?LOC) (AT ?OBJ ?LOC) (AT ?PLANE ?LOC))
 :EFFECT (AND (NOT (AT ?OBJ ?LOC)) (IN ?OBJ ?PLANE)))
(:ACTION UNLOAD-TRUCK :PARAMETERS (?OBJ ?TRUCK ?LOC)
 :PRECONDITION (AND (OBJ ?OBJ) (TRUCK ?TRUCK) (LOCATION ?LOC) (AT ?TRUCK ?LOC) (IN ?OBJ ?TRUCK))
 :EFFECT (AND (NOT (IN ?OBJ ?TRUCK)) (AT ?OBJ ?LOC)))
(:ACTION UNLOAD-AIRPLANE :PARAMETERS (?OBJ ?PLANE ?LOC)
 :PRECONDITION (AND (OBJ ?OBJ) (AIRPLANE ?PLANE) (LOCATION ?LOC) (IN ?OBJ ?PLANE) (AT ?PLANE ?LOC))
 :EFFECT (AND (NOT (IN ?OBJ ?PLANE)) (AT ?OBJ ?LOC)))
(:ACTION DRIVE-TRUCK :PARAMETERS (?TRUCK ?FROM ?TO ?CITY)
 :PRECONDITION (AND (TRUCK ?TRUCK) (LOCATION ?FROM) (LOCATION ?TO) (CITY ?CITY) (AT ?TRUCK ?FROM)
                    (IN-CITY ?FROM ?CITY) (IN-CITY ?TO ?CITY))
 :EFFECT (AND (NOT (AT ?TRUCK ?FROM)) (AT ?TRUCK ?TO)))
(:ACTION FLY-AIRPLANE :PARAMETERS (?PLANE ?FROM ?TO)
 :PRECONDITION (AND (AIRPLANE ?PLANE) (AIRPORT ?FROM) (AIRPORT ?TO) (AT ?PLANE ?FROM))
 :EFFECT (AND (NOT (AT ?PLANE ?FROM)) (AT ?PLANE ?TO))))
""",
    """(define (problem p) (:domain logistics-strips)
(:objects plane1 truck1 truck2 pgh bos pgh-po bos-po pgh-air bos-air pack1 pack2)
(:init (OBJ pack1) (obj PACK2) (airplane plane1) (truck truck1) (truck truck2) (city pgh) (city bos)
  (location pgh-po) (location bos-po) (location pgh-air) (location bos-air) (airport pgh-air) (airport bos-air)
  (in-city pgh-po pgh) (in-city pgh-air pgh) (in-city bos-po bos) (in-city bos-air bos)
  (at plane1 bos-air) (at truck1 pgh-air) (at truck2 bos-po) (at pack1 pgh-po) (at pack2 bos-air))
(:goal (and (at pack1 bos-po) (at pack2 pgh-air))))
""",
)

GRIPPER = (
    """(define(domain gripper-strips)
   (:predicates(room ?r)(ball ?b)(gripper ?g)(at-robby ?r)(at ?b ?r)(free ?g)(carry ?o ?g))
   (:action move
       :parameters  (?from ?to)
       :precondition (and  (room ?from) (room ?to) (at-robby ?from))
       :effect (and  (at-robby ?to)
\t\t     (not (at-robby ?from))))
   (:action pick :parameters (?obj ?room ?gripper)
       :effect (and (carry ?obj ?gripper) (not (at ?obj ?room)) (not (free ?gripper)))
       :precondition (and (ball ?obj) (room ?room) (gripper ?gripper) (at ?obj ?room) (at-robby ?room) (free ?gripper)))
   (:action drop :parameters (?obj  ?room ?gripper)
       :precondition(and(ball ?obj)(room ?room)(gripper ?gripper)(carry ?obj ?gripper)(at-robby ?room))
       :effect(and(at ?obj ?room)(free ?gripper)(not(carry ?obj ?gripper)))))
""",
    """(define (problem strips-gripper-x-1) (:domain gripper-strips)
   (:objects rooma roomb ball4 ball3 ball2 ball1 left right)
   (:init (room rooma) (room roomb) (ball ball4) (ball ball3) (ball ball2) (ball ball1) (at-robby rooma)
          (free left) (free right) (at ball4 rooma) (at ball3 rooma) (at ball2 rooma) (at ball1 rooma)
          (gripper left) (gripper right))
   (:goal (and (at ball4 roomb) (at ball3 roomb) (at ball2 roomb) (at ball1 roomb))))
""",
)

FERRY = (
    """; comments ; in comments (and parentheses (in them
(define (domain ferry)
  (:requirements :strips :equality)   ; not-eq is spelt out
  (:predicates (not-eq ?x ?y) (car ?c) (location ?l) (at-ferry ?l) (at ?c ?l) (empty-ferry) (on ?c))
  (:action sail :parameters (?from ?to)
    :precondition (and (not-eq ?from ?to) (location ?from) (location ?to) (at-ferry ?from))
    :effect (and (at-ferry ?to) (not (at-ferry ?from))))
  (:action board :parameters (?car ?loc)
    :precondition (and (car ?car) (location ?loc) (at ?car ?loc) (at-ferry ?loc) (empty-ferry))
    :effect (and (on ?car) (not (at ?car ?loc)) (not (empty-ferry))))
  (:action debark :parameters (?car ?loc)
    :precondition (and (car ?car) (location ?loc) (on ?car) (at-ferry ?loc))
    :effect (and (at ?car ?loc) (empty-ferry) (not (on ?car)))))
""",
    """(define (problem f) (:domain ferry) (:objects l0 l1 l2 c0 c1 c2)
(:init (location l0)(location l1)(location l2)(car c0)(car c1)(car c2)
(not-eq l0 l1)(not-eq l1 l0)(not-eq l0 l2)(not-eq l2 l0)(not-eq l1 l2)(not-eq l2 l1)
(empty-ferry)(at c0 l0)(at c1 l1)(at c2 l2)(at-ferry l2))
(:goal (and(at c0 l1)(at c1 l2)(at c2 l0))))
""",
)

SATELLITE = (
    """(define (domain satellite)
  (:requirements :typing)
  (:types satellite direction instrument mode)
  (:predicates (on_board ?i - instrument ?s - satellite) (supports ?i - instrument ?m - mode)
    (pointing ?s - satellite ?d - direction) (power_avail ?s - satellite) (power_on ?i - instrument)
    (calibrated ?i - instrument) (have_image ?d - direction ?m - mode)
    (calibration_target ?i - instrument ?d - direction))
  (:action turn_to :parameters (?s - satellite ?d_new - direction ?d_prev - direction)
    :precondition (and (pointing ?s ?d_prev) (not (= ?d_new ?d_prev)))
    :effect (and (pointing ?s ?d_new) (not (pointing ?s ?d_prev))))
  (:action switch_on :parameters (?i - instrument ?s - satellite)
    :precondition (and (on_board ?i ?s) (power_avail ?s))
    :effect (and (power_on ?i) (not (calibrated ?i)) (not (power_avail ?s))))
  (:action switch_off :parameters (?i - instrument ?s - satellite)
    :precondition (and (on_board ?i ?s) (power_on ?i))
    :effect (and (not (power_on ?i)) (power_avail ?s)))
  (:action calibrate :parameters (?s - satellite ?i - instrument ?d - direction)
    :precondition (and (on_board ?i ?s) (calibration_target ?i ?d) (pointing ?s ?d) (power_on ?i))
    :effect (calibrated ?i))
  (:action take_image :parameters (?s - satellite ?d - direction ?i - instrument ?m - mode)
    :precondition (and (calibrated ?i) (on_board ?i ?s) (supports ?i ?m) (power_on ?i) (pointing ?s ?d) (power_on ?i))
    :effect (have_image ?d ?m)))
""",
    """(define (problem strips-sat-x-1) (:domain satellite)
(:objects satellite0 - satellite instrument0 instrument1 - instrument image1 spectrograph2 thermograph0 - mode
  Star0 GroundStation1 GroundStation2 Phenomenon3 Phenomenon4 Star5 Phenomenon6 - direction)
(:init (supports instrument0 thermograph0) (supports instrument1 image1) (supports instrument1 spectrograph2)
  (calibration_target instrument0 GroundStation2) (calibration_target instrument1 Star0)
  (on_board instrument0 satellite0) (on_board instrument1 satellite0) (power_avail satellite0)
  (pointing satellite0 Phenomenon6))
(:goal (and (have_image Phenomenon4 thermograph0) (have_image Star5 image1) (have_image phenomenon6 SPECTROGRAPH2)
  (pointing satellite0 star0))))
""",
)

MICONIC = (
    """(define (domain miconic)
  (:requirements :strips)
  (:types passenger - object
          floor - object)
  (:predicates
(origin ?person - passenger ?floor - floor)
(destin ?person - passenger ?floor - floor)
(above ?floor1 - floor  ?floor2 - floor)
(boarded ?person - passenger)
(served ?person - passenger)
(lift-at ?floor - floor)
)
(:action board :parameters (?f - floor ?p - passenger)
  :precondition (and (lift-at ?f) (origin ?p ?f)) :effect (boarded ?p))
(:action depart :parameters (?f - floor ?p - passenger)
  :precondition (and (lift-at ?f) (destin ?p ?f) (boarded ?p)) :effect (and (not (boarded ?p)) (served ?p)))
(:action up :parameters (?f1 - floor ?f2 - floor)
  :precondition (and (lift-at ?f1) (above ?f1 ?f2)) :effect (and (lift-at ?f2) (not (lift-at ?f1))))
(:action down :parameters (?f1 - floor ?f2 - floor)
  :precondition (and (lift-at ?f1) (above ?f2 ?f1)) :effect (and (lift-at ?f2) (not (lift-at ?f1)))))
""",
    """(define (problem mixed-f4-p2) (:domain miconic)
(:objects p0 p1 - passenger f0 f1 f2 f3 - floor)
(:init (above f0 f1) (above f0 f2) (above f0 f3) (above f1 f2) (above f1 f3) (above f2 f3)
  (origin p0 f3) (destin p0 f2) (origin p1 f1) (destin p1 f3) (lift-at f0))
(:goal (forall (?p - passenger) (served ?p))))
""",
)

SWITCHES = (
    """(define (domain switches) (:requirements :adl)
  (:predicates (on ?s) (next ?a ?b) (broken ?s))
  (:action toggle-on :parameters (?s) :precondition (and (not (on ?s)) (not (broken ?s))) :effect (on ?s))
  (:action toggle-off :parameters (?s) :precondition (not (or (not (on ?s)) (broken ?s))) :effect (not (on ?s)))
  (:action spread :parameters (?a ?b)
    :precondition (and (on ?a) (or (next ?a ?b) (next ?b ?a)) (not (= ?a ?b)) (imply (broken ?b) (on ?a)))
    :effect (and (on ?b) (not (on ?a)))))
""",
    """(define (problem s) (:domain switches) (:objects a b c d)
  (:init (next a b) (next b c) (next c d) (on a) (broken d))
  (:goal (and (or (and (on a) (on c)) (on d)) (not (on b)) (exists (?x) (and (on ?x) (broken ?x))))))
""",
)

ROOMS = (
    """(define (domain rooms)
  (:requirements :strips :typing :equality :negative-preconditions :disjunctive-preconditions)
  (:types room thing - object box key - thing)
  (:constants hall - room master - key)
  (:predicates (in ?t - thing ?r - room) (here ?r - room) (held ?t - thing) (locked ?r - room) (empty))
  (:action go :parameters (?from ?to - room)
    :precondition (and (here ?from) (not (= ?from ?to)) (or (= ?from hall) (= ?to hall)) (not (locked ?to)))
    :effect (and (here ?to) (not (here ?from))))
  (:action take :parameters (?t - (either box key) ?r - room)
    :precondition (and (here ?r) (in ?t ?r) (empty)) :effect (and (held ?t) (not (in ?t ?r)) (not (empty))))
  (:action put :parameters (?t - thing ?r - room)
    :precondition (and (here ?r) (held ?t) (not (= ?r hall)))
    :effect (and (in ?t ?r) (not (held ?t)) (empty)))
  (:action lay-down :parameters (?t - thing ?r - room)
    :precondition (and (here ?r) (held ?t) (= ?r hall)) :effect (and (in ?t ?r) (not (held ?t)) (empty)))
  (:action open :parameters (?k - key ?r - room)
    :precondition (and (here hall) (held ?k) (= ?k master) (locked ?r)) :effect (not (locked ?r))))
""",
    """(define (problem r) (:domain rooms) (:objects cellar attic - room b1 b2 - box other - key)
  (:init (in b1 attic) (in b2 hall) (in master attic) (in other hall) (here cellar) (locked attic) (empty)
         (not (locked cellar)))
  (:goal (and (in b2 cellar) (or (= hall cellar) (held other)) (not (in other hall)))))
""",
)

TWINS = (
    """(define (domain twins) (:requirements :strips :equality)
  (:predicates (p ?x) (q ?x ?y))
  (:action same :parameters (?x ?y) :precondition (and (p ?x) (= ?x ?y)) :effect (q ?x ?y))
  (:action is_same :parameters (?x ?y) :precondition (and (q ?x ?x) (not (= ?y ?x))) :effect (and (q ?x ?y) (p ?y))))
""",
    """(define (problem t) (:domain twins) (:objects a b c) (:init (p a)) (:goal (and (q b c) (q c c))))
""",
)

HYDRA = (
    """(define (domain x-1.0_hydra) (:requirements :strips :negative-preconditions)
  (:predicates (?) (a.b) (xml) (Sequence) (_))
  (:action Fallback :parameters () :precondition () :effect (and (a.b) (not (?))))
  (:action script :precondition (and (a.b) (not (xml))) :effect (xml))
  (:action 2nd :parameters () :precondition (and (xml) (and (a.b) (and))) :effect (and (and (sequence)) (_))))
""",
    """(define (problem h) (:domain x-1.0_hydra) (:init (?)) (:goal (and (SEQUENCE) (and (_)) (not (?)))))
""",
)

DEPOTS = (
    """(define (domain Depot)
(:requirements :typing)
(:types place locatable - object
\tdepot distributor - place
        truck hoist surface - locatable
        pallet crate - surface)
(:predicates (at ?x - locatable ?y - place)
             (on ?x - crate ?y - surface)
             (in ?x - crate ?y - truck)
             (lifting ?x - hoist ?y - crate)
             (available ?x - hoist)
             (clear ?x - surface))
(:action Drive
:parameters (?x - truck ?y - place ?z - place)
:precondition (and (at ?x ?y))
:effect (and (not (at ?x ?y)) (at ?x ?z)))
(:action Lift
:parameters (?x - hoist ?y - crate ?z - surface ?p - place)
:precondition (and (at ?x ?p) (available ?x) (at ?y ?p) (on ?y ?z) (clear ?y))
:effect (and (not (at ?y ?p)) (lifting ?x ?y) (not (clear ?y)) (not (available ?x)) (clear ?z) (not (on ?y ?z))))
(:action Drop
:parameters (?x - hoist ?y - crate ?z - surface ?p - place)
:precondition (and (at ?x ?p) (at ?z ?p) (clear ?z) (lifting ?x ?y))
:effect (and (available ?x) (not (lifting ?x ?y)) (at ?y ?p) (not (clear ?z)) (clear ?y)(on ?y ?z)))
(:action Load
:parameters (?x - hoist ?y - crate ?z - truck ?p - place)
:precondition (and (at ?x ?p) (at ?z ?p) (lifting ?x ?y))
:effect (and (not (lifting ?x ?y)) (in ?y ?z) (available ?x)))
(:action Unload
:parameters (?x - hoist ?y - crate ?z - truck ?p - place)
:precondition (and (at ?x ?p) (at ?z ?p) (available ?x) (in ?y ?z))
:effect (and (not (in ?y ?z)) (not (available ?x)) (lifting ?x ?y))))
""",
    """(define (problem depotprob1818) (:domain Depot)
(:objects depot0 - Depot distributor0 distributor1 - Distributor truck0 truck1 - Truck pallet0 pallet1 pallet2 - Pallet
\tcrate0 crate1 - Crate hoist0 hoist1 hoist2 - Hoist)
(:init (at pallet0 depot0) (clear crate1) (at pallet1 distributor0) (clear crate0) (at pallet2 distributor1)
\t(clear pallet2) (at truck0 distributor1) (at truck1 depot0) (at hoist0 depot0) (available hoist0)
\t(at hoist1 distributor0) (available hoist1) (at hoist2 distributor1) (available hoist2)
\t(at crate0 distributor0) (on crate0 pallet1) (at crate1 depot0) (on crate1 pallet0))
(:goal (and (on crate0 pallet2) (on crate1 pallet1))))
""",
)

ODD = (
    """(DEFINE (DOMAIN Odd.Names@1)
(:Requirements :STRIPS :Typing :Equality)
(:Types Switch - object A&B - Thing-1 Action _x - switch)
(:constants C'est - a&b <tag> - THING-1 x:y - thing-1 lamp.1 - SWITCH)
(:Predicates (at%x ?x - thing-1 ?y - thing-1) (p"q ?a) (->) (name ?id) (on=off ?x) (lit ?s - switch))
(:action Go/To! :parameters (?x.1 - a&b ?y:2 - thing-1) :precondition (and (at%x ?x.1 <tag>) (not (= ?x.1 ?y:2)))
 :effect (and (at%x ?x.1 ?y:2) (not (at%x ?x.1 <TAG>)) (p"q ?y:2) (->) (name ?x.1)))
(:action switch :parameters (?switch - switch) :precondition (->) :effect (lit ?switch))
(:action name :parameters (?name) :precondition (and (->) (name ?name)) :effect (on=off ?name)))
""",
    """(define (problem Odd-Problem) (:domain odd.names@1)
(:objects Ünïcode - a&b 日本 - Thing-1 1 - thing-1 -neg - A&B s1 - ACTION s2 - _X and - Switch)
(:init (at%x Ünïcode <tag>) (at%x c'est <TAG>) (at%x -neg <tag>))
(:goal (and (at%x ünïcode 日本) (at%x C'EST x:y) (at%x -neg 1) (on=off -neg) (forall (?s - switch) (lit ?s)))))
""",
)

AWKWARD = {
    "logistics": LOGISTICS,
    "gripper": GRIPPER,
    "ferry": FERRY,
    "satellite": SATELLITE,
    "miconic": MICONIC,
    "switches": SWITCHES,
    "rooms": ROOMS,
    "twins": TWINS,
    "hydra": HYDRA,
    "depots": DEPOTS,
    "odd": ODD,
}
