"""How the parameters of a model move together: one table of covariance and correlation."""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.arrays import Array
from bayescal.report.blocks import Tabled
from bayescal.report.table import Cell, Column, Table

CAPTION = "covariance on and above the diagonal, correlations below it"


def covariance_tabled(id: str, of: str, names: Sequence[str], matrix: Array) -> Tabled:
    """Show how the parameters of a model move together.

    Parameters
    ----------
    of : str
        Whose parameters, such as ``"r at order 4"``.
    matrix : Array
        Covariance, square in the names.
    """
    return Tabled(id, f"Parameters of {of}: {CAPTION}.", covariance_table(names, matrix))


def covariance_table(names: Sequence[str], matrix: Array) -> Table:
    """One row and one column per parameter."""
    sd = matrix.diagonal() ** 0.5
    rows = [
        (
            Cell(name, i),
            *(
                Cell(f"{matrix[i, j]:.3g}", float(matrix[i, j]))
                if j >= i
                else Cell(f"{(rho := float(matrix[i, j] / sd[i] / sd[j])):+.3f}", rho)
                for j in range(len(names))
            ),
        )
        for i, name in enumerate(names)
    ]
    return Table((Column("parameter"), *map(Column, names)), tuple(rows))
