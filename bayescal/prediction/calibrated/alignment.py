r"""The turn that poses absorb: which frame the lens of many views has.

Views fix a lens only up to a turn of its frame: what one draw calls a shift of the principal
point, another calls a turn of every view. So each draw's frame is turned until it sees the rays of
one reference lens where that lens sees them, in the least-squares sense (dkogan/mrcal calls it
the implied transformation). What is left is what the calibration does not know.
"""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import Lens
from bayescal.cameras.pose import cross_matrices, rotation_vectors, rotations

STEPS = 8
SETTLED = 1e-11  # rad


def absorbed_turns(lens: Lens, intrinsics: Array, k: Array, rays: Array, pixels: Array) -> Array:
    """Find the turns after which lenses see rays closest to given pixels, ``(m, 3)``, rad.

    Parameters
    ----------
    intrinsics, k : Array
        Of each draw, ``(m, 4)``, px, and ``(m, K)``.
    rays, pixels : Array
        Of the reference, ``(n, 3)``, and where it sees them, ``(n, 2)``, px.
    """
    turn = np.broadcast_to(np.eye(3), (len(k), 3, 3))
    for _ in range(STEPS):
        moved = rays @ np.swapaxes(turn, 1, 2)
        with np.errstate(all="ignore"):
            found = Camera(lens).jacobian(intrinsics, k, moved)
            use = lens.seen(moved, k)[..., None] & np.isfinite(found.pixels)
        miss = np.where(use, pixels - found.pixels, 0.0)
        slope = -found.by_ray @ cross_matrices(moved)
        slope = np.where(use[..., None], slope, 0.0)
        square = np.einsum("mnai,mnaj->mij", slope, slope)
        step = np.linalg.solve(square, np.einsum("mnai,mna->mi", slope, miss)[..., None])[..., 0]
        turn = rotations(step) @ turn
        if np.abs(step).max() < SETTLED:
            break
    return rotation_vectors(turn)
