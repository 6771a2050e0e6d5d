"""Points that are off: those that the errors do not allow, and those taken for bad."""

from __future__ import annotations

import shlex
from collections import Counter

from bayescal.calibration.judging.bad_points import FEWEST
from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.lenses.gross_errors import MOST
from bayescal.comparison.lenses.results import Evidenced
from bayescal.rounding import percent, significant

TOLD = 3  # points, or views, that are named
SURELY_BAD = 1e-12  # p: the mixture leaves no such point in that it can leave out
MANY = 0.05  # of all points: more that are bad say that something else is wrong


def points_off(basis: Evidenced) -> Finding | None:
    """Name points that the error model can't explain, or views most of whose points are so.

    Where points may be bad these are not probably so, and what they do to the lens is small, but
    for those that could not be left out.
    """
    off, bad = basis.gross, basis.bad
    if not off:
        return None
    gone = Counter(point.view for point in bad.left_out) if bad is not None else Counter[str]()
    of_view = gone + Counter(point.view for point in off)
    counts = dict(zip(basis.views.names, basis.views.counts.tolist(), strict=True))
    named = {}
    for point in off:
        if 2 * of_view[point.view] > counts[point.view] or counts[point.view] == FEWEST:
            own = f"view {point.view} ({of_view[point.view]} of its {counts[point.view]} points)"
            named[own] = point.view
        else:
            where = f" ({point.place})" if basis.views.lines is not None else ""
            size = significant(point.size)
            named[f"view {point.view} point {point.label}{where} by {size} px"] = point.name
    told = list(named)[:TOLD]
    more = f" and {len(named) - len(told)} more" if len(named) > len(told) else ""
    one = len(off) == 1
    least = "at least " if len(off) == MOST else ""
    text = (
        f"{least}{len(off)} of {basis.views.n_points} points {'is' if one else 'are'} further from "
        f"where all the others put {'it' if one else 'them'} than the errors allow (p < 0.01 over "
        f"all points){'' if bad is None else ', and not taken for bad'}: {'; '.join(told)}{more}; "
        f"look at the photograph{'' if one else 's'}, correct {'it' if one else 'them'} or leave "
        f"{'it' if one else 'them'} out: --without {shlex.quote(next(iter(named.values())))}"
    )
    if bad is None and not set(named.values()) & set(counts):
        text += "; or weigh that points may be bad: --noise outlier-mixture"
    elif bad is not None and min(point.p_value for point in off) > SURELY_BAD:
        return limits("gross-errors", text)
    return overturns(
        "gross-errors",
        text,
        "a point is further off than the errors allow"
        if one
        else f"{least}{len(off)} points are further off than the errors allow",
    )


def many_bad(basis: Evidenced) -> Finding | None:
    """Find so many bad points that something else is wrong."""
    if basis.bad is None:
        return None
    n, gone = basis.views.n_points, Counter(point.view for point in basis.bad.left_out)
    if gone.total() <= MANY * n:
        return None
    worst = ", ".join(f"{view} ({count})" for view, count in gone.most_common(TOLD))
    return limits(
        "bad-points",
        f"{percent(gone.total() / n)} of the points are taken for bad, most in {worst}: look at "
        "how they were found, whether neighbours were swapped, and whether a lens is missing",
    )
