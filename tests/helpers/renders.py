"""Photographs of flat targets, rendered by a known homography."""

from __future__ import annotations

import cv2
import numpy as np

from bayescal.arrays import Array

SIZE = (640, 480)
OVER = 4  # rendered pixels per pixel, each way


def chessboard_texture(columns: int, rows: int, px: int) -> tuple[np.ndarray, Array]:
    """A chessboard with so many inner corners, and what takes its pixels to squares.

    The origin is the first inner corner; the square after it is dark.
    """
    texture = np.full(((rows + 3) * px, (columns + 3) * px), 255, dtype=np.uint8)
    for row in range(rows + 1):
        for column in range(columns + 1):
            if (row + column) % 2 == 0:
                at = np.s_[(row + 1) * px : (row + 2) * px, (column + 1) * px : (column + 2) * px]
                texture[at] = 20
    return texture, to_units(px, 2, 2)


def to_units(px: float, left: float, top: float) -> Array:
    """Take a texture's pixel (centres at integers) to units from an origin so far in."""
    return np.array([[1 / px, 0, 0.5 / px - left], [0, 1 / px, 0.5 / px - top], [0, 0, 1]])


def homography(
    scale: float,
    turn: float = 0.0,
    tilt: tuple[float, float] = (0.0, 0.0),
    at: tuple[float, float] = (320.0, 240.0),
    middle: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """Board to image: `middle` of the board goes to `at`, px; a unit is about `scale` px."""
    cos, sin = scale * np.cos(turn), scale * np.sin(turn)
    shift = np.array([[1, 0, -middle[0]], [0, 1, -middle[1]], [0, 0, 1]])
    centred = np.array([[cos, -sin, 0], [sin, cos, 0], [*tilt, 1]])
    return np.array([[1, 0, at[0]], [0, 1, at[1]], [0, 0, 1]]) @ centred @ shift


def photograph(
    texture: np.ndarray,
    units: Array,
    board_to_image: Array,
    rng: np.random.Generator,
    size: tuple[int, int] = SIZE,
    blur: float = 0.7,
    noise: float = 1.5,
) -> np.ndarray:
    """Render a texture as a camera would see it, grey."""
    over = np.array([[OVER, 0, (OVER - 1) / 2], [0, OVER, (OVER - 1) / 2], [0, 0, 1]])
    fine = cv2.warpPerspective(
        texture,
        over @ board_to_image @ units,
        (size[0] * OVER, size[1] * OVER),
        flags=cv2.INTER_LINEAR,
        borderValue=255,
    )
    image = cv2.GaussianBlur(cv2.resize(fine, size, interpolation=cv2.INTER_AREA), (0, 0), blur)
    noisy = 30 + 0.7 * image.astype(float) + rng.normal(0, noise, image.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def seen_at(points: Array, board_to_image: Array) -> Array:
    """Where a homography shows points of the plane, ``(n, 2)``, px."""
    homogeneous = np.column_stack([points[:, :2], np.ones(len(points))]) @ board_to_image.T
    return homogeneous[:, :2] / homogeneous[:, 2:]
