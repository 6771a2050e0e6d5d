"""From points and settings to a comparison across families: their candidates, listed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from threadpoolctl import threadpool_limits

from bayescal.comparison.adequacy.outcome import AdequacyTest
from bayescal.comparison.families.candidates.free import free_pairs
from bayescal.comparison.families.candidates.pinholes import pinholes
from bayescal.comparison.families.candidates.stated import stated_pairs
from bayescal.comparison.families.caveats import family_findings
from bayescal.comparison.families.defence import defence_words, defend
from bayescal.comparison.families.further import Listing, beyond_compared
from bayescal.comparison.families.models import LINEAR, Wanted, linear_axes, noise_levels
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.residuals import residual_tests
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison, FamilyDefence, GroupedErrors
from bayescal.comparison.families.verdict import FamilyVerdict, judge_families
from bayescal.comparison.judging import Candidate, judge_all
from bayescal.comparison.key import FAMILIES, FREE, PINHOLE, STATED, Key
from bayescal.comparison.notes import sampled_note
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.groups import groups_of
from bayescal.points.notes import point_notes
from bayescal.polynomials.whole import Whole
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
    whole: Mapping[str, Whole] | None = None,
) -> FamilyComparison:
    """Compare families of models of both axes.

    Parameters
    ----------
    progress : callable, optional
        Called with each model's name and 0 before it is judged.
    store : Store, optional
        Where posteriors come from; by default they are drawn now.
    whole : mapping of str to Whole, optional
        All points as each axis of each family has them (`reduced_name`), where these are a sample.

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
        axes = {
            f: linear_axes(points, f, settings, highest, whole) for f in families if f in LINEAR
        }
        levels = noise_levels(points, settings, highest)

        def listing(family: str, position: str, orders: Sequence[tuple[int, ...]]) -> list[Any]:
            if family == PINHOLE:
                wanted = replace(request, radial_orders=tuple(k for (k,) in orders))
                return list(pinholes(points, wanted, position, levels.data, settings, kept))
            listed = stated_pairs if position == STATED else free_pairs
            pairs = [Wanted(o, o[0], o[-1]) for o in orders]
            return list(listed(family, axes[family], pairs, points, settings, kept))

        # All are fitted, and what can't be fitted is refused, before any is sampled.
        candidates: list[Candidate[JointModel]] = []
        for family in families:
            for position in request.positions_of(family):
                candidates += listing(family, position, request.orders_of(family))
        told = progress or (lambda *_: None)
        found = judge_all(candidates, kept, settings, lambda key: told(str(key), 0))
        told("what could be wrong", 0)
        # Probabilities too small for a double are zero, and still have an order.
        models = tuple(sorted(found, key=lambda m: (-(m.probability or 0.0), -m.log_evidence)))
        looked = _looked_at(points, models, candidates, listing, kept, settings)
    priors = _prior_words(points, request, axes, settings)
    notes = [*sampled_note(points), *point_notes(points)]
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
        looked.verdict,
        tuple(notes),
        looked.tests,
        looked.grouped,
        looked.defence,
        derived=kept.derived,
        whole=whole,
    )


@dataclass(frozen=True, eq=False)
class _Looked:
    """What is found about the models once they are judged."""

    verdict: FamilyVerdict
    tests: tuple[AdequacyTest, ...] = ()
    grouped: GroupedErrors | None = None
    defence: FamilyDefence | None = None


def _looked_at(
    points: Correspondences,
    models: Sequence[JointModel],
    candidates: Sequence[Candidate[JointModel]],
    listing: Listing,
    store: Store,
    settings: Settings,
) -> _Looked:
    """Form the verdict; under Gaussian noise the residuals are tested, and orders beyond tried."""
    if settings.choice.robust:
        return _Looked(judge_families(models, family_findings(points, models)))
    known: dict[Key, Any] = {candidate.key: candidate for candidate in candidates}
    best = known[models[0].key].linearised()
    exact = models[0].criteria.log_likelihood is None
    tests = () if exact else residual_tests(points, best)
    findings = [*family_findings(points, models, tests), *beyond_compared(models, listing)]
    verdict, grouped = judge_families(models, findings), None
    groups = None if points.drawn_from is not None else groups_of(points)
    spread = None if groups is None or exact else best.spread_over(groups.members)
    if groups is not None and spread is not None:
        sd = dict(zip(best.names, spread.tolist(), strict=True))
        grouped = GroupedErrors(groups.source, len(groups.names), sd)
    if not settings.defend or len(models) < 2:
        return _Looked(verdict, tests, grouped)
    defence = defend(points, models, known, store)
    argued = verdict.with_findings((), defence_words(defence))
    return _Looked(argued, tests, grouped, defence)


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
