"""ALFRED's human annotations against its planner's actions.

ALFRED (Shridhar et al., CVPR 2020; MIT licence) has, for each recorded episode, the planner's high-level actions and,
from several people, one sentence for each of them. That gives steps with a truth that nobody annotated by hand:
``PickupObject(mug)`` beside "Grab the mug from the coffee table".

The rules were drawn up on sentences of the folder ``train`` and fixed before any of ``valid_seen`` or ``valid_unseen``
was read or scored (2026-11-22):

1. A sentence belongs to the action at its place; an annotation with another number of sentences is left out.
2. Scored are PickupObject (action, target), PutObject (action, target, destination) and GotoLocation to a piece of
   furniture (action, destination).
3. NOT_NAMED: a word for one of these does not stand in the sentence (`SYNONYMS`, with ALFRED's class names), or, for a
   place, not right behind a preposition of going or putting. "Put it down", "turn to face the lamp" and "walk to the
   knife on the counter", written for the counter, are such sentences.
4. ELSEWHERE: the sentence puts the thing beside another one ("to the left of the tomato on the counter") or names
   another place first ("in the bowl on the shelf", written for the shelf).
5. OTHER_ACTION: no verb of the action's kind (`VERBS`) stands in it: what the person wrote is not what the planner did.
6. Of the rest, FOUND: an Action keyword that is a verb of the kind, a Target keyword with a word for the object, a
   Destination keyword with a word for the place.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from llmbt_compiler.keywords.labels import Kind, TaggedStep
from llmbt_compiler.parsing.words import lemmas

__all__ = ["VERBS", "Sentence", "Standing", "read_sentences", "standing", "words_of"]

FURNITURE = {
    "ArmChair": "chair armchair recliner", "BathtubBasin": "bathtub tub bath", "Bathtub": "tub bath", "Bed": "",
    "Cabinet": "cupboard", "Cart": "", "CoffeeMachine": "maker machine coffeemaker", "CoffeeTable": "table",
    "CounterTop": "counter countertop bench", "Desk": "table", "DiningTable": "table", "Drawer": "",
    "Dresser": "cabinet", "Fridge": "refrigerator", "GarbageCan": "trash bin garbage can trashcan",
    "HandTowelHolder": "holder rack", "LaundryHamper": "hamper basket", "Microwave": "",
    "Ottoman": "footstool stool", "Safe": "", "Shelf": "shelves rack", "SideTable": "table nightstand stand",
    "Sink": "basin", "SinkBasin": "sink", "Sofa": "couch", "StoveBurner": "stove burner", "TVStand": "stand",
    "Toilet": "", "ToiletPaperHanger": "hanger holder", "TowelHolder": "rack holder",
}  # fmt: skip
SYNONYMS = FURNITURE | {
    "AlarmClock": "clock", "BaseballBat": "bat", "BasketBall": "basketball ball", "Book": "novel",
    "Box": "boxes carton", "Bread": "loaf", "ButterKnife": "knife", "CD": "disc disk",
    "CellPhone": "phone cellphone", "Cloth": "rag towel", "CreditCard": "card", "Cup": "glass mug",
    "DeskLamp": "lamp light", "DishSponge": "sponge", "FloorLamp": "lamp light", "GlassBottle": "bottle",
    "HandTowel": "towel cloth", "KeyChain": "keys key keychain", "Kettle": "teapot pot", "Knife": "blade",
    "Ladle": "spoon", "Laptop": "computer", "Lettuce": "cabbage", "Mug": "cup", "Newspaper": "paper",
    "Pan": "skillet", "PepperShaker": "pepper shaker", "Pillow": "cushion", "Plate": "dish", "Pot": "pan",
    "Potato": "spud", "RemoteControl": "remote", "SaltShaker": "salt shaker", "SoapBar": "soap",
    "SoapBottle": "soap bottle dispenser", "Spatula": "turner", "SprayBottle": "bottle spray",
    "Statue": "figurine sculpture", "TeddyBear": "bear", "TennisRacket": "racket racquet",
    "TissueBox": "tissue tissues box", "ToiletPaper": "paper roll", "Watch": "wristwatch", "WateringCan": "can",
    "WineBottle": "bottle wine",
}  # fmt: skip

VERBS = {
    "PickupObject": frozenset(
        {"pick", "grab", "take", "get", "lift", "remove", "retrieve", "fetch", "collect", "grasp", "hold"}
    ),
    "PutObject": frozenset(
        {
            "put",
            "place",
            "set",
            "drop",
            "lay",
            "insert",
            "leave",
            "store",
            "return",
            "stack",
            "throw",
            "toss",
            "deposit",
        }
        | {"position", "move", "bring", "rest"}
    ),
    "GotoLocation": frozenset(
        {
            "go",
            "walk",
            "turn",
            "move",
            "head",
            "step",
            "cross",
            "carry",
            "bring",
            "take",
            "return",
            "proceed",
            "continue",
        }
        | {"make", "come"}
    ),
}
_GOING = r"(?:to|towards?|into|by|near|before|over)"
_PUTTING = r"(?:in|on|into|onto|inside|to|at)"
_BETWEEN = r"(?:(?!(?:to|of|with|in|on|at|from|face|find|reach|see|where)\b)[\w'-]+\s+){0,4}?"
_BESIDE = (
    r"(?:left|right|side) of|next to|beside|in front of|behind|between|near|by|above|below|under|underneath|against|"
    r"closest to|on top of the|with the other"
)


class Standing(StrEnum):
    """What becomes of a sentence under the rules."""

    FOUND = "found"
    MISSED = "missed"
    NOT_NAMED = "object words not in the text"
    ELSEWHERE = "put at another place first"
    OTHER_ACTION = "another action in the text"


@dataclass(frozen=True, slots=True)
class Sentence:
    """A person's sentence and the action it was written for: its name, the classes of its target and its place."""

    text: str
    action: str
    target: str = ""
    place: str = ""


