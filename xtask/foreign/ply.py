"""PLY files that plyfile writes: rows and columns in three ways, and lidars with and without rings.

Needs numpy and plyfile.
"""

from pathlib import Path

import numpy as np
from plyfile import PlyData, PlyElement
from room import View, views

POINTS = True

# Doubles are the numbers of the reference.
EXACT = 1e-6


def table(points: np.ndarray, **fields: np.ndarray) -> PlyElement:
    """An element vertex."""
    columns = dict(zip("xyz", points.reshape(-1, 3).T)) | fields
    data = np.empty(len(columns["x"]), [(name, values.dtype) for name, values in columns.items()])
    for name, values in columns.items():
        data[name] = values
    return PlyElement.describe(data, "vertex")


def size(view: View) -> list[str]:
    rows, cols = view.valid.shape
    return [f"num_rows {rows}", f"num_cols {cols}"]


def row_by_row(view: View) -> PlyData:
    return PlyData([table(view.points)], obj_info=size(view), byte_order=">")


def bare(view: View) -> PlyData:
    return PlyData([table(view.points)], byte_order="<")


def range_grid(view: View) -> PlyData:
    """The valid points, and a list of none or one of them for each cell."""
    numbers = np.cumsum(view.valid.reshape(-1)) - 1
    cells = np.empty(view.valid.size, [("vertex_indices", object)])
    for cell, (valid, number) in enumerate(zip(view.valid.reshape(-1), numbers)):
        cells["vertex_indices"][cell] = np.array([number] if valid else [], dtype=np.int32)
    grid = PlyElement.describe(cells, "range_grid", len_types={"vertex_indices": "u1"})
    return PlyData([table(view.points[view.valid]), grid], obj_info=size(view), byte_order="<")


def firings(view: View) -> PlyData:
    """Column by column, 0 0 0 where missing: the elevations alone tell the lasers."""
    return PlyData([table(np.nan_to_num(view.points).transpose(1, 0, 2))], byte_order="<")


def rings(view: View) -> PlyData:
    """The returns alone, with their rings, as CloudCompare names them."""
    row = np.nonzero(view.valid)[0].astype(np.float32)
    return PlyData([table(view.points[view.valid], scalar_ring=row)], text=True)


def write(room: Path, out: Path) -> list[tuple[Path, list[str], float]]:
    """Writes the room; returns paths of scans, further arguments, and tolerances in metres."""
    found = views(room)
    rows, cols = found[0].valid.shape
    arguments = {"bare": ["--grid", f"{rows}x{cols}"]}
    scans = []
    for make in (row_by_row, bare, range_grid, firings, rings):
        folder = out / make.__name__
        folder.mkdir()
        # KITTI's form: one line of 3 × 4 numbers for each file.
        np.savetxt(folder / "poses.txt", [view.pose[:3].reshape(-1) for view in found], "%.17g")
        for number, view in enumerate(found):
            make(view).write(folder / f"{number}.ply")
        scans.append((folder, arguments.get(make.__name__, []), EXACT))
    return scans
