"""Scores Transect and other programs on the same scans; prints a table, and the times below it.

    python xtask/peers/run.py RESOLUTION,... FOLDER

`cargo xtask experiments peers` writes a folder per scan, and calls this on each. It has the
scans `given` and `smoothed` (images that Transect smoothed), and `given.json` and `smoothed.json`:
Transect's own curves of the given images, without and with its smoothing. Resolutions are edges of
voxels, or of Poisson's finest cells, as shares of the scene's size.

The settings of the other programs are chosen so that none loses what it saw. Distances are
truncated at 4 voxels, at least at 3 sigma. A voxel that was seen once counts. VDBFusion neither
carves space nor fills holes. Poisson gets half a cell between samples, with normals from 30
neighbours in their image. Its surface far from every sample is removed.
"""

import concurrent.futures
import importlib.util
import json
import sys
import time
from pathlib import Path

import numpy as np
import score
import test_score

# Millimetres per unit of a bundled scene.
MILLIMETRES = {"m": 1000.0, "mm": 1.0}
# Poisson's surface farther than this from every sample is removed, as a share of the size. Chosen
# by hand. Doubled, more of what no view saw stays closed; halved, sparsely sampled surface opens.
TRIM = 0.005


def load(folder: Path) -> dict:
    """A scan of pinhole cameras with their depth images (missing pixels are NaN), or of points."""
    scan = json.loads((folder / "scan.json").read_text())
    # Depth cameras state no noise.
    scan["sigma"] = scan.get("sigma") or 0.0
    for view in scan["views"]:
        if "points" in view:
            view["points"] = np.load(folder / view["points"]).astype(float)
            continue
        depth = np.load(folder / view["file"])
        view["depth"] = np.where(depth > 0, depth, np.nan).astype(np.float32)
        view["pose"] = np.reshape(view["pose"], (4, 4))
        view["from"] = view["pose"][:3, 3]
    return scan


def points(view: dict) -> np.ndarray:
    """The valid pixels as points in the world."""
    if "points" in view:
        return view["points"]
    row, col = np.nonzero(np.isfinite(view["depth"]))
    z = view["depth"][row, col].astype(float)
    x, y = (col - view["cx"]) / view["fx"] * z, (row - view["cy"]) / view["fy"] * z
    return np.stack([x, y, z], axis=1) @ view["pose"][:3, :3].T + view["pose"][:3, 3]


def poisson(scan: dict, voxel: float) -> tuple:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud()
    for view in scan["views"]:
        part = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points(view)))
        part = part.voxel_down_sample(voxel / 2)
        part.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(30))
        part.orient_normals_towards_camera_location(view["from"])
        cloud += part
    # Open3D fits a cube of 1.1 times the points' extent around them.
    cells = 1.1 * np.ptp(np.asarray(cloud.points), axis=0).max() / voxel
    depth = max(1, round(np.log2(cells)))
    mesh, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth)
    far = score.cKDTree(cloud.points).query(mesh.vertices)[0] > TRIM * scan["size"]
    mesh.remove_vertices_by_mask(far)
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


def voxel_blocks(scan: dict, voxel: float) -> tuple:
    import open3d as o3d

    core, single = o3d.core, o3d.core.float32
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight"), (single, single), (1, 1), voxel, 8, 20000, core.Device("CPU:0"))
    truncation = max(4.0, 3 * scan["sigma"] / voxel)
    for view in scan["views"]:
        image = o3d.t.geometry.Image(core.Tensor(np.nan_to_num(view["depth"])[..., None]))
        # Open3D rounds pixels down, so its pixels' centres are half a pixel farther.
        camera = core.Tensor([[view["fx"], 0, view["cx"] + 0.5], [0, view["fy"], view["cy"] + 0.5],
                              [0, 0, 1]], core.float64)
        seen_from = image, camera, core.Tensor(np.linalg.inv(view["pose"])), 1.0, 1e6, truncation
        grid.integrate(grid.compute_unique_block_coordinates(*seen_from), *seen_from)
    mesh = grid.extract_triangle_mesh(0.5)
    return mesh.vertex.positions.numpy().astype(float), mesh.triangle.indices.numpy()


