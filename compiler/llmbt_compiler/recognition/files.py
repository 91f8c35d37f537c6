"""Point clouds in files: .ply and .pcd, by Open3D; `capture.json` beside them says what the robot knew of itself."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.headers import shortage
from llmbt_compiler.recognition.open3d import open3d
from llmbt_ir.capture import Capture, Gripper, PointCloud, capture_json, gripper_and_robot
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_ir.versions import write_atomic
from llmbt_ir.xml import read_bytes

__all__ = ["CAPTURE", "SUFFIXES", "read_capture", "write_capture"]

CAPTURE = "capture.json"
SUFFIXES = (".ply", ".pcd")
_FARTHEST = 1e7
"""No coordinate is larger, be it in millimetres."""


def write_capture(folder: Path, clouds: Mapping[str, PointCloud], capture: Capture, suffix: str = ".ply") -> list[Path]:
    """Write one file for each camera's cloud, and `capture.json`."""
    o3d = open3d()
    written = []
    for name, cloud in clouds.items():
        whole = o3d.t.geometry.PointCloud(o3d.core.Tensor(cloud.xyz_m.astype(np.float32)))
        whole.point.colors = o3d.core.Tensor(np.round(cloud.rgb * 255).astype(np.uint8))
        path = folder / f"{name}{suffix}"
        o3d.t.io.write_point_cloud(str(path), whole)
        written.append(path)
    document = capture_json(capture, tuple(p.name for p in written))
    write_atomic(folder / CAPTURE, (json.dumps(document) + "\n").encode())
    return written


def read_capture(paths: tuple[Path, ...]) -> Capture:
    """All points of some files, or of those that a folder's `capture.json` names, with what that says of the robot.

    Errors: E001 a file that cannot be read; E451 one that is no point cloud, or an empty or a torn one; E452 a
    `capture.json` that is none. Where one of the files has no colours, none of them count.
    """
    files: list[Path] = []
    notes: Path | None = None
    for path in paths:
        beside = (path if path.is_dir() else path.parent) / CAPTURE
        if beside.is_file():
            notes = beside
        if path.is_dir():
            files += [path / name for name in _load(beside)["clouds"]]
        else:
            files.append(path)
    read = [_read(f) for f in files]
    cloud, coloured = PointCloud.join([c for c, _ in read]), all(coloured for _, coloured in read)
    gripper, robot = _known(notes) if notes is not None else (None, ())
    return Capture(cloud, robot, gripper, coloured)


def _load(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(read_bytes(path, "capture"))
        if any(Path(name).name != name for name in data["clouds"]):
            raise ValueError("`clouds` are names of files beside it")  # noqa: TRY301
    except (ValueError, KeyError, TypeError) as fault:
        raise _no_capture(path, fault) from None
    return dict(data)


def _known(path: Path) -> tuple[Gripper | None, tuple[NDArray[np.float64], ...]]:
    try:
        return gripper_and_robot(_load(path))
    except (ValueError, KeyError, TypeError) as fault:
        raise _no_capture(path, fault) from None


def _no_capture(path: Path, fault: Exception) -> LlmbtError:
    hint = "write it with `llmbt scene capture`, or take it away: the robot's own points then have to be gone already"
    return LlmbtError(Diagnostic("E452", f"`{path}` is no capture: {fault!r}", Span(str(path)), help=hint))


def _read(path: Path) -> tuple[PointCloud, bool]:
    """The points, and whether they have colours."""
    if path.suffix.lower() not in SUFFIXES:
        raise _no_cloud(path, f"it does not end in {' or '.join(SUFFIXES)}")
    if not path.is_file():
        read_bytes(path, "point cloud")  # which says why not
    data = path.read_bytes()
    if path.suffix.lower() == ".ply" and data[:3] != b"ply":
        raise _no_cloud(path, "it does not begin as one")
    lacks = shortage(data)
    if lacks is not None:
        raise _no_cloud(path, lacks)
    o3d = open3d()
    whole = o3d.t.io.read_point_cloud(str(path))
    if "positions" not in whole.point or not len(whole.point.positions):
        raise _no_cloud(path, "it has no points")
    xyz = whole.point.positions.numpy().astype(np.float64)
    if (np.abs(xyz[np.isfinite(xyz)]) > _FARTHEST).any():
        raise _no_cloud(path, f"it has coordinates beyond {_FARTHEST:g}")
    if "colors" not in whole.point:
        return PointCloud(xyz, np.full((len(xyz), 3), 0.5)), False
    colours = whole.point.colors.numpy()
    scale = 255.0 if colours.dtype == np.uint8 else 65535.0 if colours.dtype == np.uint16 else 1.0
    return PointCloud(xyz, np.clip(colours.astype(np.float64) / scale, 0.0, 1.0)), True


def _no_cloud(path: Path, why: str) -> LlmbtError:
    title = f"`{path}` cannot be read as a point cloud: {why}"
    return LlmbtError(
        Diagnostic("E451", title, Span(str(path)), help="give a .ply or .pcd file with x, y, z and colours")
    )
