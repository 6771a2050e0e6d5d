"""Many data sets made of the same points: some left out, or counted several times.

With [X | t] = Q R, the rows of Q, counted w_i times, are factorised once more for each
data set. Where they are many, their Gram matrix Q' diag(w) Q takes their place: it is
near the identity, so that its square root loses little, and one small factorisation per
data set replaces one of all its points. Domain and prior stay those of the full data.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.linear.evidence import Reduced
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import PolynomialMap

# Numbers up to which rows are factorised themselves, and numbers held at once.
SMALL = 20_000
CHUNK = 4_000_000


@dataclass(frozen=True, eq=False)
class Rows:
    """Orthonormal rows of the weighted [design | pixels].

    Attributes
    ----------
    q : Array
        ``(n_points, m)``, m at most the number of coefficients plus one.
    r : Array
        ``(m, n_coefficients + 1)``.
    log_sd : Array
        ln of the known deviations, ``(n_points,)``; 0 without them.
    monomials : PolynomialMap
        Knows how many columns belong to an order.
    """

    q: Array
    r: Array
    log_sd: Array
    monomials: PolynomialMap

    @classmethod
    def of(cls, data: AxisData, order: int) -> Rows:
        """Factorise an axis at the highest order wanted."""
        q, r = np.linalg.qr(data.weighted(order))
        return cls(q, r, np.log(data.deviations), data.monomials(order))

    def without(self, members: Array) -> DataSets:
        """Leave out points: one data set for each row of `members`.

        Parameters
        ----------
        members : Array
            1 where a point is left out, else 0, ``(n_sets, n_points)``.
        """
        return self.counted(1.0 - members)

    def counted(self, counts: Array) -> DataSets:
        """Count points several times: one data set for each row of `counts`.

        Parameters
        ----------
        counts : Array
            How often each point stands in the set, ``(n_sets, n_points)``.
        """
        step = len(counts) if self.q.size > SMALL else max(1, CHUNK // self.q.size)
        roots = self._roots_of_gram if self.q.size > SMALL else self._roots_of_rows
        columns = self.r.shape[1]
        triangles = []
        for start in range(0, len(counts), max(step, 1)):
            root = roots(counts[start : start + step])
            square = np.zeros((len(root), columns, columns))
            square[:, : root.shape[1]] = root @ self.r
            triangles.append(np.linalg.qr(square, mode="r"))
        n, log_sd = counts.sum(axis=1), counts @ self.log_sd
        return DataSets(np.concatenate(triangles), n, log_sd, self.monomials)

    def _roots_of_rows(self, counts: Array) -> Array:
        """Triangles of the counted rows: exact for degenerate sets too."""
        return np.asarray(np.linalg.qr(np.sqrt(counts)[:, :, None] * self.q, mode="r"))

    def _roots_of_gram(self, counts: Array) -> Array:
        """Square roots of the counted rows' Gram matrices."""
        m = self.q.shape[1]
        products = (self.q[:, :, None] * self.q[:, None, :]).reshape(-1, m * m)
        return roots_of((counts @ products).reshape(-1, m, m))


def roots_of(grams: Array) -> Array:
    """Square roots A with A'A = G of Gram matrices, ``(n_sets, m, m)``."""
    values, vectors = np.linalg.eigh(grams)
    return np.asarray(np.sqrt(np.maximum(values, 0))[:, :, None] * vectors.transpose(0, 2, 1))


@dataclass(frozen=True, eq=False)
class DataSets:
    """Triangles of [design | pixels] of many data sets at the highest order.

    Attributes
    ----------
    triangles : Array
        ``(n_sets, n_coefficients + 1, n_coefficients + 1)``.
    n, log_sd : Array
        Number of points and sum of ln sd, ``(n_sets,)``.
    monomials : PolynomialMap
        Knows how many columns belong to an order.
    """

    triangles: Array
    n: Array
    log_sd: Array
    monomials: PolynomialMap

    def reduced(self, order: int) -> Reduced:
        """Take the leading blocks that belong to an order up to the factorised one."""
        size = self.monomials.columns(order)
        dropped = self.triangles[:, size:, -1]
        return Reduced(
            self.triangles[:, :size, :size],
            self.triangles[:, :size, -1],
            np.einsum("sj,sj->s", dropped, dropped),
            self.n,
            self.log_sd,
        )
