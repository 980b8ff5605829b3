"""E57 files that libE57 writes, through pye57: Cartesian, spherical, doubles, scaled integers.

Needs numpy, pye57 and pyquaternion (which pye57 brings).
"""

from pathlib import Path

import numpy as np
import pye57
from pye57 import libe57
from pyquaternion import Quaternion
from room import View, views

POINTS = True

# Metres per count of the scaled integers, as terrestrial scanners' programs choose it.
STEP = 1e-4
# A rounded coordinate is off by half a step on each axis. Measured: 99 % of the nodes are within
# 0.7 steps. Doubled, a pose that is off by one step passes.
ROUNDED = STEP
# 32-bit numbers of up to 8 m are off by 0.24 µm on each axis.
SINGLE = 2e-6
# Doubles differ by the rounding of sines and cosines, and poses by that of quaternions.
EXACT = 1e-9


def field(file, kind: str, name: str):
    """The type of a field, as libE57 has it."""
    if name.endswith("Index"):
        return libe57.IntegerNode(file, 0, 0, 100_000)
    if kind == "double":
        return libe57.FloatNode(file, 0.0, libe57.FloatPrecision.E57_DOUBLE, -1e3, 1e3)
    return libe57.ScaledIntegerNode(file, 0, -(2**24), 2**24, STEP, 0.0)


def coordinates(view: View, spherical: bool) -> dict[str, np.ndarray]:
    """The valid records of a view; missing pixels are absent."""
    x, y, z = view.points[view.valid].T
    if not spherical:
        return {"cartesianX": x, "cartesianY": y, "cartesianZ": z}
    reach = np.sqrt(x * x + y * y + z * z)
    return {
        "sphericalRange": reach,
        # Beyond ±π: programs differ in where they begin to count.
        "sphericalAzimuth": np.arctan2(y, x) + 2 * np.pi,
        "sphericalElevation": np.arcsin(z / reach),
    }


def structure(file, **nodes):
    """A structure of floating-point numbers, integers and other nodes."""
    node = libe57.StructureNode(file)
    for name, value in nodes.items():
        if isinstance(value, float):
            value = libe57.FloatNode(file, value)
        elif isinstance(value, int):
            value = libe57.IntegerNode(file, value)
        node.set(name, value)
    return node


def pose(view: View) -> tuple[np.ndarray, np.ndarray]:
    """The quaternion w x y z and the translation."""
    # Poses of the manifest are rotations within the rounding of doubles.
    return Quaternion(matrix=view.pose[:3, :3], rtol=1e-9, atol=1e-9).elements, view.pose[:3, 3]


def add(e57: pye57.E57, number: int, view: View, spherical: bool, kind: str) -> None:
    """Adds a scan of doubles or scaled integers, which pye57's own function does not write."""
    file = e57.image_file
    rows, cols = np.nonzero(view.valid)
    data = {**coordinates(view, spherical), "rowIndex": rows, "columnIndex": cols}
    (w, x, y, z), (tx, ty, tz) = (map(float, part) for part in pose(view))
    size = view.valid.shape
    scan = structure(
        file,
        guid=libe57.StringNode(file, f"{{{number}}}"),
        name=libe57.StringNode(file, f"setup {number}"),
        pose=structure(
            file,
            rotation=structure(file, w=w, x=x, y=y, z=z),
            translation=structure(file, x=tx, y=ty, z=tz),
        ),
        indexBounds=structure(
            file, rowMinimum=0, rowMaximum=size[0] - 1, columnMinimum=0, columnMaximum=size[1] - 1
        ),
    )
    prototype = structure(file, **{name: field(file, kind, name) for name in data})
    points = libe57.CompressedVectorNode(file, prototype, libe57.VectorNode(file, True))
    scan.set("points", points)
    e57.data3d.append(scan)
    arrays, buffers = e57.make_buffers(list(data), len(rows))
    for name, values in data.items():
        arrays[name][:] = values
    writer = points.writer(buffers)
    writer.write(len(rows))
    writer.close()


def write_singles(e57: pye57.E57, view: View) -> None:
    """Adds a scan with pye57's own function: 32-bit numbers, invalid records, column by column."""
    points = np.nan_to_num(view.points).transpose(1, 0, 2).reshape(-1, 3)
    cols, rows = np.indices(view.valid.T.shape).reshape(2, -1)
    invalid = np.where(view.valid.T.reshape(-1), 0, 2).astype(np.int8)
    rotation, translation = pose(view)
    data = dict(zip(["cartesianX", "cartesianY", "cartesianZ"], points.T))
    data |= {"rowIndex": rows, "columnIndex": cols, "cartesianInvalidState": invalid}
    e57.write_scan_raw(data, rotation=rotation, translation=translation)


def write(room: Path, out: Path) -> list[tuple[Path, list[str], float]]:
    """Writes the room; returns paths of scans, further arguments, and tolerances in metres."""
    scans = []
    for spherical in (False, True):
        for kind in ("double", "scaled"):
            # Scaled angles of 0.1 mrad would be too coarse.
            if spherical and kind == "scaled":
                continue
            path = out / f"{'spherical' if spherical else 'cartesian'}_{kind}.e57"
            e57 = pye57.E57(str(path), mode="w")
            for number, view in enumerate(views(room)):
                add(e57, number, view, spherical, kind)
            e57.close()
            scans.append((path, [], EXACT if kind == "double" else ROUNDED))
    # Points in the world's frame with a pose that moves nothing: the viewpoint is found again.
    path = out / "world.e57"
    e57 = pye57.E57(str(path), mode="w")
    for number, view in enumerate(views(room)):
        add(e57, number, view.in_world(), spherical=False, kind="double")
    e57.close()
    scans.append((path, [], EXACT))
    path = out / "singles.e57"
    e57 = pye57.E57(str(path), mode="w")
    for view in views(room):
        write_singles(e57, view)
    e57.close()
    return [*scans, (path, [], SINGLE)]
