"""What is remembered of actions that fail: how often and why, and which are left out for now."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from llmbt_atl.state import GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.world import ActionReport, Status

__all__ = ["Failures", "shortfall"]

RETURNS = 5
"""So many times the attempts a state may be come back to by actions that succeed, before the last of them counts as a
failure: whatever undoes them, going on does not help."""
TOLD = 4
"""Of the actions that are left out so many are named."""


def shortfall(action: GroundAction, began: Facts, observed: Facts, report: ActionReport) -> str:
    """Why an action that has ended counts as a failure: its own reason, or what it should have brought about or ended
    and did not; empty for a success. `began` is what was observed when it started."""
    if report.status is not Status.SUCCESS:
        blocked = f", {report.blocker} is in the way" if report.blocker else ""
        return (report.reason or "no reason given") + blocked
    if action.senses:
        return ""
    missing = sorted(action.adds - observed)
    if missing:
        return f"post_not_reached: {missing[0]}"
    left = sorted(action.deletes & began)
    if left and not action.adds - began and observed.issuperset(left):
        return f"post_not_reached: {~left[0]}"
    return ""


@dataclass
class Failures:
    """An action that fails `attempts` times in a row is excluded until something is seen to change about its
    arguments, and for good when that has happened `attempts` times: what fails may itself be what changes them."""

    attempts: int
    excluded: dict[ActionCall, Facts] = field(default_factory=dict)
    last: str = ""
    _in_a_row: Counter[ActionCall] = field(default_factory=Counter)
    _in_all: Counter[ActionCall] = field(default_factory=Counter)
    _reasons: dict[ActionCall, str] = field(default_factory=dict)
    _exclusions: Counter[ActionCall] = field(default_factory=Counter)
    _returns: Counter[Facts] = field(default_factory=Counter)
    _denied: dict[Condition, ActionCall] = field(default_factory=dict)

    def came_back(self, observed: Facts) -> str:
        """Note the state that an action led to; why it is a failure after all where it leads there again and again."""
        self._returns[observed] += 1
        n = self._returns[observed]
        return f"the same state for the {n}th time" if n > RETURNS * self.attempts else ""

    def success(self, call: ActionCall) -> None:
        """Note that an action succeeded."""
        self._in_a_row.pop(call, None)
        self._exclusions.pop(call, None)

    def failure(self, call: ActionCall, reason: str, observed: Facts, denied: Condition | None = None) -> None:
        """Note that an action failed, and the fact that its failure speaks against."""
        if denied is not None:
            self._denied[denied] = call
        self._in_a_row[call] += 1
        self._in_all[call] += 1
        self._reasons[call] = reason
        self.last = f"{call} failed: {reason}"
        if self._in_a_row[call] >= self.attempts:
            self.excluded[call] = observed
            self._exclusions[call] += 1
            del self._in_a_row[call]

    def forgive(self, facts: Facts) -> None:
        """Let an excluded action be tried again once what is known of its arguments has changed."""
        for call, then in list(self.excluded.items()):
            about = {f for f in facts ^ then if set(f.args) & set(call.args)}
            if about and self._exclusions[call] < self.attempts:
                del self.excluded[call]

    def denied_in(self, facts: Facts) -> tuple[Condition, ...]:
        """What failures alone speak against, in a state: it holds for nobody's word that a proof could rest on."""
        self._denied = {c: call for c, call in self._denied.items() if c not in facts}
        return tuple(sorted(self._denied))

    def told_of(self, denied: tuple[Condition, ...]) -> str:
        """Which failures speak against what."""
        said = [
            f"{self._denied[c]} failed ({self._reasons[self._denied[c]]}), so {c} is taken not to hold" for c in denied
        ]
        return f"{'; '.join(said)}, and no plan is left"

    def told(self) -> str:
        """The actions that are left out, each with how often it failed and why at last."""
        said = [f"{c} failed {self._in_all[c]} times ({self._reasons[c]})" for c in list(self.excluded)[:TOLD]]
        rest = len(self.excluded) - len(said)
        whom = "it" if len(self.excluded) == 1 else "them"
        more = f" and {rest} other actions" if rest else ""
        return f"{'; '.join(said)}{more}; without {whom} no plan is left"
