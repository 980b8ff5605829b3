"""PCD files that pypcd4 writes: organised ones with VIEWPOINT, and those of a lidar with rings.

Needs numpy and pypcd4.
"""

from pathlib import Path

import numpy as np
from pypcd4 import Encoding, PointCloud
from room import View, views

POINTS = True

# 32-bit numbers of up to 8 m are off by 0.24 µm on each axis, decimals of text by half a micrometre.
SINGLE = 2e-6
# Doubles are the numbers of the reference; poses differ by the rounding of quaternions.
EXACT = 1e-6


def viewpoint(pose: np.ndarray) -> tuple[float, ...]:
    """tx ty tz qw qx qy qz."""
    # The quaternion is the eigenvector of the largest eigenvalue (Bar-Itzhack, 2000).
    ((a, b, c), (d, e, f), (g, h, i)) = pose[:3, :3]
    matrix = [
        [a - e - i, b + d, c + g, h - f],
        [b + d, e - a - i, f + h, c - g],
        [c + g, f + h, i - a - e, d - b],
        [h - f, c - g, d - b, a + e + i],
    ]
    x, y, z, w = np.linalg.eigh(np.array(matrix))[1][:, -1]
    return (*map(float, pose[:3, 3]), *map(float, (w, x, y, z)))


def organised(view: View, kind: type) -> PointCloud:
    """All pixels row by row, NaN where missing."""
    rows, cols = view.valid.shape
    cloud = PointCloud.from_points(view.points.reshape(-1, 3), ("x", "y", "z"), (kind,) * 3)
    cloud.metadata.width, cloud.metadata.height = cols, rows
    cloud.metadata.viewpoint = viewpoint(view.pose)
    return cloud


def rotating(view: View) -> PointCloud:
    """The returns alone, in any order, with their rings."""
    order = np.random.default_rng(1).permutation(int(view.valid.sum()))
    rings = np.nonzero(view.valid)[0][order].astype(np.uint16)
    x, y, z = view.points[view.valid][order].T
    cloud = PointCloud.from_points(
        (x, y, z, rings), ("x", "y", "z", "ring"), (np.float64,) * 3 + (np.uint16,)
    )
    cloud.metadata.viewpoint = viewpoint(view.pose)
    return cloud


def write(room: Path, out: Path) -> list[tuple[Path, list[str], float]]:
    """Writes the room; returns paths of scans, further arguments, and tolerances in metres."""
    kinds = {
        "text": (lambda view: organised(view, np.float32), Encoding.ASCII, SINGLE),
        "binary": (lambda view: organised(view, np.float64), Encoding.BINARY, EXACT),
        "compressed": (lambda view: organised(view, np.float32), Encoding.BINARY_COMPRESSED, SINGLE),
        "rings": (rotating, Encoding.BINARY_COMPRESSED, EXACT),
    }
    scans = []
    for name, (make, encoding, tolerance) in kinds.items():
        folder = out / name
        folder.mkdir()
        for number, view in enumerate(views(room)):
            make(view).save(folder / f"{number}.pcd", encoding)
        scans.append((folder, [], tolerance))
    return scans
