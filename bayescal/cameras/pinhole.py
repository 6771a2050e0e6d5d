r"""The pinhole camera as a function of its parameters, for many draws at once.

The steps are those of `bayescal.cameras.geometry` and `bayescal.cameras.distortion` (thesis
eq. 1, 3-9, 16-22): p_c = R (p_w - C), x = x_c / z_c, y = y_c / z_c, radial distortion, and

    r = u0 + f_r x g,    c = v0 + f_c y g,    g = 1 + sum_j (d_j / D) rho^(p_j),

with rho = f sqrt(x^2 + y^2) / D, f = sqrt(f_r f_c) and D half the image's diagonal, px: d_j
is the displacement in px that term j causes at the image's corner, and
k_j = (d_j / D) (f / D)^(p_j) the usual coefficient. The powers p_j are 2, 4, 6, ...
("even") or 1, 2, 3, ... ("all", as the thesis writes them).

Coordinates theta, in this order: ln f_r, ln f_c; u0, v0 (px); the rotation vector of R
about the stated orientation (rad); the *anchor*, which stands for the camera's position:
the undistorted pixel of the points' centroid (px) and ln(f_r / its depth); d_1, d_2, ...
(px). The data fix the anchor to a fraction of a pixel whatever the focal length is, so that
the posterior is nearly normal in these coordinates where it is a banana in C. Where the
position is held fixed the *free* coordinates lack the anchor, and where a prior knows the position
better than the data do they hold C itself, from an origin, in its place; `full` puts it in.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array

Radial: TypeAlias = Literal["even", "all"]
POSE = 10  # coordinates before the distortion
ANCHOR = slice(7, 10)


@dataclass(frozen=True, eq=False)
class PinholeGeometry:
    """What predicts pixels: the world points and what the coordinates refer to.

    Attributes
    ----------
    world : Array
        World points, ``(n_points, 3)``, world units.
    orientation : Array
        R at rotation zero, ``(3, 3)``.
    half_diagonal : float
        D, px.
    order : int
        Number of radial terms.
    radial : str
        ``"even"`` or ``"all"``.
    fixed : Array or None
        The camera position where it is held fixed, ``(3,)``, world units.
    origin : Array or None
        From where free coordinates count the position that they hold instead of the anchor,
        ``(3,)``, world units.
    """

    world: Array
    orientation: Array
    half_diagonal: float
    order: int
    radial: Radial = "even"
    fixed: Array | None = None
    origin: Array | None = None

    @property
    def dimension(self) -> int:
        """Number of coordinates that are free."""
        return POSE + self.order - 3 * (self.fixed is not None)

    def full(self, free: Array) -> Array:
        """All coordinates theta of the free ones, ``(n_draws, 10 + order)``."""
        if self.origin is not None:
            return self.to_anchor(free, self.origin + free[:, ANCHOR])
        if self.fixed is None:
            return free
        start = ANCHOR.start
        gap = np.zeros((len(free), 3), dtype=free.dtype)
        theta = np.concatenate([free[:, :start], gap, free[:, start:]], axis=1)
        return self.to_anchor(theta, self.fixed)

    def free(self, theta: Array) -> Array:
        """Give the free ones of all coordinates; inverse of `full`."""
        if self.origin is not None:
            out = theta.copy()
            out[:, ANCHOR] = self.position(theta) - self.origin
            return out
        if self.fixed is None:
            return theta
        return np.delete(theta, np.arange(ANCHOR.start, ANCHOR.stop), axis=1)

    @property
    def centroid(self) -> Array:
        """Mean of the world points, ``(3,)``."""
        return np.asarray(self.world.mean(axis=0))

    @property
    def powers(self) -> NDArray[np.intp]:
        """Power of the radius in each term, ``(order,)``."""
        return np.arange(1, self.order + 1) * (2 if self.radial == "even" else 1)

    def rotation(self, theta: Array) -> Array:
        """R of each draw, ``(n_draws, 3, 3)``."""
        return rotations(theta[:, 4:7]) @ self.orientation

    def anchor(self, theta: Array) -> Array:
        """Centroid in the camera's frame, ``(n_draws, 3)``, world units."""
        focal = np.exp(theta[:, :2])
        depth = focal[:, 0] * np.exp(-theta[:, 9])
        sides = (theta[:, 7:9] - theta[:, 2:4]) / focal * depth[:, None]
        return np.column_stack([sides, depth])

    def position(self, theta: Array) -> Array:
        """Camera position C, ``(n_draws, 3)``, world units."""
        turned = np.einsum("mji,mj->mi", self.rotation(theta), self.anchor(theta))
        return np.asarray(self.centroid - turned)

    def log_volume(self, theta: Array) -> Array:
        """Log of |d C / d free|, ``(n_draws,)``: of an anchor depth^3 / (f_r f_c)."""
        if self.origin is not None:
            return np.zeros_like(theta[:, 0])
        log_depth = theta[:, 0] - theta[:, 9]
        return np.asarray(3 * log_depth - theta[:, 0] - theta[:, 1])

    def to_anchor(self, theta: Array, position: Array) -> Array:
        """Coordinates whose anchor belongs to camera positions, ``(n_draws, 3)`` or ``(3,)``.

        Returns
        -------
        Array
            `theta` with its three anchor columns replaced; nan where the centroid is
            behind the camera.
        """
        out = theta.copy()
        away = np.broadcast_to(self.centroid - position, (len(theta), 3))
        p = np.einsum("mij,mj->mi", self.rotation(theta), away)
        focal = np.exp(theta[:, :2])
        with np.errstate(invalid="ignore", divide="ignore"):
            out[:, 7:9] = theta[:, 2:4] + focal * p[:, :2] / p[:, 2:]
            out[:, 9] = theta[:, 0] - np.log(p[:, 2])
        return out

    def project(self, theta: Array) -> tuple[Array, Array]:
        """Pixels of all points.

        Parameters
        ----------
        theta : Array
            All coordinates, ``(n_draws, 10 + order)``; complex ones for complex steps.

        Returns
        -------
        pixels : Array
            r and c, ``(n_draws, 2, n_points)``, px.
        depth : Array
            z_c, ``(n_draws, n_points)``, world units; not positive behind the camera.
        """
        turned = self.rotation(theta) @ (self.world - self.centroid).T
        points = turned + self.anchor(theta)[:, :, None]
        depth = points[:, 2]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            image = points[:, :2] / depth[:, None, :]
            focal = np.exp(theta[:, :2])
            offset = focal[:, :, None] * image * self._gain(theta, image)[:, None, :]
            return theta[:, 2:4, None] + offset, depth

    def _gain(self, theta: Array, image: Array) -> Array:
        """Gain g at each point, ``(n_draws, n_points)``."""
        gain = np.ones(image[:, 0].shape, dtype=image.dtype)
        if not self.order:
            return gain
        scale = np.exp(theta[:, 0] + theta[:, 1]) / self.half_diagonal**2
        square = (image[:, 0] ** 2 + image[:, 1] ** 2) * scale[:, None]
        base = square if self.radial == "even" else np.sqrt(square)
        total = np.zeros_like(gain)
        for j in reversed(range(self.order)):  # Horner
            total = (total + theta[:, POSE + j, None] / self.half_diagonal) * base
        return gain + total

    def coefficients(self, theta: Array) -> Array:
        """k_j of 1 + sum k_j w^p_j, w the radius on the image plane, ``(n_draws, order)``."""
        log_focal = (theta[:, 0] + theta[:, 1]) / 2
        ratio = np.exp(log_focal)[:, None] / self.half_diagonal
        return np.asarray(theta[:, POSE:] / self.half_diagonal * ratio**self.powers)

    def jacobian(self, free: Array) -> Array:
        """Slopes d pixels / d free at one draw ``(dimension,)``, ``(2, n_points, dimension)``.

        By complex step, exact to rounding: the imaginary part of f(x + ih) is h f'(x)
        (Squire & Trapp 1998, SIAM Rev. 40, 110).
        """
        step = 1e-30
        moved = free + step * 1j * np.eye(self.dimension)
        pixels, _ = self.project(self.full(moved))
        return np.asarray(np.moveaxis(pixels.imag / step, 0, 2))


def rotations(vectors: Array) -> Array:
    """Rotation matrices of rotation vectors, ``(n, 3, 3)`` from ``(n, 3)`` (Rodrigues).

    `bayescal.cameras.geometry.rotation_matrix` does one; this does many, complex ones too.
    """
    square = (vectors**2).sum(axis=1)
    angle = np.sqrt(square)
    some = np.where(square == 0, 1, angle)
    first = np.where(square == 0, 1, np.sin(angle) / some)  # sin(a) / a
    half = np.where(square == 0, 1, np.sin(angle / 2) / (some / 2))
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    second = (half**2 / 2)[:, None, None]  # (1 - cos(a)) / a^2
    rotated = np.eye(3) + first[:, None, None] * cross + second * (cross @ cross)
    return np.asarray(rotated)
