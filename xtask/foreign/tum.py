"""Depth sequences in the layouts of TUM RGB-D and ScanNet, with images that imageio writes.

The images are 16-bit grey: TUM as PNG with 5000 counts a metre, ScanNet as PNG with 1000. A third
folder has the layout of TUM with TIFF images of 32-bit floating-point numbers, which lose nothing.
Tolerances hold for 99 of 100 nodes; ends of curves at silhouettes can move by a pixel's footprint.
Needs numpy and imageio.
"""

import json
from pathlib import Path

import imageio.v3 as imageio
import numpy as np

# Further arguments of `transect simulate room`: the formats hold pinhole cameras only.
SIMULATE = ["--sensor", "pinhole"]

# Half a count is the largest error of a rounded depth. A curve on a surface seen at 60 degrees
# moves by twice that. Measured: 99 % of the nodes are within half a count. Doubled, a camera whose
# centre is off by a pixel passes.
INCIDENCE = 2.0


def views(room: Path) -> list[dict]:
    """The views of a simulated room: depth in metres, pose, and the keys of the manifest."""
    manifest = json.loads((room / "scan.json").read_text())
    wrong = [view["file"] for view in manifest["views"] if view["sensor"] != "pinhole"]
    if wrong:
        raise SystemExit(f"{room}: {wrong[0]} is no pinhole image; simulate with {SIMULATE}")
    for view in manifest["views"]:
        view["depth"] = np.load(room / view["file"])
        view["pose"] = np.reshape(view["pose"], (4, 4))
    return manifest["views"]


def counts(depth: np.ndarray, per_metre: float) -> np.ndarray:
    """Depths as 16-bit counts; 0 where there is none."""
    return np.round(np.nan_to_num(depth) * per_metre).astype(np.uint16)


def quaternion(pose: np.ndarray) -> list[float]:
    """The rotation as x, y, z, w: the eigenvector of Bar-Itzhack's matrix."""
    r = pose[:3, :3]
    k = np.array([
        [r[0, 0] - r[1, 1] - r[2, 2], 0, 0, 0],
        [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], 0, 0],
        [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], 0],
        [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
    ])
    return list(np.linalg.eigh(k)[1][:, -1])


def tum(room: Path, out: Path, extension: str, image) -> Path:
    """A folder with depth.txt, groundtruth.txt and ETH3D's calibration.txt."""
    (out / "depth").mkdir(parents=True)
    names, poses = ["# timestamp filename"], ["# timestamp tx ty tz qx qy qz qw"]
    for k, view in enumerate(views(room)):
        time = 1305031102.0 + k / 30
        name = f"depth/{time:.6f}.{extension}"
        imageio.imwrite(out / name, image(view["depth"]))
        names.append(f"{time:.6f} {name}")
        numbers = [*view["pose"][:3, 3], *quaternion(view["pose"])]
        poses.append(" ".join([f"{time:.6f}", *(f"{n:.9f}" for n in numbers)]))
    (out / "depth.txt").write_text("\n".join(names) + "\n")
    (out / "groundtruth.txt").write_text("\n".join(poses) + "\n")
    (out / "calibration.txt").write_text(" ".join(str(view[k]) for k in ("fx", "fy", "cx", "cy")))
    return out


def scannet(room: Path, out: Path) -> Path:
    """A folder with depth/N.png, pose/N.txt and intrinsic/intrinsic_depth.txt."""
    for name in ("depth", "pose", "intrinsic"):
        (out / name).mkdir(parents=True)
    for k, view in enumerate(views(room)):
        imageio.imwrite(out / f"depth/{k}.png", counts(view["depth"], 1000))
        np.savetxt(out / f"pose/{k}.txt", view["pose"], fmt="%.9f")
    matrix = np.diag([view["fx"], view["fy"], 1, 1])
    matrix[:2, 2] = view["cx"], view["cy"]
    np.savetxt(out / "intrinsic/intrinsic_depth.txt", matrix)
    return out


def write(room: Path, out: Path) -> list[tuple[Path, list[str], float]]:
    """Writes the room; returns paths of scans, further arguments, and tolerances in metres."""
    room, out = Path(room), Path(out)
    pngs = tum(room, out / "tum", "png", lambda depth: counts(depth, 5000))
    tiffs = tum(room, out / "tum_float", "tiff", np.nan_to_num)
    return [
        (pngs, [], INCIDENCE * 0.5 / 5000),
        # Poses are printed with nine digits: a nanometre at each metre of distance.
        (tiffs, [], 1e-8),
        (scannet(room, out / "scannet"), [], INCIDENCE * 0.5 / 1000),
    ]
