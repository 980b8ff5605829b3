"""Prints the section of Open3D's VoxelBlockGrid on one plane of a scan, for a picture.

    python xtask/peers/section.py FOLDER PLANE VOXEL

FOLDER has a `scan.json` as `run.py` reads it; VOXEL is an edge in its unit. A line is a piece of
the section: x, y and z of one end in the world, then of the other.
"""

import sys
from pathlib import Path

import numpy as np
import run
import score


def main() -> None:
    folder, plane, voxel = Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    scan = run.load(folder)
    planes = scan["planes"]
    found = score.cut(*run.voxel_blocks(scan, voxel), planes)
    pieces = found.get(plane, np.zeros((0, 2, 2)))
    normal, axes = score.basis(planes["normal"])
    ends = pieces @ axes + (planes["offset"] + plane * planes["interval"]) * normal
    for a, b in ends:
        print(*(f"{c:.5f}" for c in (*a, *b)))


if __name__ == "__main__":
    main()