def words_of(class_name: str) -> frozenset[str]:
    """The words that name a thing of a class: "AlarmClock" is an alarmclock, a clock."""
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", class_name)
    own = {class_name.lower(), *(p.lower() for p in parts[-1:])}
    return frozenset(own | set(SYNONYMS.get(class_name, "").split()))


def read_sentences(folder: Path) -> Iterator[Sentence]:
    """The scored sentences of every ``traj_data.json`` below a folder, in the order of the paths."""
    for path in sorted(folder.rglob("traj_data.json")):
        record = json.loads(path.read_text("utf-8"))
        actions = [a for a in map(_action, record["plan"]["high_pddl"]) if a.action not in {"NoOp", "End"}]
        for annotation in record["turk_annotations"]["anns"]:
            told = annotation["high_descs"]
            if len(told) == len(actions):
                for text, a in zip(told, actions, strict=True):
                    if a.action in VERBS and (a.action != "GotoLocation" or a.place in FURNITURE):
                        yield Sentence(" ".join(text.split()), a.action, a.target, a.place)


def _action(entry: dict[str, Any]) -> Sentence:
    """The action's name and classes, these in the planner's own spelling ("AlarmClock") where it gives one."""
    name, arguments = entry["discrete_action"]["action"], entry["discrete_action"]["args"]
    planned = [v[0] for v in entry.get("planner_action", {}).values() if isinstance(v, list) and v]
    spelled = {str(c).lower(): str(c) for c in (*planned, *SYNONYMS)}
    named = [spelled.get(a, a.capitalize()) for a in arguments] + ["", ""]
    return Sentence("", name, "", named[0]) if name == "GotoLocation" else Sentence("", name, named[0], named[1])


def standing(sentence: Sentence, tagged: TaggedStep) -> Standing:
    """The rules of this module, on one sentence and its keywords."""
    text = sentence.text.lower()
    target, place = words_of(sentence.target), words_of(sentence.place)
    if sentence.target and not _has(text, target):
        return Standing.NOT_NAMED
    needs_place = sentence.action != "PickupObject"
    if needs_place:
        preposition = _PUTTING if sentence.target else _GOING
        named = re.search(rf"\b{preposition}\s+{_BETWEEN}(?:{_any(place)})\b", text)
        if named is None:
            return Standing.NOT_NAMED
        told = re.search(rf"\b(?:{_any(target)})\b", text) if sentence.target else None
        between = text[told.end() : named.start()] if told is not None else ""
        if re.search(rf"\b(?:{_BESIDE}|(?:{_PUTTING})\s+(?:the|a|an|its)\b)", between):
            return Standing.ELSEWHERE
    verbs = VERBS[sentence.action]
    if not any(lemma in verbs for word in re.findall(r"[a-z]+", text) for lemma in lemmas(word)):
        return Standing.OTHER_ACTION
    found = {kind: [s.text.lower() for s in tagged.spans if s.label is kind] for kind in Kind}
    right = any(lemma in verbs for a in found[Kind.ACTION] for lemma in lemmas(a))
    right &= not sentence.target or any(_has(t, target) for t in found[Kind.TARGET])
    right &= not needs_place or any(_has(t, place) for t in found[Kind.DESTINATION])
    return Standing.FOUND if right else Standing.MISSED


def _any(words: Iterable[str]) -> str:
    return "|".join(f"{re.escape(w)}s?" for w in sorted(words))


def _has(text: str, words: Iterable[str]) -> bool:
    return re.search(rf"\b(?:{_any(words)})\b", text) is not None
