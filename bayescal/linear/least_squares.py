"""One orthogonal factorisation serves all orders of a nested linear family."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array, frozen
from bayescal.errors import InputError
from bayescal.linear.evidence import Reduced
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import PolynomialMap
from bayescal.polynomials.whole import Whole

# Condition number of the columns, scaled to unit length, beyond which they are dependent.
LARGEST_CONDITION = 1e15

# Points factorised at once.
PART = 65536


@dataclass(frozen=True, eq=False)
class Factorisation:
    """QR factorisation of the weighted [design | pixels] at the highest order.

    The leading block of R and of Q't belongs to every lower order, whose residual
    sum of squares adds the squares of the dropped entries of Q't (Golub & Van Loan,
    Matrix Computations, 5.3.3). After this nothing touches the points again.

    Attributes
    ----------
    r : Array
        Upper triangle R, ``(n_coefficients, n_coefficients)``, per px of weight.
    qt : Array
        Q't, ``(n_coefficients,)``.
    tail : float
        Residual norm beyond the highest order.
    n : int
        Number of points.
    largest : float
        Largest weighted pixel in size: the scale of rounding.
    log_sd : float
        Sum of ln sd over the points with known deviations; 0 without them.
    monomials : PolynomialMap
        From Legendre amplitudes to monomial coefficients.
    """

    r: Array
    qt: Array
    tail: float
    n: int
    largest: float
    log_sd: float
    monomials: PolynomialMap

    def rss(self, order: int) -> float:
        """Weighted residual sum of squares of an order."""
        dropped = np.append(self.qt[self.monomials.columns(order) :], self.tail)
        return float(dropped @ dropped)

    def reduced(self, order: int) -> Reduced:
        """R, Q't and residual sum of squares of an order: leading blocks."""
        size = self.monomials.columns(order)
        return Reduced(
            self.r[:size, :size],
            self.qt[:size],
            np.array(self.rss(order)),
            np.array(float(self.n)),
            np.array(self.log_sd),
        )

    def exact_fit(self, order: int) -> bool:
        """Whether the residuals are rounding: RSS below n (64 eps max|t|)^2."""
        return only_rounding(self.rss(order), self.n, self.largest)


def only_rounding(rss: float, n: int, largest: float) -> bool:
    """Whether a residual sum of squares is rounding: below n (64 eps max|t|)^2.

    Parameters
    ----------
    rss : float
        Weighted as the pixels are.
    n : int
        Number of points.
    largest : float
        Largest weighted pixel in size.
    """
    return rss <= n * (64 * float(np.finfo(float).eps) * largest) ** 2


def factorise(data: AxisData, order: int) -> Factorisation:
    """Factorise the weighted [design | pixels] of an axis.

    Parameters
    ----------
    order : int
        Highest order wanted.

    Raises
    ------
    InputError
        Where the points can't determine that order.
    """
    data.check(order)
    if data.whole is not None:
        return _leading(data, data.whole, order)
    triangle, largest = _triangle(data, order)
    size = data.columns(order)
    _check_determined(data, triangle[:size, :size], order)
    tail = float(abs(triangle[size, size])) if len(data) > size else 0.0
    return Factorisation(
        frozen(triangle[:size, :size]),
        frozen(triangle[:size, size]),
        tail,
        len(data),
        largest,
        float(np.log(data.deviations).sum()),
        data.monomials(order),
    )


def _triangle(data: AxisData, order: int) -> tuple[Array, float]:
    """R of the weighted [design | pixels], and its largest pixel; of many points part by part.

    Each part is stacked below the triangle so far, which is factorised again
    (`bayescal.linear.reduction`).
    """
    triangle, largest = np.empty((0, data.columns(order) + 1)), 0.0
    for start in range(0, len(data), PART):
        part = data.weighted(order, slice(start, start + PART))
        largest = max(largest, float(np.abs(part[:, -1]).max()))
        triangle = np.linalg.qr(np.concatenate([triangle, part]), mode="r")
    return triangle, largest


def _leading(data: AxisData, whole: Whole, order: int) -> Factorisation:
    """Take the factorisation of an order from that of all points, read in chunks."""
    if order > whole.order:
        raise InputError(
            f"{data.source}: was reduced up to order {whole.order} as it was read; compare order "
            f"{order} from the file itself"
        )
    triangle, log_sd = whole.plain, 0.0
    if data.sd is not None:
        assert whole.weighted is not None, "points with deviations are reduced with them"
        triangle, log_sd = whole.weighted, whole.log_sd
    size = data.columns(order)
    _check_determined(data, triangle.r[:size, :size], order)
    return Factorisation(
        frozen(triangle.r[:size, :size]),
        frozen(triangle.qt[:size]),
        float(np.linalg.norm([*triangle.qt[size:], triangle.tail])),
        whole.n,
        triangle.largest,
        log_sd,
        data.monomials(order),
    )


def _check_determined(data: AxisData, triangle: Array, order: int) -> None:
    """Refuse columns that depend on one another to rounding, as of one regressor far away."""
    scaled = triangle / np.linalg.norm(triangle, axis=0)
    if np.linalg.cond(scaled) < LARGEST_CONDITION:
        return
    works = order - 1
    while works and _condition(scaled, data.columns(works)) >= LARGEST_CONDITION:
        works -= 1
    raise InputError(
        f"{data.source}: axis {data.axis}: the values of {data.regressor} leave order "
        f"{order} undetermined to rounding (does one lie far from all others?); the "
        f"highest order that works is {works}"
    )


def _condition(triangle: Array, size: int) -> float:
    return float(np.linalg.cond(triangle[:size, :size]))


@dataclass(frozen=True, eq=False)
class LeastSquaresFit:
    """Maximum-likelihood coefficients of one order.

    Attributes
    ----------
    coefficients : Array
        Monomial coefficients, lowest powers first, ``(p,)``, px.
    standard_errors : Array or None
        Their standard errors at `sigma_hat` (or at the known deviations),
        ``(p,)``, px; None where no degree of freedom is left.
    amplitudes : Array
        Legendre amplitudes b_j, ``(p,)``, px.
    rss : float
        Residual sum of squares, px^2 (with known deviations: dimensionless).
    dof : int
        n - p.
    sigma_hat : float or None
        sqrt(rss / dof), px; None where dof is 0.
    exact : bool
        Whether the residuals are rounding only.
    """

    order: int
    coefficients: Array
    standard_errors: Array | None
    amplitudes: Array
    rss: float
    dof: int
    sigma_hat: float | None
    exact: bool


def solve(factors: Factorisation, order: int, sigma: float | None = None) -> LeastSquaresFit:
    """Least-squares coefficients of one order, in amplitudes and in monomials.

    Parameters
    ----------
    order : int
        Up to the factorised one.
    sigma : float, optional
        Known noise level for the standard errors (1 with known deviations);
        by default `sigma_hat` of the fit.
    """
    data = factors.reduced(order)
    amplitudes = solve_triangular(data.r, data.qt)
    rss = factors.rss(order)
    dof = factors.n - len(amplitudes)
    sigma_hat = float(np.sqrt(rss / dof)) if dof > 0 else None
    scale = sigma if sigma is not None else sigma_hat
    errors = None
    if scale is not None:
        inverse = solve_triangular(data.r, np.eye(len(amplitudes)))
        errors = frozen(scale * np.linalg.norm(factors.monomials.apply(inverse), axis=1))
    return LeastSquaresFit(
        order,
        frozen(factors.monomials.apply(amplitudes)),
        errors,
        frozen(amplitudes),
        rss,
        dof,
        sigma_hat,
        factors.exact_fit(order),
    )
