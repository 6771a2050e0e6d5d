r"""Priors of the camera's position and of the pinhole's parameters, in physical units.

position: normal about the stated one, with the setup's ``position_sd``, else a tenth of the
points' median distance from it. rotation vector about the stated orientation: normal, 30
degrees each unless the setup says otherwise. Focal lengths: ln f_r normal about ln of the
image's width with sd 1 (95 % from 0.14 to 7 widths), ln(f_c / f_r) normal about 0 with sd
0.1. Principal point: normal about the image's centre with a tenth of the image's size.
Distortion: each d_j, the displacement at the image's corner, normal with sd tau width; tau
log-uniform from 0.01 px / width to 0.5 like that of the polynomials, common to the d_j and
integrated out, or fixed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import LOG_2PI, Array, frozen
from bayescal.cameras.pinhole import POSE, PinholeGeometry
from bayescal.cameras.pose import rotations
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials.axis_data import pixel_span
from bayescal.polynomials.separable import axis_pixel
from bayescal.prior.amplitudes import check_tau, tau_bounds
from bayescal.prior.strength import Strength

POSITION_SHARE = 0.1  # of the points' median distance from the camera
FINEST_SHARE = 1e-10  # of the points' distance: the least sd of a position that is inferred
ROTATION_SD = math.radians(30.0)
FOCAL_LOG_SD, RATIO_LOG_SD = 1.0, 0.1
CENTRE_SHARE = 0.1  # of the image


@dataclass(frozen=True, eq=False)
class PositionPrior:
    """Independent normals about the stated camera position.

    Attributes
    ----------
    mean, sd : Array
        ``(3,)``, world units.
    stated : bool
        Whether the setup says the sd, or the default stands in.
    """

    mean: Array
    sd: Array
    stated: bool

    def possible(self, world: Array, position: Array) -> NDArray[np.bool_]:
        """Whether every world point stays on the side of the camera it is stated to be on.

        Parameters
        ----------
        world : Array
            ``(n_points, 3)``, world units.
        position : Array
            ``(n_draws, 3)``.

        Returns
        -------
        ndarray of bool
            ``(n_draws,)``.
        """
        z = world[:, 2]
        sides = np.sign(z - position[:, 2:]) == np.sign(z - self.mean[2])
        return np.asarray(sides.all(axis=1))

    def log_density(self, position: Array) -> Array:
        """Log density per cubic world unit, ``(n_draws,)`` of ``(n_draws, 3)``."""
        return log_normal(position, self.mean, self.sd)

    def __str__(self) -> str:
        how = "as stated" if self.stated else "a tenth of the points' median distance"
        x, y, z = (f"N({m:g}, {s:.3g}²)" for m, s in zip(self.mean, self.sd, strict=True))
        return f"position x ~ {x}, y ~ {y}, z ~ {z} world units (sd {how})"


def position_prior(points: Correspondences) -> PositionPrior:
    """Prior of the camera position of some points: the setup's, or the default about it."""
    stated = points.setup.camera.position_sd
    mean = frozen(points.setup.position)
    if stated is not None:
        return PositionPrior(mean, frozen(stated), True)
    return PositionPrior(mean, frozen([POSITION_SHARE * _distance(points)] * 3), False)


def check_inferred(points: Correspondences) -> None:
    """Refuse a position prior so narrow that no double tells positions within it apart.

    Raises
    ------
    InputError
    """
    stated, furthest = points.setup.camera.position_sd, float(np.abs(points.world).max())
    if stated is not None and min(stated) < FINEST_SHARE * max(_distance(points), furthest):
        raise InputError(
            f"{points.source}: position_sd {min(stated):g} is lost in rounding beside distances of "
            f"{_distance(points):.3g}; --position stated holds the position exactly"
        )


def _distance(points: Correspondences) -> float:
    """Median distance of the points from the stated camera, world units; 1 where it is 0."""
    return float(np.median(np.linalg.norm(points.camera_frame(), axis=1))) or 1.0


