"""The simulated room for the writers of formats: its views as points and poses."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass
class View:
    """One view: rows × columns × 3 points in the sensor's frame, NaN where missing; its pose."""

    points: np.ndarray
    pose: np.ndarray

    @property
    def valid(self) -> np.ndarray:
        return np.isfinite(self.points[..., 0])

    def in_world(self) -> "View":
        """The same points in the world's frame, with a pose that moves nothing."""
        return View(self.points @ self.pose[:3, :3].T + self.pose[:3, 3], np.eye(4))


def directions(view: dict) -> np.ndarray:
    """The rays of a spherical sensor, scaled to a range of 1; see docs/sensors.md."""
    theta = view["theta0"] + view["dtheta"] * np.arange(view["cols"])
    phi = (view["phi0"] + view["dphi"] * np.arange(view["rows"]))[:, None]
    x, y, z = np.cos(phi) * np.cos(theta), np.cos(phi) * np.sin(theta), np.sin(phi)
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1)


def views(room: Path) -> list[View]:
    """The views of a room that spherical sensors scanned."""
    found = []
    for view in json.loads((room / "scan.json").read_text())["views"]:
        ranges = np.load(room / view["file"]).astype(float)
        ranges[~(ranges > 0)] = np.nan
        found.append(View(ranges[..., None] * directions(view), np.reshape(view["pose"], (4, 4))))
    return found


def write_grid(room: Path, out: Path) -> Path:
    """The room as a manifest of point grids, in double precision."""
    out.mkdir(parents=True)
    manifest = json.loads((room / "scan.json").read_text())
    for number, (entry, view) in enumerate(zip(manifest["views"], views(room), strict=True)):
        file = f"points_{number}.npy"
        np.save(out / file, view.points)
        manifest["views"][number] = {
            "file": file, "sensor": "grid", "viewpoint": [0, 0, 0], "pose": entry["pose"],
        }
    (out / "scan.json").write_text(json.dumps(manifest))
    return out
