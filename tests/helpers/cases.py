"""What the tests of the defence share: points of known truth, and refits by brute force."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

import numpy as np
from numpy.polynomial.legendre import legval

import bayescal as bc
from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.comparison.settings import Settings
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import Factorisation
from bayescal.linear.model import LinearModel
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import MonomialMap
from bayescal.prior.amplitudes import PriorRule
from bayescal.report.document.comparison import comparison_document
from bayescal.report.document.shared import dumps
from bayescal.report.terminal import render
from bayescal.report.views.comparison import brief
from tests.helpers.problems import legendre_columns, make_axis

WIDTH, HEIGHT = 1920.0, 1080.0


def curve(n: int, amplitudes: Sequence[float], noise: float, seed: int = 0, sd=None) -> AxisData:
    """An axis of a Legendre polynomial with Gaussian noise, evenly spaced."""
    rng = np.random.default_rng(seed)
    s = np.linspace(-1, 1, n)
    return make_axis(s, legval(s, amplitudes) + noise * rng.standard_normal(n), sd=sd)


def refit(data: AxisData, order: int, rows, noise: NoiseLevel, rule: PriorRule) -> LinearModel:
    """A model of some rows, each as often as it is named, factorised from scratch.

    The basis is Bonnet's on the domain of all points; the prior is that of all points.
    """
    rows = np.asarray(rows, dtype=int)
    augmented = np.column_stack([legendre_columns(data, order), data.t])[rows]
    log_sd = 0.0
    if data.sd is not None:
        augmented = augmented / data.sd[rows, None]
        log_sd = float(np.log(data.sd[rows]).sum())
    size = order + 1
    padded = np.vstack([augmented, np.zeros((size + 1, size + 1))])
    triangle = np.linalg.qr(padded, mode="r")
    factors = Factorisation(
        triangle[:size, :size],
        triangle[:size, size],
        abs(float(triangle[size, size])),
        len(rows),
        float(np.abs(data.t).max()),
        log_sd,
        MonomialMap(data.domain, order),
    )
    return LinearModel(factors, order, noise, rule.of_order(order), data.symbol)


def refitted_evidence(data, order, rows, noise, rule) -> float:
    """Log integral of likelihood times prior of some rows alone."""
    return exact_posterior(refit(data, order, rows, noise, rule)).log_integral


def all_but(n: int, out) -> np.ndarray:
    """Indices of n points less some."""
    return np.setdiff1d(np.arange(n), out)


def camera_points(
    n: int,
    amplitudes: Sequence[float] = (960.0, 700.0),
    noise: float = 1.0,
    seed: int = 0,
    *,
    shift=None,
    width: float | None = WIDTH,
    depth=None,
    **columns,
) -> bc.Correspondences:
    """Points with r a Legendre polynomial of x/z and c a straight line of y/z.

    `shift` is added to r (px). By default every point has a depth of its own, so that
    there are no groups.
    """
    rng = np.random.default_rng(seed)
    s = np.linspace(-1, 1, n)
    other = rng.uniform(-0.3, 0.3, n)
    z = 100.0 + np.arange(n) if depth is None else np.asarray(depth, dtype=float)
    r = legval(s, amplitudes) + noise * rng.standard_normal(n)
    c = 540 + 1000 * other + noise * rng.standard_normal(n)
    if shift is not None:
        r = r + np.asarray(shift(s, other) if callable(shift) else shift)
    return bc.Correspondences.from_arrays(
        np.column_stack([0.6 * s * z, other * z, z]),
        np.column_stack([r, c]),
        setup=bc.Setup(width=width, height=HEIGHT),
        **columns,
    )


def defended(points: bc.Correspondences, orders=(1, 2, 3), axis: str = "r", **options):
    """Compare and defend one axis with the least sampling."""
    result = bc.compare(points, orders, axis=axis, defend=True, ess=100, **options)
    return result.axes[axis]


def printed(result: Comparison) -> str:
    """What compare prints."""
    return render(brief(result), terminal=False)


def result_document(result: Comparison) -> dict:
    """The result document as a reader gets it back."""
    return json.loads(dumps(comparison_document(result, "test")))


def axis_document(axis: AxisComparison) -> dict:
    """One axis of the result document."""
    name = axis.data.axis
    whole = Comparison({name: axis}, "separable", None, Settings(ess=100), ())
    return result_document(whole)["axes"][name]


def not_a_number(text: str) -> list[str]:
    """Words of a text that stand for no number; a sentence may say that none is."""
    return re.findall(r"\b(?:(?i:nan|inf|infinity)|None)\b", text)
