"""Points from a known truth: a layout, coefficients from the prior or given, Gaussian noise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.comparison.settings import checked_orders
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES, LARGEST_PX, Setup
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import Domain, MonomialMap, legendre_design
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import PriorRule

DEFAULT_TAU = 0.02
DEFAULT_N = 57
LARGEST_N = 1_000_000
# The camera where none is given: the thesis's image.
DEFAULT_SETUP = Setup(width=1920.0, height=1080.0, c_from_bottom=True)
# The volume in front of the camera, uniform in each: x/z, y/z, and z in world units.
VOLUME = ((-0.6, 0.6), (-0.35, 0.35), (300.0, 1500.0))
# Half the image that a simulated camera fills, as a fraction of it.
FILLED = 0.4
# World coordinates are drawn to this many decimals, so that a file of them can be read.
_DECIMALS = 3


@dataclass(frozen=True, eq=False)
class AxisTruth:
    """What the pixels of one axis were made with.

    Attributes
    ----------
    axis : str
    regressor : str
        ``"x/z"`` or ``"y/z"``.
    order : int
    domain : Domain
        Of the regressor.
    amplitudes : Array
        Legendre amplitudes b_j, ``(order + 1,)``, px at the edge of the domain.
    coefficients : Array
        Monomial coefficients alpha_j or beta_j, ``(order + 1,)``, px.
    sigma : float
        Standard deviation of the noise, px.
    tau : float or None
        Strength that the amplitudes were drawn with; None where they were given or
        order 1 has none.
    """

    axis: str
    regressor: str
    order: int
    domain: Domain
    amplitudes: Array
    coefficients: Array
    sigma: float
    tau: float | None


@dataclass(frozen=True, eq=False)
class Truth:
    """What simulated points were made with, by axis."""

    axes: dict[str, AxisTruth]


def simulate(
    orders: Mapping[str, int],
    sigma: float,
    rng: np.random.Generator,
    *,
    n: int | None = None,
    like: Correspondences | None = None,
    setup: Setup | None = None,
    tau: float | None = None,
    coefficients: Mapping[str, Sequence[float]] | None = None,
) -> tuple[Correspondences, Truth]:
    """Simulate points of the separable family with Gaussian pixel noise.

    Parameters
    ----------
    orders : mapping of str to int
        Order of ``"r"`` and of ``"c"``; not used where coefficients are given.
    sigma : float
        Standard deviation of the noise of both axes, px; 0 for none.
    rng : numpy.random.Generator
        Layout, coefficients and noise each have a child of their own: with the same
        seed another sigma scales the same noise.
    n : int, optional
        Number of points; that of `like`, else 57.
    like : Correspondences, optional
        Takes its world points: all of them as often as n allows, and of the rest some
        drawn without replacement. By default they are drawn over `VOLUME`.
    setup : Setup, optional
        The camera; that of `like`, else `DEFAULT_SETUP`.
    tau : float, optional
        Strength of the non-linearity, 0.02 by default: from order 2 on amplitudes are
        drawn from the field prior at this tau, on the domain of these points. The linear
        part is that of a camera whose points fill 0.8 of the image about its centre.
    coefficients : mapping of str to sequence of float, optional
        Monomial coefficients of an axis, lowest power first, px, in place of drawn ones.

    Returns
    -------
    points : Correspondences
        With c recorded as the setup says.
    truth : Truth

    Raises
    ------
    InputError
        Where a setting can't be used or the points can't determine an order.
    """
    given = dict(coefficients or {})
    n = (len(like) if like is not None else DEFAULT_N) if n is None else n
    _check(sigma, n, tau, given)
    setup = setup or (like.setup if like is not None else DEFAULT_SETUP)
    layout_rng, *axis_rngs = rng.spawn(1 + len(AXES))
    blank = _drawn(n, setup, layout_rng) if like is None else _taken(like, n, setup, layout_rng)
    pixels, truths = np.empty((n, len(AXES))), {}
    for column, (axis, axis_rng) in enumerate(zip(AXES, axis_rngs, strict=True)):
        data = axis_data(blank, axis)
        (order,) = checked_orders([len(given[axis]) - 1 if axis in given else orders[axis]])
        data.check(order)
        coefficient_rng, noise_rng = axis_rng.spawn(2)
        if axis in given:
            truth = _stated(data, given[axis], sigma)
        else:
            truth = _from_prior(data, order, sigma, tau or DEFAULT_TAU, coefficient_rng)
        truths[axis] = truth
        design = legendre_design(data.domain.scale(data.x), order)
        pixels[:, column] = design @ truth.amplitudes + sigma * noise_rng.normal(size=n)
    if setup.c_from_bottom:
        assert setup.height is not None, "Setup refuses c_from_bottom without a height"
        pixels[:, 1] = setup.height - pixels[:, 1]
    points = Correspondences.from_arrays(
        blank.world, pixels, labels=blank.labels, groups=blank.groups, setup=setup
    )
    return replace(points, source=blank.source), Truth(truths)


def _check(sigma: float, n: int, tau: float | None, given: Mapping[str, Sequence[float]]) -> None:
    """Refuse numbers that can't be used."""
    if not 0 <= sigma <= LARGEST_PX:
        raise InputError(f"sigma must be from 0 to {LARGEST_PX:g} px, not {sigma:g}")
    if not 2 <= n <= LARGEST_N:
        raise InputError(f"the number of points must be from 2 to {LARGEST_N}, not {n}")
    if tau is not None and not (math.isfinite(tau) and tau > 0):
        raise InputError(f"tau must be a positive number, not {tau:g}")
    if tau is not None and len(given) == len(AXES):
        raise InputError("tau has no part where the coefficients of both axes are given")
    for axis, values in given.items():
        if not all(abs(v) <= LARGEST_PX for v in values):
            raise InputError(
                f"the coefficients of {axis} must be finite and at most {LARGEST_PX:g} px"
            )


