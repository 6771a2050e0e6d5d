"""The inverse of polynomials: which scaled regressors give a pixel, at the mean and at every draw.

A polynomial has an inverse where it is monotone. Inside the calibrated box the derivative's roots
part each axis's polynomial into monotone pieces, so that every solution is found and counted; of
polynomials of both ratios solutions are looked for from a grid of starts. Draws follow the mean's
solution by Newton's method. A solution counts where the mapping gives the pixel back to 1e-9 px.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre

from bayescal.arrays import Array, IntArray
from bayescal.prediction.calibrated.members import BoolArray
from bayescal.prediction.calibrated.polynomial_map import PolynomialMap

RESIDUAL = 1e-9  # px
NEWTON, HALVINGS = 40, 80
STARTS = 9  # along each ratio, of polynomials of both
NEAREST = 4000  # pixels compared with the places of the domain at once
FINE, PATH = 21, 9  # places of the domain along each ratio, and on the way from there beyond it
MARGIN = 0.05  # of the domain, beyond its ends
SAME = 1e-6  # of the domain: solutions closer than this are one


def solved(mapping: PolynomialMap, mean: Array, pixels: Array) -> tuple[Array, IntArray]:
    """Solve pixels ``(n, 2)`` in the box or a little beyond: a solution ``(n, 2)``, how many."""
    return (_plane_solutions if mapping.bivariate else _line_solutions)(mapping, mean, pixels)


def _line_solutions(mapping: PolynomialMap, mean: Array, pixels: Array) -> tuple[Array, IntArray]:
    """Solve each axis on its own, on every monotone piece of its box."""
    out, count = np.zeros((len(pixels), 2)), np.ones(len(pixels), dtype=np.intp)
    low, high = _searched(mapping)
    for axis, b in enumerate(mapping.amplitudes(mean)):
        at, n = _on_pieces(b[0], float(low[axis]), float(high[axis]), pixels[:, axis])
        out[:, axis] = at
        count *= n
    return out, count


def _on_pieces(b: Array, low: float, high: float, t: Array) -> tuple[Array, IntArray]:
    """Solve a Legendre series for values ``(n,)``: one solution of each, and how many there are."""
    turns = _turns(b)
    ends = np.array([low, *np.sort(turns[(turns > low) & (turns < high)]), high])
    found, count = np.zeros(len(t)), np.zeros(len(t), dtype=np.intp)
    for a, z in pairwise(ends):
        at_a, at_z = legendre.legval(a, b), legendre.legval(z, b)
        inside = (t >= min(at_a, at_z)) & (t <= max(at_a, at_z))
        left, right = np.full(inside.sum(), a), np.full(inside.sum(), z)
        rising = at_z > at_a
        for _ in range(HALVINGS):
            middle = (left + right) / 2
            below = (legendre.legval(middle, b) < t[inside]) == rising
            left, right = np.where(below, middle, left), np.where(below, right, middle)
        found[inside] = (left + right) / 2
        count += inside
    return found, count


def _turns(b: Array) -> Array:
    """Where a Legendre series turns."""
    turns = legendre.legroots(legendre.legder(b)) if len(b) > 2 else np.empty(0)
    return np.asarray(turns.real[np.abs(turns.imag) < 1e-9 * (1 + np.abs(turns.real))])


def _plane_solutions(mapping: PolynomialMap, mean: Array, pixels: Array) -> tuple[Array, IntArray]:
    """Look for solutions of polynomials of both ratios from a grid of starts."""
    low, high = _searched(mapping)
    grid = np.stack(
        np.meshgrid(*(np.linspace(a, z, STARTS) for a, z in zip(low, high, strict=True))), axis=-1
    ).reshape(-1, 2)
    best, count = np.zeros((len(pixels), 2)), np.zeros(len(pixels), dtype=np.intp)
    theta = np.repeat(mean, len(grid), axis=0)
    for i, pixel in enumerate(pixels):
        shape = (len(grid), 1, 2)
        at, found = newton(mapping, theta, np.broadcast_to(pixel, shape), grid[:, None, :])
        near = ((at[:, 0] >= low) & (at[:, 0] <= high)).all(axis=1)
        inside = at[:, 0][found[:, 0] & near]
        kept: list[Array] = []
        for one in inside:
            if all(np.abs(one - other).max() > SAME for other in kept):
                kept.append(one)
        count[i] = len(kept)
        if kept:
            best[i] = kept[0]
    return best, count


def _searched(mapping: PolynomialMap) -> tuple[Array, Array]:
    """Box to look for solutions in: noise puts half the pixels at its edge beyond it."""
    low, high = mapping.box
    margin = MARGIN * (high - low)
    return low - margin, high + margin


def newton(
    mapping: PolynomialMap, theta: Array, pixels: Array, start: Array
) -> tuple[Array, BoolArray]:
    """Solve for scaled regressors ``(m, n, 2)`` by Newton's method; whether each was found."""
    at = np.array(start, dtype=np.float64)
    for _ in range(NEWTON):
        value, slope = mapping.with_slopes(theta, at)
        miss = value - pixels
        det = slope[..., 0, 0] * slope[..., 1, 1] - slope[..., 0, 1] * slope[..., 1, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            first = (slope[..., 1, 1] * miss[..., 0] - slope[..., 0, 1] * miss[..., 1]) / det
            second = (slope[..., 0, 0] * miss[..., 1] - slope[..., 1, 0] * miss[..., 0]) / det
        step = np.clip(np.nan_to_num(np.stack([first, second], axis=-1)), -0.5, 0.5)
        at = at - step
        if np.abs(step).max(initial=0.0) < 1e-14:
            break
    miss = np.abs(mapping.at_scaled(theta, at) - pixels).max(axis=-1)
    # The same branch: the mapping turns there as it does where the search began.
    _, before = mapping.with_slopes(theta, np.asarray(start))
    _, after = mapping.with_slopes(theta, at)
    return at, (miss < RESIDUAL) & (np.sign(_det(before)) == np.sign(_det(after)))


def _det(slope: Array) -> Array:
    return np.asarray(slope[..., 0, 0] * slope[..., 1, 1] - slope[..., 0, 1] * slope[..., 1, 0])


def continued(mapping: PolynomialMap, mean: Array, pixels: Array) -> tuple[Array, BoolArray]:
    """Solve pixels on the monotone branch of the calibrated domain, and beyond it.

    Returns
    -------
    scaled : Array
        Scaled regressors, ``(n, 2)``.
    found : ndarray of bool
        Whether the mapping turns nowhere between the domain and the solution, ``(n,)``.
    """
    low, high = mapping.box
    sides = (np.linspace(a, z, FINE) for a, z in zip(low, high, strict=True))
    grid = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    value = mapping.at_scaled(mean, grid[None])[0]
    blocks = range(0, max(len(pixels), 1), NEAREST)
    start = np.concatenate(
        [
            grid[((pixels[i : i + NEAREST, None] - value) ** 2).sum(axis=2).argmin(axis=1)]
            for i in blocks
        ]
    )
    at, found = newton(mapping, mean, pixels[None], start[None])
    return at[0], found[0] & monotone(mapping, mean, at[0])


def monotone(mapping: PolynomialMap, mean: Array, scaled: Array) -> BoolArray:
    """Whether the mean's mapping turns nowhere from the calibrated domain to places, ``(n,)``."""
    low, high = mapping.box
    if not mapping.bivariate:
        ends = [_branch(b[0], *pair) for b, pair in zip(
            mapping.amplitudes(mean), zip(low, high, strict=True), strict=True
        )]  # fmt: skip
        within_both = [(s > a) & (s < z) for s, (a, z) in zip(scaled.T, ends, strict=True)]
        return np.asarray(np.all(within_both, axis=0))
    middle = (low + high) / 2
    _, slope = mapping.with_slopes(mean, middle[None, None])
    sign, start = np.sign(_det(slope)[0, 0]), np.clip(scaled, low, high)
    ok = np.ones(len(scaled), dtype=bool)
    for share in np.linspace(0, 1, PATH):
        _, slope = mapping.with_slopes(mean, ((1 - share) * start + share * scaled)[None])
        ok &= np.sign(_det(slope)[0]) == sign
    return ok


def _branch(b: Array, low: float, high: float) -> tuple[float, float]:
    """Find the ends of the monotone piece of a Legendre series around the domain's middle."""
    turns, middle = _turns(b), (low + high) / 2
    below, above = turns[turns < middle], turns[turns > middle]
    return float(below.max(initial=-np.inf)), float(above.min(initial=np.inf))
