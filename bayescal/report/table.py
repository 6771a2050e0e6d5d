"""Tables as values: made once, shown by a terminal and by a page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """What stands above a column, and what it means.

    Attributes
    ----------
    head : str
        As a terminal shows it.
    note : str
        What the column says, in a sentence without a full stop; empty where the head
        says all.
    title : str
        As a page shows it; the head where empty.
    """

    head: str
    note: str = ""
    title: str = ""

    @property
    def shown(self) -> str:
        """The head on a page."""
        return self.title or self.head


@dataclass(frozen=True)
class Cell:
    """What is shown, and the number to sort by (None: nothing to sort by)."""

    text: str
    value: float | None = None


@dataclass(frozen=True)
class Table:
    """Rows of cells under columns; the first names the row, alone or with those after it.

    Attributes
    ----------
    rows : tuple of tuple of Cell
        One cell for each column.
    marked : int or None
        The row to stress.
    by_order : bool
        Whether rows are orders or models, so that the marked one is the recommended one.
    spare : tuple of str
        Heads of the columns a terminal leaves out, in this order, where the numbers
        are so wide that not all fit.
    naming : int
        How many columns, from the first, it takes to name a row.
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    marked: int | None = None
    by_order: bool = False
    spare: tuple[str, ...] = ()
    naming: int = 1


def order_table(
    orders: Sequence[int],
    columns: Sequence[Column],
    rows: Sequence[Sequence[Cell]],
    chosen: int | None,
    *,
    head: Column | None = None,
    spare: Sequence[str] = (),
) -> Table:
    """Make a table of a row per order, the chosen one marked.

    Parameters
    ----------
    columns : sequence of Column
        After the one of the order.
    rows : sequence of sequence of Cell
        One row per order, without the order.
    chosen : int or None
        The recommended order.
    head : Column, optional
        Of the first column.
    """
    first = head or Column("order", "degree of the polynomial")
    cells = [(Cell(str(k), k), *row) for k, row in zip(orders, rows, strict=True)]
    marked = next((row for row, k in enumerate(orders) if k == chosen), None)
    return Table((first, *columns), tuple(cells), marked, True, tuple(spare))


def number_cell(value: float | None, form: Callable[[float], str]) -> Cell:
    """Make a cell that shows a number and is sorted by it; blank where there is none."""
    return Cell("") if value is None else Cell(form(value), value)


def plain_table(heads: Sequence[str], rows: Sequence[tuple[Cell, ...]]) -> Table:
    """Make a table whose heads say all."""
    return Table(tuple(map(Column, heads)), tuple(rows))


def answers_table(
    columns: Sequence[str | Column],
    names: Iterable[tuple[Cell, ...]],
    cells: Callable[[int], Iterable[Cell] | None],
    remarks: Sequence[str],
    spare: Sequence[str] = (),
) -> Table:
    """Make a table of a row per answer, as many as there are remarks, which end the rows.

    Parameters
    ----------
    names : iterable of tuple of Cell
        What each row begins with.
    cells : callable
        From a row's number to its answer; None where there is none.
    """
    heads = tuple(c if isinstance(c, Column) else Column(c) for c in columns)
    rows = []
    for i, (name, remark) in enumerate(zip(names, remarks, strict=False)):
        answer = cells(i)
        blank = [Cell("")] * (len(heads) - len(name) - 1)
        rows.append((*name, *(blank if answer is None else answer), Cell(remark)))
    return Table(heads, tuple(rows), spare=tuple(spare))