@dataclass(frozen=True, eq=False)
class PinholePrior:
    """Prior of a pinhole's parameters.

    Attributes
    ----------
    orientation : Array
        R at rotation zero, ``(3, 3)``.
    rotation_sd : Array
        ``(3,)``, rad.
    focal : float
        Median of f_r, px.
    focal_log_sd, ratio_log_sd : float
        Of ln f_r and of ln(f_c / f_r).
    centre, centre_sd : Array
        Of the principal point, ``(2,)``, px.
    width, height : float
        Image size, or the spans of the pixels that stand for it, px.
    tau : float or None
        Strength of the distortion where it is fixed.
    pixel : float
        What stands for a pixel (`bayescal.points.pixel`).
    """

    position: PositionPrior
    orientation: Array
    rotation_sd: Array
    focal: float
    focal_log_sd: float
    ratio_log_sd: float
    centre: Array
    centre_sd: Array
    width: float
    height: float
    tau: float | None = None
    pixel: float = 1.0

    @property
    def log_tau_bounds(self) -> tuple[float, float]:
        """Bounds of ln tau where it is inferred."""
        lower, upper = tau_bounds(self.width, self.pixel)
        return math.log(lower), math.log(upper)

    @property
    def half_diagonal(self) -> float:
        """Half the image's diagonal, px: where displacements are told."""
        return math.hypot(self.width, self.height) / 2

    def strength(self, order: int) -> Strength:
        """Make tau's integral over `order` displacements in units of the image's width."""
        return Strength(self.log_tau_bounds, order)

    def log_density(
        self, geometry: PinholeGeometry, theta: Array, log_tau: Array | None = None
    ) -> Array:
        """Log prior density per unit of the pinhole's coordinates, ``(n_draws,)``.

        tau is integrated out where it is inferred and not given.

        Parameters
        ----------
        theta : Array
            All coordinates, ``(n_draws, 10 + order)``; the density is per unit of the
            free ones.
        log_tau : Array, optional
            Of each draw, ``(n_draws,)``.
        """
        ratio = (theta[:, 1] - theta[:, 0])[:, None]
        total = log_normal(theta[:, :1], np.log([self.focal]), np.array([self.focal_log_sd]))
        total += log_normal(ratio, np.zeros(1), np.array([self.ratio_log_sd]))
        total += log_normal(theta[:, 2:4], self.centre, self.centre_sd)
        total += log_normal(theta[:, 4:7], np.zeros(3), self.rotation_sd)
        if geometry.fixed is None:
            position = geometry.position(theta)
            total += self.position.log_density(position) + geometry.log_volume(theta)
        return total + self.log_distortion(theta[:, POSE:], log_tau)

    def log_distortion(self, displacement: Array, log_tau: Array | None = None) -> Array:
        """Log density of displacements ``(n_draws, order)``, px, tau given or integrated out."""
        order = displacement.shape[1]
        if not order:
            return np.zeros(len(displacement))
        if self.tau is not None:
            log_tau = np.log([self.tau])
        if log_tau is not None:
            log_sd = (log_tau + math.log(self.width))[:, None]
            z = displacement * np.exp(-log_sd)
            return np.asarray(-(z**2 + LOG_2PI + 2 * log_sd).sum(axis=1) / 2)
        q = ((displacement / self.width) ** 2).sum(axis=1)
        return np.asarray(self.strength(order).log_density(q) - order * math.log(self.width))

    def draw(self, rng: np.random.Generator, geometry: PinholeGeometry, size: int) -> Array:
        """Draw all coordinates; nan where the points' centroid is behind the camera.

        Returns
        -------
        Array
            ``(size, 10 + order)``.
        """
        theta = np.zeros((size, POSE + geometry.order))
        theta[:, 0] = rng.normal(math.log(self.focal), self.focal_log_sd, size)
        theta[:, 1] = theta[:, 0] + rng.normal(0, self.ratio_log_sd, size)
        theta[:, 2:4] = rng.normal(self.centre, self.centre_sd, (size, 2))
        theta[:, 4:7] = rng.normal(0, self.rotation_sd, (size, 3))
        low, high = self.log_tau_bounds
        tau = np.exp(rng.uniform(low, high, size)) if self.tau is None else np.full(size, self.tau)
        sd = self.width * tau[:, None]
        theta[:, POSE:] = sd * rng.standard_normal((size, geometry.order))
        position = rng.normal(self.position.mean, self.position.sd, (size, 3))
        return geometry.to_anchor(theta, position if geometry.fixed is None else geometry.fixed)

    def __str__(self) -> str:
        """One line for each parameter, as it is printed."""
        lower, upper = np.exp([-1.96 * self.focal_log_sd, 1.96 * self.focal_log_sd]) * self.focal
        degrees = ", ".join(f"{d:.3g}" for d in np.degrees(self.rotation_sd))
        u, v = (f"N({m:g}, {s:g}²)" for m, s in zip(self.centre, self.centre_sd, strict=True))
        strength = (
            "inferred, log-uniform {:.3g} to {:g}".format(*tau_bounds(self.width, self.pixel))
            if self.tau is None
            else f"= {self.tau:g}"
        )
        return "\n".join(
            (
                f"ln focal_r ~ N(ln {self.focal:g}, {self.focal_log_sd:g}²): 95% from "
                f"{lower:.0f} to {upper:.0f} px; ln focal_c/focal_r ~ N(0, {self.ratio_log_sd:g}²)",
                f"centre_r ~ {u}, centre_c ~ {v} px",
                f"rotation about the stated orientation: sd ({degrees}) degrees",
                str(self.position),
                f"displacement of each radial term at the image's corner ~ N(0, (tau * "
                f"{self.width:g})²) px, tau {strength}",
            )
        )


