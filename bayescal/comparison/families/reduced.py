"""Many points brought to what families with a closed form need of them."""

from __future__ import annotations

from bayescal.comparison.families.further import MORE
from bayescal.comparison.families.models import LINEAR, reduced_name
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.many import beyond, can_reduce, reduced
from bayescal.comparison.settings import Settings
from bayescal.points.chunks.many import ManyPoints
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials.whole import Whole


def can_reduce_families(points: ManyPoints, request: FamilyRequest, settings: Settings) -> bool:
    """Whether families need no more of points than their reduction: those with a closed form."""
    return not (request.moves or settings.defend) and can_reduce(points, settings)


def reduce_families(
    points: ManyPoints, request: FamilyRequest, settings: Settings
) -> tuple[Correspondences, dict[str, Whole]]:
    """Read points once for families with a closed form; the rest as of `reduce_points`."""
    highest = max(
        order for family in request.families for some in request.orders_of(family) for order in some
    )
    wanted = {
        reduced_name(family, axis): (LINEAR[family], axis, beyond(highest, MORE))
        for family in request.families
        for axis in AXES
    }
    return reduced(points, wanted, settings)
