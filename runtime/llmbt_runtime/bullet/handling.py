"""Taking a thing and putting it down, with a base that stands still. Generators that are resumed once a tick."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from llmbt_ir.condition import Condition, Facts
from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Scene, ScenePlace
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.arm import FINE_ACCELERATION, FINE_SPEED, TRACKING_LIMIT_RAD, Arm, Skill, SkillError, far
from llmbt_runtime.bullet.bodies import BodyState
from llmbt_runtime.bullet.erecting import Erector, lies
from llmbt_runtime.bullet.grasping import Carried, Grasp, Verdict
from llmbt_runtime.bullet.kinematics import TipPose
from llmbt_runtime.bullet.reporting import Reporter
from llmbt_runtime.bullet.robot import MAX_OPENING_M

__all__ = ["Hand"]

_LIFT_M = 0.06
_LET_GO_ABOVE_M = 0.0015
_CLOSE_TICKS = 9
_SETTLE_TICKS = 15
_WALL_GAP_M = 0.012
_ASKEW = math.sin(math.radians(14))
_REPLAN_M = 0.004
_REPLANS = 4


@dataclass
class Hand:
    """What takes and puts down. `facts` gives the settled facts of the last tick."""

    arm: Arm
    approach: Approach
    reporter: Reporter
    facts: Callable[[], Facts]

    def __post_init__(self) -> None:
        self.bench, self.stage = self.arm.bench, self.arm.stage
        self.erector = Erector(self.arm, self.approach)

    @property
    def scene(self) -> Scene:
        """The scene as it is now."""
        return self.stage.scene

    def take(self, target: str, place: str | None) -> Skill:
        """Take a thing from above; ends with it held, a little above where it was."""
        yield from self.arm.come_to_rest()
        if self.bench.sensed.held is not None:
            raise SkillError("hand_not_empty", self.bench.sensed.held)
        grasp = self.grasp(target)
        for _ in range(_REPLANS):
            self.bench.panda.grip(grasp.opening_m if self._hand_clear() else MAX_OPENING_M)
            yield from self.arm.over(grasp.tip, None)
            planned, grasp = grasp, self.grasp(target)
            if not far(planned.tip, grasp.tip, _REPLAN_M):
                break
        else:
            raise SkillError("moved_since_seen")
        self.bench.panda.grip(grasp.opening_m)
        yield from self.arm.down(grasp.tip, None)
        yield from self._close_and_lift(target, place, grasp)

    def release(self, target: str) -> Skill:
        """Let go of whatever the fingers touch, and withdraw upwards."""
        yield from self.arm.come_to_rest()
        self.reporter.enter_contact(target, ())
        self.bench.panda.grip(MAX_OPENING_M)
        yield from self.arm.wait(4)
        yield from self.arm.up(0.10, FINE_SPEED)
        yield from self.arm.wait(1)
        if self.bench.sensed.touched:
            raise SkillError("not_let_go", self.bench.sensed.touched[0][0])
        self.reporter.leave_contact()

    # ------------------------------------------------------------------ taking

    def grasp(self, target: str) -> Grasp:
        if target not in self.bench.sensed.states:  # it was taken away; who follows a list does not look
            raise SkillError("not_there", target)
        self._mirror()
        verdict = self.approach.grasp(target)
        if verdict.grasp is None:
            raise SkillError("not_approachable", verdict.blocker)
        return verdict.grasp

    def _close_and_lift(self, target: str, place: str | None, grasp: Grasp) -> Skill:
        self.reporter.enter_contact(target, (place,) if place is not None else ())
        bench = self.bench
        bench.panda.grip(0.0)
        for _ in range(_CLOSE_TICKS):
            yield
            if bench.sensed.held == target:
                break
        else:
            yield from self._give_up(grasp)
            raise SkillError("missed")
        away = self._off_the_wall(target, grasp.tip)
        yield from self.arm.line(away, FINE_SPEED, FINE_ACCELERATION, checked=False)
        up = (*away[:2], grasp.tip[2] + _LIFT_M, away[3])
        yield from self.arm.line(up, FINE_SPEED, FINE_ACCELERATION, checked=False)
        if bench.sensed.held != target or bench.panda.tracking_error() > TRACKING_LIMIT_RAD:
            yield from self._give_up(grasp)
            raise SkillError("not_lifted")
        self.arm.carried = self._carried(target, grasp.width_m)
        self.reporter.leave_contact()

    def _off_the_wall(self, target: str, tip: TipPose) -> TipPose:
        """A thing that stands against the side of a fixture is drawn off it first, or it would turn in the hand."""
        e = self._state(target).extent
        x, y, z, yaw = self.bench.base.pose.to_world(tip)
        for f in self.scene.fixtures:
            if f.top_m < e.bottom_m + 0.005 or f.top_m - f.size_m[2] > e.top_m:
                continue
            gaps = [abs(e.centre[i] - f.xyz_m[i]) - e.half[i] - f.size_m[i] / 2 for i in (0, 1)]
            axis = 0 if gaps[0] > gaps[1] else 1
            if -0.005 < gaps[axis] < _WALL_GAP_M:
                side = math.copysign(_WALL_GAP_M - max(0.0, gaps[axis]), e.centre[axis] - f.xyz_m[axis])
                x, y = (x + side, y) if axis == 0 else (x, y + side)
                z = self.bench.base.pose.to_world(tip)[2] + 0.003
        return self.bench.base.pose.to_base(x, y, z, yaw)

    def _give_up(self, grasp: Grasp) -> Skill:
        """Open and withdraw, so that the hand is empty and clear of what it failed to take."""
        self.bench.panda.grip(grasp.opening_m)
        yield from self.arm.wait(3)
        yield from self.arm.up(0.10, FINE_SPEED)
        yield from self.arm.wait(2)

    def askew(self, target: str) -> bool:
        """Whether the held thing is tilted, or its faces are not square to the fingers."""
        if self.bench.sensed.held != target:
            return False
        carried = self._carried(target, 0.0)
        round_ = self.bench.kinds[target].shape in ("cylinder", "sphere")
        return carried.tilted or (not round_ and abs(math.sin(carried.turn_rad)) > _ASKEW)

    def _tilted(self, target: str, state: BodyState) -> bool:
        match self.bench.kinds[target].shape:
            case "sphere":
                return False
            case "cylinder":
                up = abs(state.axes[2][2])
            case _:
                up = max(abs(u) for u in state.axes[2])
        return up < math.sqrt(1 - _ASKEW**2)

    def _carried(self, target: str, width_m: float) -> Carried:
        """How the held thing sits in the hand, as measured."""
        state = self._state(target)
        tx, ty, tz, yaw = self.bench.base.pose.to_world(self.bench.panda.tip())
        dx, dy = state.xyz[0] - tx, state.xyz[1] - ty
        c, s = math.cos(yaw), math.sin(yaw)
        turn = _flat_yaw(state) - yaw
        return Carried(
            id=target,
            along_m=c * dx + s * dy,
            across_m=-s * dx + c * dy,
            below_m=tz - state.xyz[2],
            bottom_below_tip_m=tz - state.extent.bottom_m,
            turn_rad=math.remainder(turn, math.pi / 2),
            width_m=width_m,
            axes=(_turned_back(state, c, s, 0), _turned_back(state, c, s, 1), state.axes[2]),
            tilted=self._tilted(target, state),
        )

    # ------------------------------------------------------------------ putting down

    def put(self, target: str, place: ScenePlace, for_: str | None = None) -> Skill:
        """Put the held thing onto a slot, or onto a free spot of a region, so that `for_` can be taken afterwards."""
        yield from self.arm.come_to_rest()
        if self.bench.sensed.held != target:
            raise SkillError("not_holding", self.bench.sensed.held)
        carried = self.arm.carried = self._carried(target, self.bench.panda.finger_gap())
        if lies(self.bench.kinds[target], self._state(target)) and any(p.id == place.id for p in self.scene.places):
            yield from self._erect(target, place, carried)
            return
        for _ in range(_REPLANS):
            shifts, place = self.stage.shifts, self._now(place)
            (x, y), how = self._choose(carried, place, for_)
            yield from self.arm.over(how.tip, target)
            if shifts == self.stage.shifts:
                break
        else:
            raise SkillError("blocked")
        carried = self.arm.carried = self._carried(target, carried.width_m)
        how = self._still_free(carried, place, x, y, how)
        tip = (*how.tip[:2], how.tip[2] + _LET_GO_ABOVE_M, how.tip[3])
        yield from self.arm.down(tip, target)
        yield from self._let_go(target, place, how)

    def _erect(self, target: str, place: ScenePlace, carried: Carried) -> Skill:
        """Set a cylinder that lies in the hand upright."""
        place = self._now(place)
        self._mirror(without=target)
        how = self.erector.plan(carried, self.bench.kinds[target], place)
        yield from self.arm.over(self.erector.above(how), target)
        yield from self.arm.line(self.erector.above(how), FINE_SPEED, FINE_ACCELERATION, carrying=target)
        self.reporter.enter_contact(target, (place.id,))
        yield from self.erector.set_upright(how)
        yield from self._settled(Condition("On", (target, place.id)))

    def _now(self, place: ScenePlace) -> ScenePlace:
        """A place of the scene where it is by now."""
        return next((p for p in self.scene.places if p.id == place.id), place)

    def _choose(self, carried: Carried, place: ScenePlace, for_: str | None) -> tuple[tuple[float, float], Grasp]:
        """Where on a place the thing goes, and how."""
        self._mirror(without=carried.id)
        yaws = self._yaws(carried, place)
        if place.surface_m is None:
            raise SkillError("no_surface")
        if place.is_slot:
            x, y = place.surface_m[0], place.surface_m[1]
            return (x, y), self._allowed(self.approach.let_go(carried, x, y, place.surface_m[2], yaws))
        found = self.approach.spot(carried, place, yaws, avoid=for_)
        if found is None or found[1].grasp is None:
            raise SkillError("no_free_buffer", denies=Condition("Free", (place.id,)))
        return found[0], found[1].grasp

    def _still_free(self, carried: Carried, place: ScenePlace, x: float, y: float, how: Grasp) -> Grasp:
        """The plan for the last few centimetres, with the world and the hold as they are now."""
        assert place.surface_m is not None
        self._mirror(without=carried.id)
        yaw = how.tip[3] + self.bench.base.pose.yaw_rad
        return self._allowed(self.approach.let_go(carried, x, y, place.surface_m[2], [yaw]))

    @staticmethod
    def _allowed(verdict: Verdict) -> Grasp:
        if verdict.grasp is not None:
            return verdict.grasp
        if verdict.blocker is not None:
            raise SkillError("spot_occupied", verdict.blocker)
        raise SkillError("blocked" if verdict.reachable else "ik_unreachable")

    def _yaws(self, carried: Carried, place: ScenePlace) -> list[float]:
        """Yaws of the fingers that put a thing down square to the place, along its edge first on a slot."""
        edge = self._edge(place)
        any_way_round = self.bench.kinds[carried.id].shape in ("cylinder", "sphere") and not carried.tilted
        turn = 0.0 if any_way_round else carried.turn_rad
        square = [k * math.pi / 2 - turn for k in (0, 1)]
        if place.is_slot:
            return sorted(square, key=lambda y: abs(math.sin(y - edge)))
        tip = self.bench.panda.tip()
        middle = math.pi / 2 + math.atan2(tip[1], tip[0]) + self.bench.base.pose.yaw_rad
        return sorted(square, key=lambda y: round(abs(math.sin(y - middle)), 3))

    def _edge(self, place: ScenePlace) -> float:
        """The direction of the long side of what a slot belongs to: the fingers open along it, past the neighbours."""
        parent = self.scene.place(place.parent) if place.parent is not None else place
        return math.pi / 2 if parent.size_m[1] >= parent.size_m[0] else 0.0

    def _let_go(self, target: str, place: ScenePlace, how: Grasp) -> Skill:
        known = any(p.id == place.id for p in self.scene.places)
        self.reporter.enter_contact(target, (place.id,) if known else ())
        bench = self.bench
        bench.panda.grip(how.opening_m)
        yield from self.arm.wait(3)
        yield from self.arm.up(0.07, FINE_SPEED)
        on = Condition("On", (target, place.id)) if known else Condition("Fallen", (target,))
        yield from self._settled(on)

    def _settled(self, on: Condition) -> Skill:
        """Wait until a thing that was let go stands, and see that it does."""
        bench = self.bench
        for _ in range(_SETTLE_TICKS):
            if on in self.facts() and not bench.sensed.touched:
                break
            yield
        self.arm.carried = None
        self.reporter.leave_contact()
        if bench.sensed.touched:
            raise SkillError("not_let_go", bench.sensed.touched[0][0])
        if on not in self.facts():
            raise SkillError("unstable_after_release")

    # ------------------------------------------------------------------ looking

    def _state(self, id_: str) -> BodyState:
        found = self.bench.sensed.states.get(id_)
        if found is None:
            raise SkillError("unknown_object")
        return found

    def _mirror(self, without: str | None = None) -> None:
        self.approach.stand_at(self.bench.base.pose)
        self.approach.mirror(self.bench.sensed.states, without=without)

    def _hand_clear(self) -> bool:
        """Whether the fingers may open or close where they are without touching anything."""
        return not self.bench.sensed.touched


def _flat_yaw(state: BodyState) -> float:
    """The direction of a body's horizontal axis: whichever of its axes is flattest."""
    columns = [tuple(row[i] for row in state.axes) for i in (0, 1, 2)]
    flattest = min(columns, key=lambda c: (round(abs(c[2]), 3), c))
    return math.atan2(flattest[1], flattest[0])


def _turned_back(state: BodyState, c: float, s: float, row: int) -> Vec3:
    """A row of a body's rotation, seen from a frame that is turned about the vertical."""
    x, y = state.axes[0], state.axes[1]
    a, b, d = ((c * x[i] + s * y[i]) if row == 0 else (-s * x[i] + c * y[i]) for i in (0, 1, 2))
    return a, b, d
