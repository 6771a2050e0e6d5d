"""How pixels follow points of the world, by a member's mapping."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from bayescal.arrays import Array
from bayescal.cameras.camera import Camera
from bayescal.polynomials.basis import legendre_design
from bayescal.polynomials.plane import powers
from bayescal.prediction.calibrated.members import BoolArray, LensMember, Member, PolynomialMember


def by_world(member: Member, theta: Array, world: Array) -> tuple[Array, Array, BoolArray]:
    """Pixels ``(m, n, 2)``, their derivatives by points ``(m, n, 2, 3)``, and which are seen.

    Parameters
    ----------
    member : Member
    theta : Array
        ``(m, d)``.
    world : Array
        ``(m, n, 3)``.
    """
    if isinstance(member, LensMember):
        matrix, t = member.pose(theta)
        intrinsics, k = member.intrinsics(theta)
        rays = world @ np.swapaxes(matrix, 1, 2) + t[:, None, :]
        with np.errstate(all="ignore"):
            found = Camera(member.lens).jacobian(intrinsics, k, rays)
            seen = member.lens.seen(rays, k) & np.isfinite(found.pixels).all(axis=-1)
        return found.pixels, found.by_ray @ matrix[:, None], seen
    assert isinstance(member, PolynomialMember), "the other kind of member"
    scaled, front = member.scaled(theta, world)
    pixels, slope = with_slopes(member, theta, scaled)
    away = np.where(front[..., None], world - member.positions(theta)[:, None, :], 1.0)
    x, y, z = np.moveaxis(away, -1, 0)
    zero = np.zeros_like(z)
    ratios = [[1 / z, zero, -x / z**2], [zero, 1 / z, -y / z**2]]
    by_point = np.stack(
        [
            np.stack(row, axis=-1) / domain.half_range
            for row, domain in zip(ratios, member.domains, strict=True)
        ],
        axis=-2,
    )
    return pixels, slope @ by_point, front


def with_slopes(member: PolynomialMember, theta: Array, scaled: Array) -> tuple[Array, Array]:
    """Pixels ``(m, n, 2)`` and their derivatives by the scaled regressors, ``(m, n, 2, 2)``."""
    value, slope = np.empty(scaled.shape), np.zeros((*scaled.shape, 2))
    for axis, b in enumerate(member.amplitudes(theta)):
        k = member.orders[axis]
        own = legendre_design(scaled[..., axis], k)
        turn = _derivative(k)
        if not member.bivariate:
            value[..., axis] = np.einsum("mnp,mp->mn", own, b)
            slope[..., axis, axis] = np.einsum("mnp,mp->mn", own @ turn, b)
            continue
        other = legendre_design(scaled[..., 1 - axis], k)
        i, j = np.array(powers(k)).T
        value[..., axis] = np.einsum("mnp,mp->mn", own[..., i] * other[..., j], b)
        by_own, by_other = (
            (own @ turn)[..., i] * other[..., j],
            own[..., i] * (other @ turn)[..., j],
        )
        slope[..., axis, axis] = np.einsum("mnp,mp->mn", by_own, b)
        slope[..., axis, 1 - axis] = np.einsum("mnp,mp->mn", by_other, b)
    return value, slope


def _derivative(order: int) -> Array:
    """Matrix that takes P_0 ... P_k to their derivatives, from the right, ``(k + 1, k + 1)``."""
    out = np.zeros((order + 1, order + 1))
    for k in range(1, order + 1):
        slopes = legendre.legder(np.eye(order + 1)[k])
        out[: len(slopes), k] = slopes
    return out
