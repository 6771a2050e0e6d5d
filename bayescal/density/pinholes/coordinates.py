"""In which coordinates a pinhole is sampled: those in which its posterior is nearly normal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.pinhole import ANCHOR, PinholeGeometry
from bayescal.density.pinholes.fit import PinholeFit
from bayescal.prior.camera import PositionPrior

STEP = 1e-30


def suited(
    geometry: PinholeGeometry, prior: PositionPrior, fit: PinholeFit
) -> tuple[PinholeGeometry, PinholeFit]:
    """Hold the position itself where its prior is narrower than the likelihood in any direction.

    The anchor is what the data know. A prior that knows the position better makes the
    posterior a thin curved sheet in it: on the thesis data, with the position stated to 0.01
    units, the chains did not converge.

    Parameters
    ----------
    geometry : PinholeGeometry
        Of the fit, with the anchor.

    Returns
    -------
    PinholeGeometry, PinholeFit
        The same camera in the coordinates to be sampled in.
    """
    if geometry.fixed is not None:
        return geometry, fit
    d = len(fit.free)
    slopes = _position_slopes(geometry, fit)
    known = slopes / prior.sd[:, None]
    if np.linalg.eigvalsh(known @ fit.covariance @ known.T).max() <= 1:
        return geometry, fit
    held = replace(geometry, origin=prior.mean)
    change = np.eye(d)
    change[ANCHOR] = slopes
    free = held.free(geometry.full(fit.free[None]))[0]
    return held, replace(fit, free=free, covariance=change @ fit.covariance @ change.T)


def position_sd(geometry: PinholeGeometry, fit: PinholeFit) -> Array:
    """Give standard errors of the position that fits best, of the likelihood alone, ``(3,)``."""
    slopes = _position_slopes(geometry, fit)
    # Of an exact fit rounding may leave less than nothing.
    return np.sqrt(np.maximum(np.diag(slopes @ fit.covariance @ slopes.T), 0.0))


def _position_slopes(geometry: PinholeGeometry, fit: PinholeFit) -> Array:
    """Slopes of the position at a fit, ``(3, dimension)``, by complex step."""
    moved = fit.free + STEP * 1j * np.eye(len(fit.free))
    return np.asarray(geometry.position(geometry.full(moved)).imag.T / STEP)
