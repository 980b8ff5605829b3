"""Scores sections against a true surface. Needs numpy and scipy, and nothing of Transect.

Curves are segments in the coordinates of their plane: arrays of count x 2 ends x 2. Their order and
direction play no part, so polylines and sections of meshes are scored alike.
"""

import numpy as np
from scipy.spatial import cKDTree

# Length of the pieces that curves are sampled in, as a share of the scene's size. Chosen by hand,
# a quarter of the smallest tolerance. Doubled, short curves weigh less accurately.
PIECE = 0.0005
# Distance within which a true curve counts as found, as a share of the size. It is that of
# docs/accuracy.md. Doubled, it hides gaps that a curve on the other side of a thin plate covers.
TIGHT = 0.002
# Distance beyond which a curve counts as far off, as a share of the size. Chosen by hand. Doubled,
# pieces that stray behind silhouettes no longer count.
FAR = 0.01
# Pieces whose distance from a sample is computed, those with the nearest middles. Two would do
# along one curve; 8 covers ends and crossings. Doubled, the scores stay the same.
NEIGHBOURS = 8
# Largest angle between ray and surface normal at which an image shows a surface, in degrees. It
# decides which true curves must be found. Chosen by hand; sensors return little beyond.
INCIDENCE = 80.0


def basis(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The unit normal, and the two axes of the plane as rows."""
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return normal, np.array([first, np.cross(normal, first)])


def cut(vertices: np.ndarray, faces: np.ndarray, planes: dict) -> dict[int, np.ndarray]:
    """The segments in which the triangles of a mesh meet each plane; a tie is high."""
    normal, axes = basis(planes["normal"])
    if len(faces) == 0:
        return {}
    level = (vertices @ normal - planes["offset"]) / planes["interval"]
    flat, corners = vertices @ axes.T, level[faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    found = {}
    for plane in range(int(np.ceil(level.min())), int(np.floor(level.max())) + 1):
        crossed = faces[(low < plane) & (high >= plane)]
        above = level[crossed] >= plane
        # Turns each triangle so that the corner that is alone on its side comes first.
        alone = np.argmax(above == (above.sum(axis=1) == 1)[:, None], axis=1)
        turned = (alone[:, None] + np.arange(3)) % 3
        one, *others = np.take_along_axis(crossed, turned, axis=1).T
        share = [(plane - level[one]) / (level[other] - level[one]) for other in others]
        ends = [flat[one] + t[:, None] * (flat[b] - flat[one]) for t, b in zip(share, others)]
        if len(crossed):
            found[plane] = np.stack(ends, axis=1)
    return found


def pieces(segments: np.ndarray, longest: float) -> np.ndarray:
    """The segments in equal pieces that are no longer than `longest`."""
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    count = np.maximum(1, np.ceil(length / longest)).astype(int)
    which = np.repeat(np.arange(len(segments)), count)
    step = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    share = np.stack([step, step + 1], axis=1) / count[which, None]
    start, end = segments[which, 0], segments[which, 1]
    return start[:, None] + share[..., None] * (end - start)[:, None]


def distances(points: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Distance of each point from the nearest of short pieces; infinite without pieces."""
    if len(parts) == 0 or len(points) == 0:
        return np.full(len(points), np.inf)
    tree = cKDTree(parts.mean(axis=1))
    near = tree.query(points, k=min(NEIGHBOURS, len(parts)))[1].reshape(len(points), -1)
    start, along = parts[near, 0], parts[near, 1] - parts[near, 0]
    offset = points[:, None] - start
    length = np.maximum((along**2).sum(axis=2), 1e-300)
    share = np.clip((offset * along).sum(axis=2) / length, 0, 1)
    return np.linalg.norm(offset - share[..., None] * along, axis=2).min(axis=1)


def quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    """The value that a share of the weight does not exceed; NaN without values."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return values[order][np.searchsorted(total, share * total[-1])] if len(order) else np.nan


class Truth:
    """The true sections in pieces, and whether an image shows each piece.

    Planes below the station `lowest` do not count. Without images all of the truth must be found.
    """

    def __init__(self, mesh: tuple, planes: dict, views: list, size: float, sigma: float,
                 lowest: float = -np.inf):
        self.size, self.parts, self.seen, self.lowest = size, {}, {}, lowest
        self.station = lambda plane: planes["offset"] + plane * planes["interval"]
        normal, axes = basis(planes["normal"])
        for plane, segments in cut(*mesh, planes).items():
            self.parts[plane] = parts = pieces(segments, PIECE * size)
            middles = parts.mean(axis=1) @ axes + self.station(plane) * normal
            shown = [shows(v, middles, 4 * sigma) for v in views] or [np.ones(len(parts), bool)]
            self.seen[plane] = np.any(shown, axis=0)

    def score(self, found: dict[int, np.ndarray]) -> dict[str, float]:
        """Distances of the found curves by length, and shares of lengths."""
        off, weight, missed, wanted = [], [], 0.0, 0.0
        none = np.zeros((0, 2, 2))
        counted = (k for k in self.parts.keys() | found.keys() if self.station(k) >= self.lowest)
        for plane in sorted(counted):
            parts = pieces(found.get(plane, none), PIECE * self.size)
            off.append(distances(parts.mean(axis=1), self.parts.get(plane, none)))
            weight.append(np.linalg.norm(parts[:, 1] - parts[:, 0], axis=1))
            true = self.parts.get(plane, none)[self.seen.get(plane, [])]
            length = np.linalg.norm(true[:, 1] - true[:, 0], axis=1)
            wanted += length.sum()
            missed += length[distances(true.mean(axis=1), parts) > TIGHT * self.size].sum()
        off, weight = np.concatenate(off), np.concatenate(weight)
        return {
            "median": quantile(off, weight, 0.5),
            "p95": quantile(off, weight, 0.95),
            "complete": 1 - missed / wanted,
            "far": weight[off > FAR * self.size].sum() / weight.sum() if weight.sum() else np.nan,
        }


def shows(view: dict, points: np.ndarray, slack: float) -> np.ndarray:
    """Whether the depth image of a pinhole camera shows each point.

    The point's depth must lie between those of the 3 x 3 pixels around it. Where these differ by
    more than the depths of one surface at INCIDENCE, they show an edge, and no point.
    """
    rows, cols = view["depth"].shape
    inside = (points - view["pose"][:3, 3]) @ view["pose"][:3, :3]
    depth = np.maximum(inside[:, 2], 1e-9)
    col = np.rint(view["fx"] * inside[:, 0] / depth + view["cx"])
    row = np.rint(view["fy"] * inside[:, 1] / depth + view["cy"])
    fits = (row > 0) & (row < rows - 1) & (col > 0) & (col < cols - 1) & (inside[:, 2] > 0)
    shown = np.zeros(len(points), bool)
    row, col, depth = row[fits].astype(int), col[fits].astype(int), depth[fits]
    window = [view["depth"][row + i, col + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    low, high = np.fmin.reduce(window), np.fmax.reduce(window)
    slope = np.tan(np.radians(INCIDENCE)) * np.sqrt(8) / min(view["fx"], view["fy"])
    with np.errstate(invalid="ignore"):
        near = (low - slack <= depth) & (depth <= high + slack)
        shown[fits] = near & (high - low <= slope * depth + 2 * slack)
    return shown
