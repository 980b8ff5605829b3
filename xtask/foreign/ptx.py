"""PTX files. No free program writes them, so this module does, as numpy prints numbers.

Needs numpy.
"""

from pathlib import Path

import numpy as np
from room import View, views

POINTS = True

# Coordinates are printed with six decimals, as Leica's programs print them: off by half a
# micrometre. The nodes move by up to three times that. Doubled, coarser printing passes.
PRINTED = 2e-6


def text(numbers: np.ndarray) -> str:
    return " ".join(f"{n:.12g}" for n in numbers)


def write_scan(file, view: View, scanner: np.ndarray, colours: bool, scale: float) -> None:
    """One scan: header, then points column by column, 0 0 0 where nothing came back."""
    rows, cols = view.valid.shape
    # Rows are multiplied from the left, so the matrix is the transpose of the pose.
    axes, place = view.pose[:3, :3].T, view.pose[:3, 3]
    print(cols, rows, text(scanner), *map(text, axes), sep="\n", file=file)
    for axis in axes * scale:
        print(text(axis), 0, file=file)
    print(text(place), 1, file=file)
    points = np.nan_to_num(view.points).transpose(1, 0, 2).reshape(-1, 3) / scale
    tail = " 0.5 10 20 30" if colours else " 0.5"
    decimals = 6 if scale == 1 else 3
    for point in points:
        print(*(f"{c:.{decimals}f}" if c else "0" for c in point), end=tail + "\n", file=file)


def write(room: Path, out: Path) -> list[tuple[Path, list[str], float]]:
    """Writes the room; returns paths of scans, further arguments, and tolerances in metres."""
    scans = []
    kinds = [("plain", False, 1), ("colours", True, 1), ("millimetres", True, 1e-3)]
    kinds.append(("world", False, 1))
    for name, colours, scale in kinds:
        path = out / f"{name}.ptx"
        with path.open("w") as file:
            for view in views(room):
                written = view.in_world() if name == "world" else view
                write_scan(file, written, view.pose[:3, 3], colours, scale)
        scans.append((path, [], PRINTED))
    return scans
