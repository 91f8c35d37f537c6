"""The simulated robot's llmbt_runtime.perception.sensors.Sensors: rendered images, joints, finger contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.capture import Gripper
from llmbt_ir.scene import Camera, Scene
from llmbt_runtime.bullet.bench import Bench
from llmbt_runtime.bullet.camera import DepthCameras, Snapshot
from llmbt_runtime.perception.rgbd import RgbdImage, noisy
from llmbt_runtime.perception.rig import cameras_of

__all__ = ["BulletSensors"]


class BulletSensors:
    """What is sensed of a bench. Depths are off by independent Gaussian errors of `noise_m`, drawn from `rng`."""

    def __init__(self, scene: Scene, bench: Bench, noise_m: float, rng: np.random.Generator) -> None:
        self._bench, self._noise_m, self._rng = bench, noise_m, rng
        self._eyes = DepthCameras(scene)
        self.cameras = cameras_of(scene)

    def _snapshot(self) -> Snapshot:
        bench = self._bench
        return Snapshot(bench.panda.all_joints(), {id_: s.pose for id_, s in bench.sensed.states.items()})

    def look(self, camera: Camera, scale: float = 1.0) -> RgbdImage:
        """What a camera sees now."""
        image = self._eyes.look(self._snapshot(), camera, scale)
        return noisy(image, self._noise_m, self._rng) if self._noise_m else image

    def robot(self) -> tuple[NDArray[np.float64], ...]:
        """The links, by the joints."""
        return self._eyes.robot(self._snapshot())

    def gripper(self) -> Gripper:
        """The tip, and whether both fingers press on something."""
        return Gripper(self._eyes.tip(self._bench.panda.all_joints()), self._bench.gripping)

    def close(self) -> None:
        """Give the renderer back."""
        self._eyes.close()
