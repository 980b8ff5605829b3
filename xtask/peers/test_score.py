"""Checks the scorer against cases with exact answers: python xtask/peers/test_score.py"""

import numpy as np
import score

PLANES = {"normal": [0, 0, 1], "offset": 0.0, "interval": 1.0}
CAMERA = {"pose": np.eye(4), "fx": 40.0, "fy": 40.0, "cx": 19.5, "cy": 19.5}
WALL = CAMERA | {"depth": np.full((40, 40), 5.0)}


def ring(points: list) -> np.ndarray:
    points = np.array(points, float)
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def circle(radius: float) -> np.ndarray:
    angles = np.linspace(0, 2 * np.pi, 7200, endpoint=False)
    return ring(np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1))


def against(true: np.ndarray, found: np.ndarray, size: float = 2.0) -> list[float]:
    """Median, 95 % distance, completeness and far share, where all of the truth was seen."""
    truth = score.Truth((np.zeros((0, 3)), np.zeros((0, 3), int)), PLANES, [], size, 0.0)
    truth.parts = {0: score.pieces(true, score.PIECE * size)}
    truth.seen = {0: np.ones(len(truth.parts[0]), bool)}
    return list(truth.score({0: found}).values())


def close(found: list, wanted: list, atol: float = 2e-6) -> None:
    np.testing.assert_allclose(found, wanted, atol=atol)


def check() -> None:
    """Fails with an AssertionError at the first wrong score."""
    half_a_piece = 0.51 * score.PIECE * 2.0
    square = ring([(0, 0), (1, 0), (1, 1), (0, 1)])
    line = np.array([[(0.0, 0.0), (10.0, 0.0)]])
    close(against(circle(1.0), circle(1.0)), [0, 0, 1, 0])
    close(against(circle(1.0), circle(1.003)), [0.003, 0.003, 1, 0])
    close(against(square, square), [0, 0, 1, 0])
    # 0.004 of either end of the missing side are within the tolerance of its neighbours.
    close(against(square, square[:3]), [0, 0, 0.752, 0])
    close(against(line, np.vstack([line, 0.5 * line + [0, 0.5]])), [0, 0.5, 1, 1 / 3])
    close(against(line, line + [0, 0.003]), [0.003, 0.003, 1, 0])
    close(against(line, line + [0, 0.005]), [0.005, 0.005, 0, 0])
    close(against(line, line + [1, 0]), [0, 0.5, 0.9004, 0.098], half_a_piece)
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1.5, 0.5)])
    sides = [(0, 1, 3), (0, 3, 2), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 3, 7), (2, 7, 6)]
    box = score.cut(corners, np.array(sides), PLANES)
    assert list(box) == [-1, 0], list(box)
    _, axes = score.basis(PLANES["normal"])
    turned = ring(np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) @ axes.T)
    close(against(turned, box[0]), [0, 0, 1, 0])
    close(np.linalg.norm(box[-1][:, 1] - box[-1][:, 0], axis=1).sum(), 8)
    # The box's sections 0.01 larger on plane 0, and twice as large on plane -1, which does not count.
    larger = {0: 1.01 * box[0], -1: 2 * box[-1]}
    whole = score.Truth((corners, np.array(sides)), PLANES, [], 20.0, 0.0, -0.5)
    close(list(whole.score(larger).values()), [0.01, 0.01, 1, 0])
    points = np.array([(0, 0, 5), (0, 0, 5.2), (0, 0, 4.8), (0, 0, -5), (4, 0, 5)], float)
    assert score.shows(WALL, points, 0.1).tolist() == [True, False, False, False, False]


if __name__ == "__main__":
    check()
    print("the scorer's exact cases hold")
