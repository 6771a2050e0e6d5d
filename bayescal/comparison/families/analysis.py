"""From points and settings to a comparison across families: their candidates, listed."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import TypeAlias

from threadpoolctl import threadpool_limits

from bayescal.comparison.axis import Axis
from bayescal.comparison.families.caveats import family_caveats
from bayescal.comparison.families.free import free_pairs
from bayescal.comparison.families.models import LINEAR, Wanted, linear_axes, noise_levels
from bayescal.comparison.families.pinholes import pinholes
from bayescal.comparison.families.results import FamilyComparison, FamilyRequest, JointModel
from bayescal.comparison.families.stated import stated_pairs
from bayescal.comparison.families.verdict import judge_families
from bayescal.comparison.judging import Candidate, judge_all
from bayescal.comparison.key import FAMILIES, FREE, PINHOLE, STATED, Key
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.notes import point_notes
from bayescal.polynomials import separable
from bayescal.prior.camera import check_inferred, pinhole_prior, position_prior

Progress: TypeAlias = Callable[[str, int], None]
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
    progress : callable, optional
        Called with the family and its position before its models are judged.
    store : Store, optional
        Where posteriors come from; by default they are drawn now.

    Raises
    ------
    InputError
        Where the points can't determine a model, or a family has no such noise.
    """
    check_request(request, settings)
    if any(FREE in request.positions_of(family) for family in request.families):
        check_inferred(points)
    families, highest, kept = request.families, request.orders[-1], store or Store()
    with threadpool_limits(1):
        axes = {f: linear_axes(points, f, settings, highest) for f in families if f in LINEAR}
        levels = noise_levels(points, settings, highest)
        # All are fitted, and what can't be fitted is refused, before any is sampled.
        candidates: list[Candidate[JointModel]] = []
        for family in families:
            for position in request.positions_of(family):
                if family == PINHOLE:
                    candidates += pinholes(points, request, position, levels.data, settings, kept)
                    continue
                listed = stated_pairs if position == STATED else free_pairs
                candidates += listed(
                    family, axes[family], _wanted(family, request), points, settings, kept
                )
        found = judge_all(candidates, kept, settings, _told(progress))
    # Probabilities too small for a double are zero, and still have an order.
    models = tuple(sorted(found, key=lambda m: (-(m.probability or 0.0), -m.log_evidence)))
    verdict = judge_families(models, family_caveats(points, models))
    priors = _prior_words(points, request, axes, settings)
    notes = point_notes(points)
    if _world_errors(points):
        notes.append(ONE_NOISE)
    if len(models) > 1:
        notes.append(EQUAL)
    return FamilyComparison(
        points,
        models,
        request,
        settings,
        priors,
        levels.words,
        verdict,
        tuple(notes),
        derived=kept.derived,
    )


def _told(progress: Progress | None) -> Callable[[Key], None]:
    """Make of a progress by family and position one by candidates."""
    said: set[str] = set()

    def tell(key: Key) -> None:
        words = f"{key.family}, position {key.position}"
        if progress is not None and words not in said:
            progress(words, 0)
        said.add(words)

    return tell


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


def _wanted(family: str, request: FamilyRequest) -> list[Wanted]:
    orders = request.orders
    if family != separable.NAME:
        return [Wanted((k,), k, k) for k in orders]
    pairs = request.pairs if request.pairs is not None else product(orders, orders)
    return [Wanted((k, m), k, m) for k, m in pairs]


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
