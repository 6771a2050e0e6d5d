"""Points with a known truth, as files and as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

HEADER = "x,y,z,r,c"


def rows(n: int = 12, noise: float = 1.0, seed: int = 0) -> list[tuple[float, ...]]:
    """Points (x, y, z, r, c) of a camera at the origin with linear r and c."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-300, 300, n), rng.uniform(-200, 200, n)
    z = rng.uniform(500, 1500, n)
    r = 960 + 1000 * x / z + noise * rng.standard_normal(n)
    c = 540 + 1000 * y / z + noise * rng.standard_normal(n)
    return [tuple(float(v) for v in row) for row in zip(x, y, z, r, c, strict=True)]


def text(
    points: Sequence[Sequence[object]], header: str = HEADER, separator: str = ",", end: str = "\n"
) -> str:
    """Format rows below a header."""
    lines = [header.replace(",", separator)]
    lines += [separator.join(str(value) for value in row) for row in points]
    return end.join(lines) + end


def write(folder: Path, content: str | bytes, name: str = "points.csv") -> Path:
    """Write a file and return its path."""
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path
