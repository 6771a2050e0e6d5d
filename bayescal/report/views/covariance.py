"""How the parameters of a model move together: one table of covariance and correlation."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

from bayescal.arrays import Array
from bayescal.inference.correlation import correlation_of
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
    rho = correlation_of(matrix)
    rows = [
        (Cell(name, i), *(_cell(matrix, rho, i, j) for j in range(len(names))))
        for i, name in enumerate(names)
    ]
    return Table((Column("parameter"), *map(Column, names)), tuple(rows))


def _cell(matrix: Array, rho: Array, i: int, j: int) -> Cell:
    if j >= i:
        return Cell(f"{matrix[i, j]:.3g}", float(matrix[i, j]))
    if isnan(rho[i, j]):
        return Cell("")
    return Cell(f"{round(float(rho[i, j]), 3) + 0.0:+.3f}", float(rho[i, j]))
