r"""Reduces points of any number, chunk by chunk, to the factorisation of an axis.

Sequential TSQR (Demmel, Grigori, Hoemmen & Langou 2012, SIAM J. Sci. Comput. 34, A206): the
triangle so far is stacked on the triangle of the next chunk and factorised again; no normal
matrix is formed. Two things keep its digits where n is large and the noise small:

* What is factorised beside the design is not t but t less the best polynomial so far, which is
  as small as the noise. Rounding is relative to what is factorised: at 10^6 points of 0.001 px
  it costs 2e-7 nat of evidence at most, and 2e-6 without this (scripts/many_points.py).
* The domain widens as points come. Legendre polynomials on the wider domain are those on the
  narrower one times a triangular matrix, so that Q stays and R is multiplied by it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from scipy.linalg import lapack

from bayescal.arrays import Array, frozen
from bayescal.polynomials.basis import Domain, basis_change, distinct_values, legendre_rows
from bayescal.polynomials.plane import plane_change, plane_columns, plane_rows
from bayescal.polynomials.whole import Triangle, Whole

# From scaled regressors to the design's columns, one after the other.
Rows: TypeAlias = Callable[[Sequence[Array]], Array]

# Points factorised at once: their design fits into a core's cache.
BLOCK = 8192
# A chunk whose residuals are mostly what its own fit explains is done again with that fit.
EXPLAINED = 1e6
AGAIN = 3
# Distinct values of a regressor that are counted: more than any order needs.
COUNTED = 64
# Directions that the points so far determine no better than this stay as they are.
DETERMINED = 1e-10


class Reduction:
    """One axis, reduced as its points come.

    Parameters
    ----------
    order : int
        Highest order wanted.
    across : bool, optional
        Whether the polynomial is one of both regressors.
    """

    def __init__(self, order: int, *, across: bool = False) -> None:
        self.order = order
        self.n = 0
        self._sides = [_Side() for _ in range(1 + across)]
        self._log_sd: list[float] = []
        self._readings: Domain | None = None
        self._values: Array = np.empty(0)
        self._size = plane_columns(order) if across else order + 1
        self._plain = _Sum(self._size)
        self._weighted: _Sum | None = None

    def add(self, x: Array, t: Array, sd: Array | None = None, other: Array | None = None) -> None:
        """Take in a chunk.

        Parameters
        ----------
        x, t : Array
            Regressor and pixels, ``(n_chunk,)``, finite.
        sd : Array, optional
            Known deviations, ``(n_chunk,)``, px: in every chunk or in none.
        other : Array, optional
            The other regressor, where the polynomial is one of both.
        """
        both = [x] if other is None else [x, other]
        changed = [side.widen(Domain.of(v)) for side, v in zip(self._sides, both, strict=True)]
        if any(changed):
            self._move()
        self._readings = _union(self._readings, Domain.of(t))
        self.n += len(x)
        self._count(x)
        scaled = [side.frame.scale(v) for side, v in zip(self._sides, both, strict=True)]
        self._plain.add(self._rows, scaled, t)
        if sd is not None:
            if self._weighted is None:
                self._weighted = _Sum(self._size)
            self._weighted.add(self._rows, scaled, t, sd)
            self._log_sd.append(float(np.log(sd).sum()))

    def _rows(self, scaled: Sequence[Array]) -> Array:
        """Columns of the design, one after the other."""
        if len(scaled) == 1:
            return legendre_rows(scaled[0], self.order)
        return plane_rows(scaled[0], scaled[1], self.order)

    def _move(self) -> None:
        """Go over to the frames that the sides have now."""
        changes = [side.moved(self.order) for side in self._sides]
        if self.n:
            change = changes[0]
            if len(changes) > 1:
                change = plane_change(changes[0], changes[1], self.order)
            for kept in (self._plain, self._weighted):
                if kept is not None:
                    kept.change(change)

    def _count(self, x: Array) -> None:
        """Keep distinct values of the regressor, up to a number that no order needs."""
        if len(self._values) < COUNTED:
            values = np.unique(np.concatenate([self._values, x]))
            few = np.linspace(0, len(values) - 1, min(len(values), COUNTED))
            self._values = values[few.astype(np.intp)]

    def whole(self) -> Whole:
        """Give all that the points say of orders up to the highest."""
        assert self._readings is not None, "points were taken in"
        settled = [side.settle() for side in self._sides]
        if any(settled):
            self._move()
        domain, *across = [side.domain for side in self._sides]
        return Whole(
            self.n,
            self.order,
            domain,
            self._readings,
            distinct_values(self._values),
            self._plain.triangle(),
            None if self._weighted is None else self._weighted.triangle(),
            math.fsum(self._log_sd),
            across[0] if across else None,
        )


class _Side:
    """Domain of a regressor, and the frame of its basis, which is never narrower."""

    def __init__(self) -> None:
        self._domain: Domain | None = None
        self.frame, self._before = Domain(0.0, 0.0), Domain(0.0, 0.0)

    @property
    def domain(self) -> Domain:
        """Of all points so far."""
        assert self._domain is not None, "points were taken in"
        return self._domain

    def widen(self, seen: Domain) -> bool:
        """Let the frame reach as far as the points of a chunk; whether it changed."""
        begun = self._domain is not None
        self._domain = _union(self._domain, seen)
        frame = _union(self.frame, seen) if begun else self._domain
        if frame.half_range == 0:  # all alike so far: any narrow interval about them
            width = max(abs(frame.lower) * 1e-9, 1e-300)
            frame = Domain(frame.lower - width, frame.upper + width)
        return self._to(frame)

    def settle(self) -> bool:
        """Let the frame be the domain; whether it changed."""
        return self._to(self.domain if self.domain.half_range > 0 else self.frame)

    def _to(self, frame: Domain) -> bool:
        self._before, self.frame = self.frame, frame
        return frame != self._before

    def moved(self, order: int) -> Array:
        """From the basis on the frame before to that on the frame now."""
        if self._before.half_range == 0 or self._before == self.frame:
            return np.eye(order + 1)
        change, self._before = basis_change(self._before, self.frame, order), self.frame
        return change


class _Sum:
    """Triangle of [design | t less the best polynomial so far], and that polynomial."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._r = np.zeros((size, size))
        self._q = np.zeros(size)
        self._best = np.zeros(size)
        self._rss: list[float] = []
        self._largest = 0.0

    def change(self, change: Array) -> None:
        """Go over to another basis, on a wider domain; Q't = q + R best stays what it is."""
        fitted = self._r @ self._best
        self._r = self._r @ change
        self._best = np.linalg.lstsq(self._r, fitted, rcond=DETERMINED)[0]
        self._q = self._q + (fitted - self._r @ self._best)

    def add(self, rows: Rows, scaled: Sequence[Array], t: Array, sd: Array | None = None) -> None:
        """Stack a chunk below; `rows` makes the design's columns of scaled regressors."""
        for attempt in range(AGAIN):
            stacked, rss, largest = self._reduced(rows, scaled, t, sd)
            triangle = np.linalg.qr(stacked, mode="r")
            r, q = triangle[:-1, :-1], triangle[:-1, -1]
            rss.append(float(triangle[-1, -1] ** 2))
            better = np.linalg.lstsq(r, q, rcond=DETERMINED)[0]
            explained = float(q @ q) > EXPLAINED * math.fsum([*rss, *self._rss])
            if not explained or attempt == AGAIN - 1:
                break
            self._q = self._q - self._r @ better
            self._best = self._best + better
        self._r, self._q = r, q - r @ better
        self._best = self._best + better
        self._rss += rss
        self._largest = max(self._largest, largest)

    def _reduced(
        self, rows: Rows, scaled: Sequence[Array], t: Array, sd: Array | None
    ) -> tuple[Array, list[float], float]:
        """Factorise block by block: triangles stacked below this one, and what they leave."""
        size = self._size
        stacked, rss, largest = [np.column_stack([self._r, self._q])], [], 0.0
        for start in range(0, len(t), BLOCK):
            part = slice(start, start + BLOCK)
            block = np.empty((size + 1, len(t[part])))
            block[:size], block[size] = rows([s[part] for s in scaled]), t[part]
            if sd is not None:
                block /= sd[part]
            largest = max(largest, float(np.abs(block[size]).max()))
            block[size] -= self._best @ block[:size]
            # Its transpose is laid out as LAPACK wants it, and is overwritten.
            upper = np.triu(lapack.dgeqrf(block.T, overwrite_a=True)[0][: size + 1])
            if len(upper) > size:
                rss.append(float(upper[size, size] ** 2))
            stacked.append(upper[:size])
        return np.concatenate(stacked), rss, largest

    def triangle(self) -> Triangle:
        """Give R, Q't and the residual norm."""
        return Triangle(
            frozen(self._r),
            frozen(self._q + self._r @ self._best),
            math.sqrt(math.fsum(self._rss)),
            self._largest,
        )


def _union(one: Domain | None, other: Domain) -> Domain:
    """Smallest interval that holds both."""
    if one is None:
        return other
    return Domain(min(one.lower, other.lower), max(one.upper, other.upper))
