"""The physics itself: one tick forward, and what was sensed in it. No actions, no conditions."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from llmbt_ir.geometry import IDENTITY_QUAT, Pose, Vec3
from llmbt_ir.scene import Body, Scene
from llmbt_runtime.bullet.bodies import BodyState, extent_of
from llmbt_runtime.bullet.client import BulletClient
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.motion import CONTROL_HZ
from llmbt_runtime.bullet.restore import Memory
from llmbt_runtime.bullet.robot import PHYSICS_HZ, Base, Panda, load_robot
from llmbt_runtime.bullet.scene_builder import add_bodies, add_fixtures, parking_spot
from llmbt_runtime.world import TICK_S

__all__ = ["Bench", "Sensed"]

STEPS_PER_TICK = round(TICK_S * PHYSICS_HZ)
_SUBSTEPS = PHYSICS_HZ // CONTROL_HZ
_GRASP_STEPS = 5
_GRASP_FORCE_N = 1.0
_GRASP_REACH_M = 0.03
_KEEP_REACH_M = 0.05


@dataclass(frozen=True, slots=True)
class Sensed:
    """What the physics shows at the end of a tick. Parked bodies are not in it.

    `held`: both fingers have pressed it with more than 1 N for five steps and it is at the tip. `touched`: bodies that
    a finger touches, with the force in newtons, the strongest first. `supported`: bodies that rest on a fixture.
    `base`: where the arm's base is.
    """

    time_s: float
    states: dict[str, BodyState]
    held: str | None = None
    touched: tuple[tuple[str, float], ...] = ()
    supported: frozenset[str] = field(default_factory=frozenset)
    base: BasePose = field(default=BasePose(0.0, 0.0, 0.0, 0.0))


class Bench:
    """The physics server with everything in it. Bit-identical when the same calls are made again.

    `surprises` counts the bodies that were put somewhere from outside.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.client = client = BulletClient()
        client.setPhysicsEngineParameter(
            fixedTimeStep=1 / PHYSICS_HZ, numSolverIterations=50, deterministicOverlappingPairs=1
        )
        client.setGravity(0, 0, -9.81)
        self.fixtures = add_fixtures(client, scene)
        robot = load_robot(client, scene, visible=False)
        self.panda = Panda(client, robot)
        self.base = Base(client, robot, BasePose.of_scene(scene))
        self.bodies = add_bodies(client, scene)
        self.kinds: dict[str, Body] = {b.id: b for b in (*scene.objects, *scene.obstacles)}
        self.in_play: list[str] = [b.id for b in scene.objects]
        self._names = {body: id_ for id_, body in self.bodies.items()}
        self._fixture_ids = frozenset(self.fixtures.values())
        self._steps = 0
        self._held: str | None = None
        self._slip_ticks = 0
        self.surprises = 0
        for _ in range(STEPS_PER_TICK):
            client.stepSimulation()
        self.sensed = self._sense(None)

    def remember(self) -> None:
        """What `restore` goes back to."""
        self._state: int = self.client.saveState()
        self._memory = Memory(self, self.panda, self.panda.follower, self.base, self.base.follower)

    def restore(self) -> None:
        """Everything as it was when it was remembered, bit for bit in what follows, if it is restored once right away.

        The solver takes contacts in the order in which they came about, and Bullet restores only those of pairs that
        touch: so all bodies are parted first, and brought together from there. Motors are asked anew: arm and base by
        the next tick, which starts their trajectories from the first row.
        """
        self._memory.recall()
        for k, body in enumerate(self.bodies.values()):
            self.client.resetBasePositionAndOrientation(body, (30.0 + 3.0 * k, -50.0, 50.0), (0, 0, 0, 1))
        self.client.performCollisionDetection()
        self.client.restoreState(self._state)
        self.client.performCollisionDetection()
        self.client.restoreState(self._state)
        self.panda.grip(self.panda.opening_m)

    def move_fixtures(self, scene: Scene) -> None:
        """Set the fixtures where a scene has them."""
        for f in scene.fixtures:
            self.client.resetBasePositionAndOrientation(self.fixtures[f.id], f.xyz_m, (0, 0, 0, 1))

    @property
    def time_s(self) -> float:
        """Simulated time since the scene had settled."""
        return self._steps / PHYSICS_HZ

    def tick(self) -> Sensed:
        """One tick of STEPS_PER_TICK steps, the arm on its trajectory."""
        client, panda, base = self.client, self.panda, self.base
        gripping = panda.opening_m < 1e-6
        if self._slip_ticks:
            self._slip_ticks -= 1
            if not self._slip_ticks:
                panda.grip(panda.opening_m)
        grasped: str | None = None
        for i in range(0, STEPS_PER_TICK, _SUBSTEPS):
            panda.command()
            base.command()
            for k in range(_SUBSTEPS):
                client.stepSimulation()
                if gripping and i + k >= STEPS_PER_TICK - _GRASP_STEPS:
                    grasped = self._grasped(grasped, first=i + k == STEPS_PER_TICK - _GRASP_STEPS)
        self._steps += STEPS_PER_TICK
        self.sensed = self._sense(grasped)
        return self.sensed

    def _grasped(self, so_far: str | None, *, first: bool) -> str | None:
        """The body that both fingers press now, if it is the one that they have pressed since the first step."""
        forces = self._finger_forces()
        for id_, (left, right) in sorted(forces.items()):
            if left > _GRASP_FORCE_N and right > _GRASP_FORCE_N and (first or id_ == so_far):
                return id_
        return None

    def _finger_forces(self) -> dict[str, tuple[float, float]]:
        forces: dict[str, list[float]] = {}
        for side, link in enumerate(self.panda.joints.fingers):
            for contact in self.client.getContactPoints(bodyA=self.panda.body, linkIndexA=link):
                name = self._names.get(contact[2])
                if name is not None and contact[8] <= 1e-4:
                    forces.setdefault(name, [0.0, 0.0])[side] += contact[9]
        return {name: (f[0], f[1]) for name, f in forces.items()}

    @property
    def gripping(self) -> bool:
        """Whether both fingers press on something now, by what they feel."""
        return any(min(both) > _GRASP_FORCE_N for both in self._finger_forces().values())

    def state(self, id_: str) -> BodyState:
        """The state of a body now."""
        client, body = self.client, self.bodies[id_]
        xyz, quat = client.getBasePositionAndOrientation(body)
        linear, angular = client.getBaseVelocity(body)
        m = client.getMatrixFromQuaternion(quat)
        axes = ((m[0], m[1], m[2]), (m[3], m[4], m[5]), (m[6], m[7], m[8]))
        speed, spin = math.hypot(*linear), math.hypot(*angular)
        return BodyState(xyz, quat, axes, speed, spin, extent_of(self.kinds[id_], xyz, axes))

    def velocity(self, id_: str) -> Vec3:
        """The linear velocity of a body now, in the world."""
        vx, vy, vz = self.client.getBaseVelocity(self.bodies[id_])[0]
        return vx, vy, vz

    def tip_xyz(self) -> Vec3:
        """Where the tip is, in the world."""
        x, y, z = self.client.getLinkState(self.panda.body, self.panda.joints.tip, computeForwardKinematics=1)[4]
        return x, y, z

    def _sense(self, grasped: str | None) -> Sensed:
        states = {id_: self.state(id_) for id_ in self.in_play}
        if grasped is not None:
            reach = _KEEP_REACH_M if grasped == self._held else _GRASP_REACH_M
            if not self._near_tip(states[grasped], grasped, reach):
                grasped = None
        self._held = grasped
        forces = self._finger_forces()
        touched = sorted(((id_, sum(both)) for id_, both in forces.items()), key=lambda t: (-t[1], t[0]))
        supported: set[str] = set()
        for contact in self.client.getContactPoints():
            a, b = contact[1], contact[2]
            if abs(contact[7][2]) < 0.7 or contact[8] > 0.002:
                continue
            if a in self._fixture_ids and b in self._names:
                supported.add(self._names[b])
            elif b in self._fixture_ids and a in self._names:
                supported.add(self._names[a])
        on = frozenset(supported & set(states))
        return Sensed(self.time_s, states, grasped, tuple(touched), on, self.base.measured())

    def _near_tip(self, state: BodyState, id_: str, reach_m: float) -> bool:
        """Whether the tip is within `reach_m` of the body's centre, along the body's height not counted beyond it."""
        tip = self.tip_xyz()
        lateral = math.hypot(tip[0] - state.xyz[0], tip[1] - state.xyz[1])
        above = abs(tip[2] - state.xyz[2]) - max(0.0, max(self.kinds[id_].size_m) / 2 - reach_m)
        return lateral < reach_m and above < reach_m

    def put(self, id_: str, pose: Pose) -> None:
        """Set a body somewhere, at rest, and into play."""
        body = self.bodies[id_]
        self.client.resetBasePositionAndOrientation(body, pose.xyz_m, pose.quat_xyzw)
        self.client.resetBaseVelocity(body, (0, 0, 0), (0, 0, 0))
        if id_ not in self.in_play:
            self.in_play.append(id_)
        self.surprises += 1

    def slip(self) -> None:
        """The fingers lose their grip: they spring open for two ticks, then close again."""
        self._slip_ticks = 3
        self.panda.slip()

    def park(self, id_: str) -> None:
        """Take a body out of play."""
        index = list(self.kinds).index(id_)
        self.put(id_, Pose(parking_spot(index, self.kinds[id_].size_m[2]), IDENTITY_QUAT))
        self.in_play.remove(id_)

    def others(self, *but: str | None) -> Iterable[tuple[str, BodyState]]:
        """The bodies in play, as last sensed, without some."""
        return ((id_, s) for id_, s in self.sensed.states.items() if id_ not in but)

    def close(self) -> None:
        """Disconnect."""
        self.client.close()