def _drawn(n: int, setup: Setup, rng: np.random.Generator) -> Correspondences:
    """World points over the volume in front of the camera, without pixels yet."""
    w, u, z = (rng.uniform(lower, upper, n) for lower, upper in VOLUME)
    frame = np.column_stack([w * z, u * z, z])
    world = np.round(frame + np.array(setup.position), _DECIMALS)
    return _blank(world, setup)


def _taken(
    like: Correspondences, n: int, setup: Setup, rng: np.random.Generator
) -> Correspondences:
    """World points of others, without pixels yet; copies are told apart by their labels."""
    copies, rest = divmod(n, len(like))
    some = np.sort(rng.permutation(len(like))[:rest])
    index = np.concatenate([np.tile(np.arange(len(like)), copies), some]).astype(int)
    turn = np.arange(n) // len(like)
    labels = [
        like.labels[i] + (f" ({t + 1})" if t else "")
        for i, t in zip(index.tolist(), turn.tolist(), strict=True)
    ]
    groups = None if like.groups is None else tuple(like.groups[i] for i in index.tolist())
    return _blank(like.world[index], setup, tuple(labels), groups)


def _blank(
    world: Array,
    setup: Setup,
    labels: tuple[str, ...] | None = None,
    groups: tuple[str, ...] | None = None,
) -> Correspondences:
    pixels = np.zeros((len(world), 2))
    points = Correspondences.from_arrays(world, pixels, labels=labels, groups=groups, setup=setup)
    return replace(points, source="simulated points")


def _from_prior(
    data: AxisData, order: int, sigma: float, tau: float, rng: np.random.Generator
) -> AxisTruth:
    """Make up a camera that fills its image; its non-linearity is from the field prior."""
    if not data.size_known:
        raise InputError(
            f"the image {PIXEL_AXES[data.axis].side} is not known, and the prior of {data.axis} "
            "needs it; give a setup"
        )
    prior = PriorRule("field", data.size, data.size / 2, tau).of_order(order)
    deviations = prior.deviations(np.log([tau]))[0]
    amplitudes = prior.mean + deviations * rng.normal(size=order + 1)
    amplitudes[:2] = data.size / 2, FILLED * data.size
    monomials = MonomialMap(data.domain, order).apply(amplitudes)
    used = tau if prior.scaled.any() else None
    return _truth(data, amplitudes, monomials, sigma, used)


def _stated(data: AxisData, coefficients: Sequence[float], sigma: float) -> AxisTruth:
    """Monomial coefficients as given: the map to them is triangular, so it is solved exactly."""
    rows = MonomialMap(data.domain, len(coefficients) - 1).exact
    amplitudes: list[Fraction] = []  # of the highest order first
    for j in reversed(range(len(coefficients))):
        above = zip(reversed(rows[j]), amplitudes, strict=False)
        rest = Fraction(coefficients[j]) - sum(m * b for m, b in above)
        amplitudes.append(rest / rows[j][j])
    found = np.array([float(b) for b in reversed(amplitudes)])
    return _truth(data, found, np.array(coefficients, dtype=np.float64), sigma, None)


def _truth(
    data: AxisData, amplitudes: Array, monomials: Array, sigma: float, tau: float | None
) -> AxisTruth:
    return AxisTruth(
        data.axis,
        data.regressor,
        len(amplitudes) - 1,
        data.domain,
        frozen(amplitudes),
        frozen(monomials),
        float(sigma),
        tau,
    )
