"""Words by which a phrase of a request begins, goes on, or ends."""

from __future__ import annotations

__all__ = [
    "AT",
    "CLAUSE",
    "DOWN",
    "ENDING",
    "EXACTLY",
    "FETCHING",
    "INDEFINITE",
    "LONGEST",
    "MASS",
    "MODAL",
    "ONTO",
    "OPENING",
    "OTHERS",
    "POINTING",
    "PUTTING",
    "STANDING",
    "STRESSING",
    "TELLING",
]

POINTING = frozenset({"the", "that", "this", "my", "your", "her", "his", "our", "their"})
INDEFINITE = frozenset({"a", "an", "some", "one"})
EXACTLY = frozenset({"the", "all", "these", "those", "both"})
TELLING = frozenset({
    "left", "right", "next", "beside", "behind", "front", "between", "nearest", "closest", "near", "above", "below",
    "nearer", "closer", "farthest", "furthest", "under", "underneath", "beneath", "top", "first", "second", "third",
    "last", "other", "same", "remaining", "rest", "that", "which", "whose", "who", "with", "in", "standing", "lying",
    "sitting", "by", "over", "whichever", "nobody", "you", "i", "we",
})  # fmt: skip
STANDING = frozenset({
    "that", "which", "is", "are", "thats", "whats", "stands", "standing", "right", "directly", "just",
    "lies", "lying", "sits", "sitting", "currently", "now", "still",
    "located", "stored", "placed", "already", "what", "waiting", "kept", "resting", "parked", "sat",
})  # fmt: skip
CLAUSE = frozenset({
    "that", "which", "thats", "whats", "stands", "standing", "lies", "lying", "sits", "sitting", "currently", "now",
    "located", "stored", "placed", "already", "from", "off",
})  # fmt: skip
"""Words after a noun that say where a thing is, and not where it is to go."""
MODAL = frozenset({"must", "should", "has", "needs", "ought", "goes", "shall", "may", "can", "will", "belongs"})
AT = frozenset({"on", "in", "at", "from", "of", "off"})
DOWN = frozenset({"down", "up", "over", "out", "back"})
ENDING = frozenset({"on", "onto", "in", "into", "at", "from", "to", "and", ",", ".", "then", "over"})
ONTO = frozenset({"on", "onto", "in", "into", "to", "next", "beside", "between", "above", "below"})
MASS = frozenset({"cargo", "good", "everything", "stuff"})
PUTTING = frozenset({"put", "place", "set", "move", "lay", "position", "stand", "shift", "drop", "stow", "store"})
FETCHING = frozenset({"pick", "take", "bring", "get", "fetch", "grab", "give", "hand", "want", "need", "collect"})
OPENING = frozenset({".", ",", ";", ":", "!", "?", "and", "then"})
OTHERS = frozenset({"they", "theyre", "she", "shes", "he", "hes", "theyve", "theyll", "somebody", "someone"})
"""Who else wants or does something: what is said of them orders nothing."""
STRESSING = frozenset({"very", "absolute", "absolutely", "single", "actual"})
LONGEST = 5
