"""From points and settings to a comparison across families: the loop over joint models."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from threadpoolctl import threadpool_limits

from bayescal.comparison.families.caveats import family_caveats
from bayescal.comparison.families.members import (
    Progress,
    free_members,
    pinhole_members,
    stated_members,
)
from bayescal.comparison.families.models import (
    LINEAR,
    Axis,
    Wanted,
    linear_axes,
    noise_levels,
)
from bayescal.comparison.families.results import (
    FamilyComparison,
    FamilyRequest,
    JointModel,
)
from bayescal.comparison.families.robust import free_robust, stated_robust
from bayescal.comparison.families.verdict import judge_families, model_probabilities
from bayescal.comparison.key import FAMILIES, FREE, PINHOLE, STATED
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.notes import point_notes
from bayescal.polynomials import separable
from bayescal.prior.camera import check_inferred, pinhole_prior, position_prior

EQUAL = "families are equally probable beforehand; within one its positions, then its orders"
ONE_NOISE = (
    "errors of the world coordinates: as pixels by the slopes of the separable polynomials at the "
    "stated position, the same for every model"
)


def compare_joint(
    points: Correspondences,
    request: FamilyRequest,
    settings: Settings,
    progress: Progress | None = None,
    store: Store | None = None,
) -> FamilyComparison:
    """Compare families of models of both axes.

    Parameters
    ----------
    points : Correspondences
    request : FamilyRequest
    settings : Settings
    progress : callable, optional
        Called with the family and its position before its models are judged.
    store : Store, optional
        Where posteriors come from; by default they are drawn now.

    Returns
    -------
    FamilyComparison

    Raises
    ------
    InputError
        Where the points can't determine a model, or a family has no such noise.
    """
    check_request(request, settings)
    if any(FREE in request.positions_of(family) for family in request.families):
        check_inferred(points)
    kept = store or Store()
    families, orders = request.families, request.orders
    with threadpool_limits(1):
        axes = {f: linear_axes(points, f, settings, orders[-1]) for f in families if f in LINEAR}
        levels = noise_levels(points, settings, orders[-1])
        plans: list[tuple[str, Iterator[JointModel]]] = []
        for family in families:
            for position in request.positions_of(family):
                wanted, stated = _wanted(family, request), position == STATED
                if family == PINHOLE:
                    judged = pinhole_members(points, request, position, levels, settings, kept)
                elif settings.choice.robust:
                    judge = stated_robust if stated else free_robust
                    judged = judge(family, axes[family], wanted, points, settings, kept)
                elif stated:
                    judged = stated_members(family, axes[family], wanted, points)
                else:
                    judged = free_members(family, axes[family], wanted, points, settings, kept)
                plans.append((f"{family}, position {position}", judged))
        found: list[JointModel] = []
        for words, judged in plans:
            if progress is not None:
                progress(words, 0)
            found += judged
    chances = model_probabilities(found)
    # Probabilities too small for a double are zero, and still have an order.
    order = sorted(range(len(found)), key=lambda i: (-chances[i], -found[i].log_evidence))
    models = tuple(found[i] for i in order)
    sorted_chances = tuple(chances[i] for i in order)
    verdict = judge_families(models, sorted_chances, family_caveats(points, models, sorted_chances))
    priors = _prior_words(points, request, axes, settings)
    notes = point_notes(points)
    if _world_errors(points):
        notes.append(ONE_NOISE)
    if len(models) > 1:
        notes.append(EQUAL)
    return FamilyComparison(
        points,
        models,
        sorted_chances,
        request,
        settings,
        priors,
        levels.words,
        verdict,
        tuple(notes),
    )


def _world_errors(points: Correspondences) -> bool:
    sigma = points.world_sigma()
    return sigma is not None and bool(sigma.any())


def check_request(request: FamilyRequest, settings: Settings) -> None:
    """Refuse what no family, or not this one, can do.

    Raises
    ------
    InputError
    """
    for family in request.families:
        if family not in FAMILIES:
            raise InputError(f"family must be {', '.join(FAMILIES)}, not {family!r}")
    for position in request.positions or ():
        if position not in (STATED, FREE):
            raise InputError(f"position must be stated or free, not {position!r}")
    if request.radial not in ("even", "all"):
        raise InputError(f"radial must be even or all, not {request.radial!r}")
    if settings.prior == "flat":
        raise InputError("a flat prior has no evidence, which families are compared by; drop it")


def _wanted(family: str, request: FamilyRequest) -> Wanted:
    """Orders as named, and of r and c."""
    orders = request.orders
    if family != separable.NAME:
        return [((k,), k, k) for k in orders]
    pairs = request.pairs if request.pairs is not None else list(product(orders, orders))
    return [((k, m), k, m) for k, m in pairs]


def _prior_words(
    points: Correspondences,
    request: FamilyRequest,
    axes: dict[str, tuple[Axis, Axis]],
    settings: Settings,
) -> tuple[str, ...]:
    out = []
    for family, pair in axes.items():
        r, c = pair
        names = f"{r.rule.name}" if r.rule.name == c.rule.name else f"{r.rule.name}, {c.rule.name}"
        strong = "tau inferred per axis" if settings.tau is None else f"tau = {settings.tau:g}"
        out.append(f"{family}: {names}, on Legendre amplitudes, {strong}")
    if FREE in (request.positions or ()) and axes:
        out.append(f"free position: {position_prior(points)}; the basis keeps its domain")
    if PINHOLE in request.families:
        out += [f"pinhole: {line}" for line in str(pinhole_prior(points, settings.tau)).split("\n")]
    return tuple(out)
