"""Compares scans that other programs write with the scan that Transect simulated.

    python3 -m venv target/foreign
    target/foreign/bin/pip install -r xtask/foreign/requirements.txt
    target/foreign/bin/python xtask/foreign/run.py [FORMAT...]

A FORMAT is one of the modules beside this file; without any, all of them run. The script prints a
table, which `cargo xtask experiments formats` writes into docs/accuracy.md. A format whose Python
modules are missing is skipped and named.

A module FORMAT.py has a function `write(room, out)`. It writes the room in its format into the
folder `out` and returns a list of (path of a scan, further arguments, tolerance in metres). It can
have two constants:

    SIMULATE    further arguments of `transect simulate room`, such as another sensor
    POINTS      True if the format holds points: the room is compared as point grids, because a
                format of points does not tell the angles of its sensor

Both scans are reconstructed at the same planes. Distances run from the nodes of each scan to the
segments of the other, in every plane. 99 % of them must be within the tolerance, because a curve
can end a pixel earlier at a silhouette. Both scans must have curves in the same planes.

TRANSECT names the program; without it, cargo builds it. Needs numpy; each format states its own
needs, and requirements.txt has them all.
"""

import importlib
import json
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import room as simulated

FORMATS = ("e57", "ptx", "tum", "open3d_log", "pcd", "ply")
BUILD = "cargo run --quiet --release -p transect-cli --"
# Differences of the counts of curves: a pixel at a silhouette can split a curve. Chosen by hand.
# Doubled, one lost curve in 25 passes.
SPLIT_CURVES = 0.02
# The same for coordinates in steps of 0.1 mm. The rounding decides whether two pixels of a wall at
# a grazing angle are joined: at x from 4.07 to 4.49 m, y = 5 m. Their columns split the curves of
# 13 planes. Measured: 17 of 342 curves. Doubled, one lost curve in 10 passes.
SPLIT_BY_ROUNDING = {"e57, cartesian_scaled.e57": 0.05}
# Nodes whose distances are computed at once, and the metres within which their nearest segment is
# sought first. Both change the time alone.
BLOCK = 64
NEAR = 0.05


def transect(*arguments: str | Path) -> None:
    program = shlex.split(os.environ.get("TRANSECT", BUILD))
    done = subprocess.run([*program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{shlex.join(map(str, arguments))}:\n{done.stdout}{done.stderr}")


def simulate(folder: Path, arguments: list[str]) -> Path:
    """The room without noise: rounding changes which of several noisy observations make a node.

    The manifest no longer states that there is none, because no other format can.
    """
    transect("simulate", "room", "--noise-free", "--out", folder, *arguments)
    path = folder / "scan.json"
    manifest = json.loads(path.read_text())
    manifest.pop("sigma", None)
    path.write_text(json.dumps(manifest))
    return folder


def sections(scan: Path, arguments: list[str], planes: dict, out: Path) -> dict[int, list]:
    """The curves of each plane, as arrays of points."""
    normal = ",".join(map(str, planes["normal"]))
    at = [f"--normal={normal}", f"--offset={planes['offset']}", f"--interval={planes['interval']}"]
    transect("reconstruct", scan, *at, *arguments, "--out", out, "--quiet")
    found = {}
    for plane in json.loads((out / "contours.json").read_text())["planes"]:
        lines = [closed(line) for line in plane["polylines"]]
        found[round(plane["station"], 9)] = [line for line in lines if len(line) > 1]
    return {station: lines for station, lines in found.items() if lines}


def closed(line: dict) -> np.ndarray:
    points = np.array(line["points"])
    return np.vstack([points, points[:1]]) if line["closed"] else points


def distances(nodes: np.ndarray, lines: list[np.ndarray]) -> np.ndarray:
    """Distance of each node from the nearest segment."""
    start = np.vstack([line[:-1] for line in lines])
    end = np.vstack([line[1:] for line in lines])
    low, high = np.minimum(start, end), np.maximum(start, end)
    found = []
    # Nodes that follow each other are close to each other: segments far from all of them are left
    # out, unless no near one is found.
    for block in np.array_split(nodes, -(-len(nodes) // BLOCK)):
        apart = np.maximum(low - block.max(axis=0), block.min(axis=0) - high).max(axis=1)
        off = nearest(block, start[apart < NEAR], end[apart < NEAR])
        found.append(off if (off < NEAR).all() else nearest(block, start, end))
    return np.concatenate(found)


def nearest(nodes: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of each node from the nearest of segments; infinite if there is none."""
    along = end - start
    length = np.maximum((along**2).sum(axis=1), 1e-30)
    from_start = nodes[:, None] - start
    share = np.clip((from_start * along).sum(axis=2) / length, 0, 1)
    squares = ((share[..., None] * along - from_start) ** 2).sum(axis=2)
    return np.sqrt(squares.min(axis=1, initial=np.inf))


def compare(name: str, wanted: dict, found: dict, tolerance: float) -> bool:
    if wanted.keys() != found.keys():
        differing = sorted(wanted.keys() ^ found.keys())
        print(f"| {name} | planes at {differing} have curves in one of the scans alone | | | |")
        return False
    off = np.concatenate([
        distances(np.vstack(a[station]), b[station])
        for station in wanted for a, b in ((wanted, found), (found, wanted))
    ])
    curves = [sum(map(len, scan.values())) for scan in (wanted, found)]
    median, most = np.median(off), np.quantile(off, 0.99)
    split = SPLIT_BY_ROUNDING.get(name, SPLIT_CURVES)
    fine = most <= tolerance and abs(curves[1] - curves[0]) <= split * curves[0]
    shown = " | ".join(f"{1e3 * length:.6f}" for length in (median, most, off.max(), tolerance))
    print(f"| {name} | {shown} | {'equal' if fine else 'DIFFERENT'} |", flush=True)
    return fine


def run(format_name: str, folder: Path) -> bool:
    try:
        module = importlib.import_module(format_name)
    except ModuleNotFoundError as missing:
        print(f"{format_name}: SKIPPED: {missing}", file=sys.stderr)
        return True
    room = simulate(folder / "room", getattr(module, "SIMULATE", []))
    planes = json.loads((room / "scan.json").read_text())["planes"]
    points = getattr(module, "POINTS", False)
    reference = simulated.write_grid(room, folder / "grid") if points else room
    wanted = sections(reference, [], planes, folder / "wanted")
    scans = folder / "scans"
    scans.mkdir()
    fine = []
    for number, (scan, arguments, tolerance) in enumerate(module.write(room, scans)):
        found = sections(scan, arguments, planes, folder / f"found_{number}")
        name = f"{format_name}, {Path(scan).relative_to(scans)}"
        fine.append(compare(name, wanted, found, tolerance))
    return bool(fine) and all(fine)


def main() -> None:
    fine = True
    print("| file, distances in mm | median | 99 % | largest | allowed | verdict |")
    print("|---|---|---|---|---|---|")
    for name in sys.argv[1:] or FORMATS:
        with tempfile.TemporaryDirectory() as folder:
            fine &= run(name, Path(folder))
    raise SystemExit(0 if fine else 1)


if __name__ == "__main__":
    main()