def vdbfusion(scan: dict, voxel: float) -> tuple:
    import vdbfusion as vdb

    volume = vdb.VDBVolume(voxel, max(4 * voxel, 3 * scan["sigma"]), False)
    for view in scan["views"]:
        volume.integrate(points(view), np.asarray(view["from"], float))
    vertices, faces = volume.extract_triangle_mesh(False, 0.0)
    return np.asarray(vertices), np.asarray(faces)


PEERS = (("Poisson", "open3d", poisson), ("VoxelBlockGrid", "open3d", voxel_blocks),
         ("VDBFusion", "vdbfusion", vdbfusion))


def sections(fuse, folder: Path, share: float) -> tuple[dict, float]:
    """The sections by another program, and the seconds until it has its mesh."""
    scan = load(folder)
    start = time.perf_counter()
    mesh = fuse(scan, share * scan["size"])
    seconds = time.perf_counter() - start
    return score.cut(*mesh, scan["planes"]), seconds


def ours(file: Path, planes: dict) -> dict:
    _, axes = score.basis(planes["normal"])
    found = {}
    for plane in json.loads(file.read_text())["planes"]:
        lines = [np.array(line["points"]) @ axes.T for line in plane["polylines"]]
        closed = [line["closed"] for line in plane["polylines"]]
        lines = [np.vstack([a, a[:1]]) if ring else a for a, ring in zip(lines, closed)]
        if lines:
            found[plane["index"]] = np.vstack([np.stack([a[:-1], a[1:]], axis=1) for a in lines])
    return found


def row(truth: score.Truth, name: str, found: list, scale: float) -> None:
    cells = [name]
    for curves in found:
        scores = truth.score(curves) if curves is not None else None
        cells += ["crashed"] * 4 if scores is None else [
            f"{scale * scores['median']:.3g}", f"{scale * scores['p95']:.3g}",
            f"{100 * scores['complete']:.1f}", f"{100 * scores['far']:.2f}"]
    print(f"| {' | '.join(cells)} |", flush=True)


def peer(fuse, folder: Path, share: float) -> tuple[dict | None, float]:
    """The sections by another program, in a process of its own; None if it crashes."""
    try:
        with concurrent.futures.ProcessPoolExecutor(1) as process:
            return process.submit(sections, fuse, folder, share).result()
    except concurrent.futures.process.BrokenProcessPool:
        return None, np.nan


def main() -> None:
    test_score.check()
    shares, scene = sys.argv[1], Path(sys.argv[2])
    there = [peer for peer in PEERS if importlib.util.find_spec(peer[1])]
    for name, module, _ in PEERS:
        if importlib.util.find_spec(module) is None:
            print(f"{name}: SKIPPED: this Python has no module {module}; see requirements.txt",
                  file=sys.stderr)
    scan, mesh = load(scene / "given"), np.load(scene / "given/truth.npz")
    mesh = mesh["vertices"], mesh["faces"]
    images = [view for view in scan["views"] if "depth" in view]
    truth = score.Truth(mesh, scan["planes"], images, scan["size"], scan["sigma"],
                        scan.get("lowest", -np.inf))
    scale = MILLIMETRES[scan["unit"]]
    size, sigma = scale * scan["size"], scale * scan["sigma"]
    print(f"{scan['name']}: {len(scan['views'])} views, size {size:.4g} mm, "
          f"noise {sigma:.3g} mm, distances in mm", file=sys.stderr)
    heads = ["median", "95 %", "complete %", "far %"]
    heads = ["program, resolution", *heads, *(f"smoothed: {head}" for head in heads)]
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    folders = ("given", "smoothed")
    row(truth, "Transect", [ours(scene / f"{i}.json", scan["planes"]) for i in folders], scale)
    times = []
    for name, _, fuse in there:
        # Points without a grid give no depth image.
        if fuse is voxel_blocks and not images:
            continue
        for share in map(float, shares.split(",")):
            found = [peer(fuse, scene / i, share) for i in folders]
            program = f"{name}, {100 * share:g} %"
            row(truth, program, [sections for sections, _ in found], scale)
            times.append(f"{program}\t{found[0][1]:.1f}")
    print("", *times, sep="\n")


if __name__ == "__main__":
    main()
