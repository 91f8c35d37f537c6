"""The physical world, as a tree's executor sees it (llmbt_runtime.world.World)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Scene
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.arm import Arm, Skill, SkillError
from llmbt_runtime.bullet.base_conditions import BaseConditions
from llmbt_runtime.bullet.bench import Bench
from llmbt_runtime.bullet.camera import Snapshot
from llmbt_runtime.bullet.client import PhysicsError
from llmbt_runtime.bullet.conditions import Conditions, Reading
from llmbt_runtime.bullet.disturbances import Disturber, Moment
from llmbt_runtime.bullet.driving import Driver
from llmbt_runtime.bullet.handling import Hand
from llmbt_runtime.bullet.interventions import Interventions
from llmbt_runtime.bullet.judging import Judge
from llmbt_runtime.bullet.looking import Searcher
from llmbt_runtime.bullet.reporting import Reporter, post_of
from llmbt_runtime.bullet.restore import Memory
from llmbt_runtime.bullet.seen import Seen
from llmbt_runtime.bullet.sensors import BulletSensors
from llmbt_runtime.bullet.skills import Skills
from llmbt_runtime.bullet.stage import Stage
from llmbt_runtime.bullet.terrain import Terrain
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.facts import Change
from llmbt_runtime.perception.eyes import Eyes, Recognise
from llmbt_runtime.world import TICK_S, ActionReport, Disturbed, Status, WorldLostError

__all__ = ["BulletWorld", "Perception"]


@dataclass(frozen=True, slots=True)
class Perception:
    """How a robot comes to know what is where: by recognising what its cameras see, with errors in depth."""

    recognise: Recognise
    noise_m: float = 0.0015


@contextmanager
def _or_lost() -> Iterator[None]:
    """Physics that cannot go on is a world that is lost."""
    try:
        yield
    except PhysicsError as fault:
        raise WorldLostError(f"the physics server: {fault}") from None


def _nobody(_: BulletWorld) -> None:
    """Nobody looks."""


class BulletWorld:
    """A scene in pybullet with its robot. The same scene, seed and calls give the same run, bit for bit.

    With `perception`, the tree's conditions and the skills go by what the robot sees and feels; without, by the truth.
    `watch` is called after every tick, to look.
    """

    def __init__(
        self,
        scene: Scene,
        seed: int = 0,
        disturbances: tuple[DisturbanceSpec, ...] = (),
        goals: tuple[Condition, ...] = (),
        perception: Perception | None = None,
    ) -> None:
        self._stage = Stage(scene)
        self._bench = Bench(scene)
        self._perception = perception
        self._approach = Approach(self._stage)
        terrain = self.terrain = Terrain(self._stage, self._approach, self._bench.kinds)
        judge = self._judge = Judge(self._approach, terrain)
        base = BaseConditions(terrain)
        self._conditions = Conditions(self._stage, self._bench.kinds, judge, base)
        self._reporter = Reporter(scene.with_containers)
        self._sensors: BulletSensors | None = None
        self._seen: Seen | None = None
        self._beliefs = self._conditions
        if perception is not None:
            judge, base = Judge(self._approach, terrain), BaseConditions(terrain)
            self._sensors = self.sensors(perception.noise_m, np.random.default_rng(seed))
            eyes = Eyes(self._sensors, perception.recognise, lambda: self._stage.scene)
            self._seen = Seen(self._bench, self._stage, eyes)
            self._beliefs = Conditions(self._stage, self._bench.kinds, judge, base)
        self._arm = Arm(self._stage, self._seen or self._bench, self._approach)
        hand = Hand(self._arm, self._approach, self._reporter, lambda: self._reading.settled)
        driver = Driver(self._arm, terrain, judge, base, self._reporter)
        self._skills = Skills(hand, driver, Searcher(self._arm, driver, self._seen))
        self._start: Reading = self._conditions.read(self._bench.sensed)
        self._reporter.report(self._start.settled)
        self._bench.remember()
        self._bench.restore()
        self._memory = Memory(
            *(self._stage, terrain, self._judge, self._conditions.base, self._conditions),
            *(judge, base, self._beliefs, self._reporter, self._arm, hand, driver),
        )
        self.watch: Callable[[BulletWorld], None] = _nobody
        self._begin(seed, disturbances, goals)

    def _begin(self, seed: int, disturbances: tuple[DisturbanceSpec, ...], goals: tuple[Condition, ...]) -> None:
        self.goals = goals
        self._truth = self._reading = self._start
        self._skill: Skill | None = None
        self._action: ActionCall | None = None
        self._outcome: ActionReport | None = None
        self._halting = False
        rng = np.random.default_rng(seed)
        here = Interventions(self._stage, self._bench, self._approach, self._judge, self.terrain, goals, rng)
        self._disturber = Disturber(here, rng)
        self._disturber.plan(disturbances)
        if self._seen is not None and self._sensors is not None:
            self._sensors.seed(seed)
            self._seen.begin()
            self._reading = self._believed(self._seen)
            self._reporter.report(self._reading.settled)

    def _believed(self, seen: Seen) -> Reading:
        """What the tree is told: what is unseen is said to be, nothing is at rest while something may have moved."""
        found = self._beliefs.read(seen.sensed)
        unseen = frozenset(Condition("Unseen", (id_,)) for id_ in seen.eyes.unseen)
        return Reading(found.strict | unseen, found.settled | unseen, found.at_rest and not seen.restless)

    def reset(
        self,
        seed: int = 0,
        disturbances: tuple[DisturbanceSpec, ...] = (),
        goals: tuple[Condition, ...] = (),
    ) -> None:
        """Go back to the start, for another trial: what follows is, bit for bit, what a new world would do."""
        if self._skill is not None:
            self._skill.close()
        shifted = self._stage.shifts
        with _or_lost():
            self._memory.recall()
            self._bench.restore()
            if shifted:
                self._bench.move_fixtures(self._stage.scene)
                self._approach.move_fixtures()
            self._begin(seed, disturbances, goals)

    @property
    def scene(self) -> Scene:
        """The scene as it is now: places may have been shifted."""
        return self._stage.scene

    @property
    def time_s(self) -> float:
        """Simulated time since the scene had settled."""
        return self._bench.time_s

    def observe(self) -> Facts:
        """The facts that the tree's conditions see."""
        return self._reporter.last

    def changes(self) -> Change:
        """What `observe` gives now against what it gave when this was last asked: what changed is found where the facts
        are read, which looks at every body anyway."""
        return self._reporter.changes()

    def truth(self) -> Facts:
        """The facts by the physics of this tick alone."""
        return self._truth.strict

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves but the robot and what it holds."""
        return self._reading.at_rest

    def start(self, action: ActionCall) -> None:
        """Begin an action. Precondition: none runs. ValueError for an action, body or place that is not there."""
        if self._skill is not None:
            raise ValueError(f"cannot start {action}: an action is running")
        known = {*self._bench.kinds, *(p.id for p in self.scene.places)}
        if unknown := [a for a in action.args if a not in known]:
            raise ValueError(f"{action}: unknown {', '.join(unknown)}")
        post_of(action)
        self._skill = self._skills.skill(action)
        self._reporter.begin(action)
        self._action = action
        self._outcome, self._halting = None, False
        with _or_lost():
            self._resume()

    def halt(self) -> bool:
        """Ask the running action to stop; True once none runs."""
        if self._skill is None:
            self._outcome = None
            return True
        if not self._reporter.may_halt:
            self._halting = True
            return False
        self._stop()
        return True

    def _stop(self) -> None:
        if self._skill is not None:
            self._skill.close()
        self._skill = None
        with _or_lost():
            self._bench.panda.brake()
            self._bench.base.brake()
        self._end()

    def _end(self) -> None:
        self._halting = False
        self._reporter.end()
        self._reporter.report(self._reading.settled)

    def _resume(self) -> None:
        """Let the skill decide what comes next; note how it ended, if it did."""
        if self._skill is None:
            return
        try:
            next(self._skill)
        except StopIteration:
            self._outcome = ActionReport(Status.SUCCESS)
        except SkillError as fault:
            self._outcome = ActionReport(Status.FAILURE, fault.reason, fault.blocker, fault.denies)
            if fault.denies is not None:
                self._beliefs.deny(fault.denies, (self._seen or self._bench).sensed)
        if self._outcome is not None:
            self._skill = None
            if self._seen is not None:
                self._reading = self._believed(self._seen)

    def advance(self) -> ActionReport:
        """Go on by one tick of 24 physics steps."""
        with _or_lost():
            self._truth = self._reading = self._conditions.read(self._bench.tick())
            if self._seen is not None:
                self._seen.step(in_contact=self._reporter.in_contact)
                self._reading = self._believed(self._seen)
            self._resume()
            report = self._report()
            self._disturber.step(self._moment(report))
        self.watch(self)
        return report

    def _moment(self, report: ActionReport) -> Moment:
        held = self._bench.sensed.held
        ended = self._action if report.status is Status.SUCCESS else None
        return Moment(
            facts=self._truth.strict,
            action=self._action if self._skill is not None else None,
            in_contact=self._reporter.in_contact,
            at_rest=self._truth.at_rest,
            held=held,
            transfer=self._arm.share() if held is not None and self._arm.transferring == held else None,
            ended=ended.name if ended is not None else None,
        )

    def _report(self) -> ActionReport:
        if self._outcome is not None:
            report, self._outcome = self._outcome, None
            self._end()
            return report
        if self._skill is not None and self._halting and self._reporter.may_halt:
            self._stop()
            return ActionReport(Status.IDLE, "halted")
        self._reporter.report(self._reading.settled)
        return ActionReport(Status.IDLE if self._skill is None else Status.RUNNING)

    def settle(self, seconds: float) -> None:
        """Go on without an action. Precondition: none runs."""
        for _ in range(max(1, round(seconds / TICK_S))):
            self.advance()

    def objects(self) -> dict[str, Vec3]:
        """Centre of every body in play."""
        return {id_: s.xyz for id_, s in self._bench.sensed.states.items()}

    def places(self) -> dict[str, Vec3]:
        """Centre of every place's surface; of a container, the middle of the places in it."""
        found = {p.id: p.surface_m for p in self.scene.places if p.surface_m is not None}
        for p in self.scene.places:
            if p.surface_m is None:
                inside = [found[c.id] for c in self.scene.places if c.parent == p.id and c.id in found]
                if inside:
                    n = len(inside)
                    found[p.id] = (
                        sum(c[0] for c in inside) / n,
                        sum(c[1] for c in inside) / n,
                        sum(c[2] for c in inside) / n,
                    )
        return found

    def snapshot(self) -> Snapshot:
        """What a renderer needs."""
        poses = {id_: s.pose for id_, s in self._bench.sensed.states.items()}
        pushed = {f.id: f.xyz_m for f in self.scene.fixtures} if self._stage.shifts else {}
        return Snapshot(self._bench.panda.all_joints(), poses, pushed)

    def sensors(self, noise_m: float, rng: np.random.Generator) -> BulletSensors:
        """What the robot senses with; to be closed by whoever asks."""
        return BulletSensors(self.scene, self._bench, noise_m, rng)

    def disturbances(self) -> tuple[Disturbed, ...]:
        """What has disturbed the world so far."""
        return tuple(self._disturber.log)

    def close(self) -> None:
        """Disconnect from all servers."""
        if self._sensors is not None:
            self._sensors.close()
        self._bench.close()
        self._approach.close()
