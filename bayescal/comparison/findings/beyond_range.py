"""What orders beyond the compared range say against its winner."""

from __future__ import annotations

from collections.abc import Iterator

from bayescal.comparison.evidence import PLAUSIBLE
from bayescal.comparison.finding import Finding, overturns
from bayescal.comparison.orders.beyond import Beyond
from bayescal.rounding import percent


def beyond_range(found: Beyond, *, at_edge: bool) -> Iterator[Finding]:
    """Find orders beyond the range that would win, or, of a winner at its edge, are plausible.

    Below the edge the orders compared above the winner say already how much they matter.
    """
    if not found.orders:
        return
    fitted = [k for k in found.probability if k not in found.orders]
    where = "beyond the compared range" if len(fitted) > 1 else f"above order {fitted[0]}"
    orders = ", ".join(str(k) for k in found.orders)
    together = sum(found.probability[k] for k in found.orders)
    if found.winner is not None:
        yield overturns(
            "edge",
            f"order {found.winner}, {where}, would win "
            f"({percent(found.probability[found.winner])} with orders {orders} compared too): "
            "compare more orders",
            f"order {found.winner}, which was not compared, would win",
        )
    elif at_edge and together > 1 - PLAUSIBLE:
        yield overturns(
            "edge",
            f"orders {orders}, {where}, would have {percent(together)} "
            "together: compare more orders",
            "higher orders, which were not compared, can't be excluded",
        )
