"""The thesis's Appendix B, restated straight from the listing: normal matrices and all.

Also the models of its text (eq. 35-53), and both solved without rounding.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

import bayescal as bc

ORDERS = (1, 2, 3, 4, 5)
MODELS = [(v, a, k) for v in ("as-coded", "as-written") for a in "rc" for k in ORDERS]


def columns(variant: str, axis: str, order: int, x, y, z) -> list:
    """Columns of X or Y as the listing names them; numpy arrays or lists of fractions."""
    w = [a / b for a, b in zip(x, z, strict=True)]
    u = [a / b for a, b in zip(y, z, strict=True)]
    one = [a / a for a in z]
    if axis == "c":
        powers = [u, u, u, u, u]  # U1 ... U5
    elif variant == "as-coded":
        powers = [w, w, u, u, u]  # W3= (y./z).^3; W4= (y./z).^4; W5= (y./z).^5;
    else:
        powers = [w, w, w, w, w]  # eq. 52
    return [one, *([v**k for v in base] for k, base in enumerate(powers[:order], 1))]


def listing(variant: str, axis: str, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients and residuals as the listing computes them, in doubles."""
    world, pixels = bc.thesis().world, bc.thesis().pixels
    x, y, z = world[:, 0] - 330, world[:, 1] - 57, world[:, 2] - 0
    t = pixels[:, 0] if axis == "r" else 1080 - pixels[:, 1]
    design = np.column_stack(columns(variant, axis, order, x, y, z))
    # A= inv(X'*X)*X'*r;
    coefficients = np.linalg.inv(design.T @ design) @ design.T @ t
    # r1= A(1)+A(2)*W1; r_err = r- r1;
    return coefficients, t - design @ coefficients


def exact_listing(variant: str, axis: str, order: int) -> tuple[list[Fraction], list[Fraction]]:
    """The same in rational arithmetic, from the integers of Appendix A."""
    world = [[Fraction(int(v)) for v in row] for row in bc.thesis().world]
    x, y, z = ([row[j] - (330, 57, 0)[j] for row in world] for j in range(3))
    pixels = bc.thesis().pixels
    if axis == "r":
        t = [Fraction(int(v)) for v in pixels[:, 0]]
    else:
        t = [Fraction(1080 - int(v)) for v in pixels[:, 1]]
    design = columns(variant, axis, order, x, y, z)
    normal = [[_dot(a, b) for b in design] + [_dot(a, t)] for a in design]
    coefficients = _solve(normal)
    predicted = [
        sum((c * column[i] for c, column in zip(coefficients, design, strict=True)), Fraction(0))
        for i in range(len(t))
    ]
    return coefficients, [a - b for a, b in zip(t, predicted, strict=True)]


def _dot(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return sum((p * q for p, q in zip(a, b, strict=True)), Fraction(0))


def _solve(rows: list[list[Fraction]]) -> list[Fraction]:
    """Gauss-Jordan on [matrix | right-hand side]."""
    size = len(rows)
    for i in range(size):
        rows[i] = [v / rows[i][i] for v in rows[i]]
        for j in range(size):
            if j != i:
                rows[j] = [a - rows[j][i] * b for a, b in zip(rows[j], rows[i], strict=True)]
    return [row[-1] for row in rows]
