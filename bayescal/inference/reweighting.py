"""Many data sets made of the same points: some left out, or counted several times.

With [X | t] = Q R, points counted w_i times have the Gram matrix R' (Q' diag(w) Q) R.
Q' diag(w) Q is near the identity, so its square root loses nothing, and one small
factorisation per data set replaces one of all its points. Domain and prior stay those
of the full data.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.evidence import Reduced
from bayescal.models.basis import legendre_design
from bayescal.models.linear import AxisData


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
    """

    q: Array
    r: Array
    log_sd: Array

    @classmethod
    def of(cls, data: AxisData, order: int) -> Rows:
        """Factorise an axis at the highest order wanted."""
        design = legendre_design(data.domain.scale(data.x), order)
        augmented = np.column_stack([design, data.t])
        log_sd = np.zeros(len(data))
        if data.sd is not None:
            augmented /= data.sd[:, None]
            log_sd = np.log(data.sd)
        q, r = np.linalg.qr(augmented)
        return cls(q, r, log_sd)

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
        m = self.q.shape[1]
        products = (self.q[:, :, None] * self.q[:, None, :]).reshape(-1, m * m)
        gram = (counts @ products).reshape(-1, m, m)
        values, vectors = np.linalg.eigh(gram)
        root = np.sqrt(np.maximum(values, 0))[:, :, None] * vectors.transpose(0, 2, 1)
        columns = self.r.shape[1]
        tall = np.zeros((len(counts), columns, columns))
        tall[:, :m] = root @ self.r
        return DataSets(np.linalg.qr(tall, mode="r"), counts.sum(axis=1), counts @ self.log_sd)


@dataclass(frozen=True, eq=False)
class DataSets:
    """Triangles of [design | pixels] of many data sets at the highest order.

    Attributes
    ----------
    triangles : Array
        ``(n_sets, n_coefficients + 1, n_coefficients + 1)``.
    n, log_sd : Array
        Number of points and sum of ln sd, ``(n_sets,)``.
    """

    triangles: Array
    n: Array
    log_sd: Array

    def reduced(self, order: int) -> Reduced:
        """Take the leading blocks that belong to an order up to the factorised one."""
        size = order + 1
        dropped = self.triangles[:, size:, -1]
        return Reduced(
            self.triangles[:, :size, :size],
            self.triangles[:, :size, -1],
            np.einsum("sj,sj->s", dropped, dropped),
            self.n,
            self.log_sd,
        )
