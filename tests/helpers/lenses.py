"""Lenses with coefficients that real ones could have."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.cameras.lenses import lens_named

RNG = np.random.default_rng


class Case:
    """A lens with coefficients that a real one could have, and rays that it sees."""

    def __init__(self, name, k, angle=45.0, **options):
        self.lens = lens_named(name, **options)
        self.k = np.array(k, dtype=float)
        self.label = f"{name}-{len(k)}"
        self.angle = np.radians(angle)

    def rays(self, n=200, seed=0):
        rng = RNG(seed)
        theta = self.angle * np.sqrt(rng.uniform(0, 1, n))
        phi = rng.uniform(-np.pi, np.pi, n)
        theta[0] = 0  # the axis itself
        sine = np.sin(theta)
        rays = np.column_stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)])
        return rays * rng.uniform(0.5, 3, (n, 1))


BARREL = [-0.28, 0.12, 8e-4, -5e-4, -0.02]
RATIONAL = [8.0, 3.0, 8e-4, -5e-4, 0.2, 8.4, 5.5, 1.0]
CASES = [
    Case("radial", [], order=0, tangential=False),
    Case("radial", [8e-4, -5e-4], order=0, tangential=True),
    Case("radial", [-0.1], order=1, tangential=False),
    Case("radial", [-0.2, 0.3], order=2, tangential=False, step=1),
    Case("radial", [-0.28, 0.12, 1e-3, -1e-3, -0.02, 0.01, -1e-3, 1e-4], order=6),
    Case("opencv4", BARREL[:4]),
    Case("opencv5", BARREL),
    Case("rational", [-0.3, 0.1, 8e-4, -5e-4, -0.01, 0.05], order=1),
    Case("opencv8", RATIONAL, 60),
    Case("thin-prism", [-0.28, 0.12, 8e-4, -5e-4, 1e-3, -2e-4, -8e-4, 3e-4]),
    Case("opencv12", [*RATIONAL, 1e-3, -2e-4, -8e-4, 3e-4]),
    Case("fisheye", [], 175, order=0),
    Case("fisheye", [-0.02, 0.003, -0.0015, 0.0002], 110),
    Case("fisheye", [0.01, -0.004, 0.0015, -0.0003, 2e-5], 100, order=5),
    Case("division", [-0.25], 150),
    Case("division", [0.1], 50),
    Case("eucm", [0.62, 1.1], 110),
    Case("eucm", [0.3, 0.8], 105),
    Case("double-sphere", [-0.2, 0.6], 110),
    Case("double-sphere", [0.3, 0.4], 120),
]
every = pytest.mark.parametrize("case", CASES, ids=[case.label for case in CASES])
