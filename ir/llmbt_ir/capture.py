"""What a robot has sensed at one moment, on its way from the runtime, which captures, to recognition.

Metres, world frame. What the robot knows of itself goes with the points: where its links are, so that they can be told
from the things, and where its fingers meet.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.geometry import Pose

__all__ = ["Capture", "Gripper", "PointCloud", "capture_json", "gripper_and_robot"]

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud:
    """N points. `xyz_m`: N x 3, world frame. `rgb`: N x 3, sRGB in [0, 1]."""

    xyz_m: Points
    rgb: Points

    def __len__(self) -> int:
        return len(self.xyz_m)

    def take(self, which: NDArray[Any]) -> PointCloud:
        """Some of the points, by a mask or by indices."""
        return PointCloud(self.xyz_m[which], self.rgb[which])

    @staticmethod
    def join(clouds: list[PointCloud]) -> PointCloud:
        """All points of several clouds."""
        empty = np.zeros((0, 3))
        return PointCloud(
            np.concatenate([empty, *(c.xyz_m for c in clouds)]), np.concatenate([empty, *(c.rgb for c in clouds)])
        )


@dataclass(frozen=True, slots=True)
class Gripper:
    """The robot's hand by its own sensors. `tip`: the point between the finger tips, world frame, its z axis the
    direction in which the hand points. `gripping`: both fingers press on something."""

    tip: Pose
    gripping: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Capture:
    """A cloud from all cameras, and what the robot knows of itself. `robot`: the vertices (M x 3) of each link, whose
    convex hull encloses it; none where the robot's joints are not known. `coloured`: whether the cloud's colours mean
    something."""

    cloud: PointCloud
    robot: tuple[Points, ...] = field(default=())
    gripper: Gripper | None = None
    coloured: bool = True


def capture_json(capture: Capture, clouds: tuple[str, ...]) -> dict[str, Any]:
    """What goes into `capture.json` beside the files of the clouds; lengths to a tenth of a millimetre."""
    hand = capture.gripper
    return {
        "schema_version": 1,
        "frame": "world",
        "clouds": list(clouds),
        "gripper": hand and {"xyz_m": hand.tip.xyz_m, "quat_xyzw": hand.tip.quat_xyzw, "gripping": hand.gripping},
        "robot_links_m": [np.round(link, 4).tolist() for link in capture.robot],
    }


def gripper_and_robot(data: dict[str, Any]) -> tuple[Gripper | None, tuple[Points, ...]]:
    """The inverse of `capture_json`, but for the clouds. KeyError, TypeError or ValueError where it is none."""
    hand = data["gripper"]
    links = tuple(np.array(link, dtype=np.float64).reshape(-1, 3) for link in data["robot_links_m"])
    if hand is None:
        return None, links
    x, y, z = (float(v) for v in hand["xyz_m"])
    qx, qy, qz, qw = (float(v) for v in hand["quat_xyzw"])
    return Gripper(Pose((x, y, z), (qx, qy, qz, qw)), bool(hand["gripping"])), links
