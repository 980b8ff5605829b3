"""Depth sequences that Open3D writes: PNG images, trajectories `.log` and `.json`, camera JSON.

Needs numpy and open3d.
"""

import shutil
from pathlib import Path

import numpy as np
import open3d as o3d
from tum import INCIDENCE, SIMULATE, counts, views

__all__ = ["SIMULATE", "write"]


def write(room: Path, out: Path) -> list[tuple[Path, list[str], float]]:
    """Writes the room; returns paths of scans, further arguments, and tolerances in metres."""
    out = Path(out)
    log, json = out / "open3d_log", out / "open3d_json"
    (log / "depth").mkdir(parents=True)
    trajectory, parameters = o3d.camera.PinholeCameraTrajectory(), []
    for k, view in enumerate(views(Path(room))):
        # Contiguous counts: Open3D takes the memory as it is.
        image = o3d.geometry.Image(np.ascontiguousarray(counts(view["depth"], 1000)))
        assert o3d.io.write_image(str(log / f"depth/{k:06}.png"), image)
        one = o3d.camera.PinholeCameraParameters()
        one.intrinsic = o3d.camera.PinholeCameraIntrinsic(
            view["cols"], view["rows"], view["fx"], view["fy"], view["cx"], view["cy"]
        )
        one.extrinsic = np.linalg.inv(view["pose"])
        parameters.append(one)
    trajectory.parameters = parameters
    # The .json holds the camera, too. The .log has poses alone.
    shutil.copytree(log, json)
    assert o3d.io.write_pinhole_camera_trajectory(str(json / "trajectory.json"), trajectory)
    assert o3d.io.write_pinhole_camera_trajectory(str(log / "trajectory.log"), trajectory)
    camera = parameters[0].intrinsic
    assert o3d.io.write_pinhole_camera_intrinsic(str(log / "intrinsic.json"), camera)
    tolerance = INCIDENCE * 0.5 / 1000
    return [(log, [], tolerance), (json, [], tolerance)]