def pinhole_prior(points: Correspondences, tau: float | None = None) -> PinholePrior:
    """Prior of a pinhole that took some points: the setup's words, else the defaults.

    Parameters
    ----------
    tau : float, optional
        Fixes the distortion's strength, as a fraction of the image's width.

    Raises
    ------
    InputError
        Where `tau` is not from 1e-9 to 1e9.
    """
    if tau is not None:
        check_tau(tau)
    setup, camera = points.setup, points.setup.camera
    sizes, middles = [], []
    for axis in AXES:
        size, t = setup.size(axis), points.pixel(axis)
        sizes.append(pixel_span(t) if size is None else size)
        middles.append(float(t.min() + np.ptp(t) / 2) if size is None else size / 2)
    vector = np.radians(camera.orientation if camera.orientation is not None else (0.0, 0.0, 0.0))
    sd = camera.orientation_sd
    return PinholePrior(
        position_prior(points),
        frozen(rotations(vector[None])[0]),
        frozen(np.full(3, ROTATION_SD) if sd is None else np.radians(sd)),
        camera.focal if camera.focal is not None else sizes[0],
        camera.focal_log_sd if camera.focal_log_sd is not None else FOCAL_LOG_SD,
        camera.ratio_log_sd if camera.ratio_log_sd is not None else RATIO_LOG_SD,
        frozen(camera.centre if camera.centre is not None else middles),
        frozen(camera.centre_sd or CENTRE_SHARE * np.array(sizes)),
        sizes[0],
        sizes[1],
        tau,
        axis_pixel(points, "r"),
    )


def log_normal(values: Array, mean: Array, sd: Array) -> Array:
    """Log density of independent normals, ``(n_draws,)`` of values ``(n_draws, d)``."""
    z = (values - mean) / sd
    return np.asarray(-(z**2 + LOG_2PI).sum(axis=1) / 2 - np.log(sd).sum())
