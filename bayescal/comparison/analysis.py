"""From points and settings to a comparison of the orders of each axis."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.comparison.adequacy.block import adequacy
from bayescal.comparison.adequacy.outcome import AdequacyTest
from bayescal.comparison.choosing import prior_rule
from bayescal.comparison.criteria.goodness import NO_REFERENCE, reference_sigma
from bayescal.comparison.findings.case import Case, best_of
from bayescal.comparison.findings.kinds import findings
from bayescal.comparison.judging import judge_all
from bayescal.comparison.key import POLYNOMIAL, Key
from bayescal.comparison.notes import notes
from bayescal.comparison.orders.averaging import averaged_over, averaged_words
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.candidates import order_of
from bayescal.comparison.orders.result import OrderResult
from bayescal.comparison.orders.sufficiency import sufficiency
from bayescal.comparison.orders.verdict import AxisVerdict, verdict_on
from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.linear.replicates import pure_error
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.points.correspondences import Correspondences
from bayescal.points.geometry import odd_geometry
from bayescal.points.groups import Groups, groups_of
from bayescal.points.setup import AXES
from bayescal.polynomials import separable
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.polynomials.whole import Whole

Progress: TypeAlias = Callable[[str, int], None]


@dataclass(frozen=True, eq=False)
class _Around:
    """What is known around the numbers of one axis: `other` is the other axis's regressor."""

    other: Array | None = None
    camera: Array | None = None
    groups: Groups | None = None
    group_names: Sequence[str] | None = None
    geometry: tuple[str, ...] = ()
    again: Iterable[Correspondences] | None = None

    @property
    def depth(self) -> Array | None:
        """Z in the camera's frame, ``(n_points,)``, world units."""
        return None if self.camera is None else self.camera[:, 2]


def analyse_points(
    points: Correspondences,
    orders: dict[str, tuple[int, ...]],
    settings: Settings,
    progress: Progress | None,
    store: Store | None = None,
    whole: Mapping[str, Whole] | None = None,
    again: Iterable[Correspondences] | None = None,
) -> Comparison:
    """Compare the orders wanted of each axis of the separable family.

    `progress` is called with axis and order before each model is sampled; by default all are
    sampled now. With the `whole` of each axis these points are a sample of it, and a defence reads
    all of them `again`; without them there is one only where the store has it.
    """
    data = {name: separable.axis_data(points, name) for name in AXES}
    if whole is not None:
        data |= {name: data[name].sampled_from(reduced) for name, reduced in whole.items()}
    for name, wanted in orders.items():
        # Refuse before anything is sampled.
        data[name].check(wanted[-1])
        prior_rule(data[name], settings, points.setup.priors.get(name)).of_order(wanted[-1])
    kept, odd = store or Store(), tuple(odd_geometry(points))
    if whole is not None and again is None:
        settings = replace(settings, defend=settings.defend and _has_defence(kept, orders))
    # A number per group and point.
    groups = groups_of(points) if settings.defend and whole is None else None
    axes = {}
    # One thread: a sum split over cores rounds differently from machine to machine.
    with threadpool_limits(1):
        for name, wanted in orders.items():
            other = data[PIXEL_AXES[name].other].x
            axis = Axis.of(
                data[name],
                settings,
                family=separable.NAME,
                highest=wanted[-1],
                other=other,
                stated=points.setup.priors.get(name),
            )
            around = _Around(other, points.camera_frame(), groups, points.groups, odd, again)
            axes[name] = _compare(axis, wanted, around, settings, kept, progress)
    assumed = notes(points, axes.values())
    return Comparison(axes, separable.NAME, points, settings, assumed, derived=kept.derived)


def _has_defence(store: Store, axes: Iterable[str]) -> bool:
    """Whether a store holds the defence of every axis."""
    from bayescal.comparison.defence.defence import NAME
    from bayescal.comparison.defence.results import Defence

    return all(store.known(NAME.format(axis), Defence) is not None for axis in axes)


def analyse_arrays(data: AxisData, orders: Sequence[int], settings: Settings) -> Comparison:
    """Compare orders, ascending, of a generic problem with the single axis ``"y"``."""
    with threadpool_limits(1):
        axis = Axis.of(data, settings, family=POLYNOMIAL, highest=orders[-1])
        result = _compare(axis, orders, _Around(), settings, Store(), None)
    assumed = (f"y: its span, {data.size:.6g}, stands for the image size in the prior",)
    return Comparison({"y": result}, POLYNOMIAL, None, settings, assumed)


def _compare(
    axis: Axis,
    orders: Sequence[int],
    around: _Around,
    settings: Settings,
    store: Store,
    progress: Progress | None,
) -> AxisComparison:
    """Judge every order of an axis, and form the verdict."""
    axis.check_resolved()
    data, shape = axis.data, axis.shape
    reference = NO_REFERENCE
    if shape.conjugate:
        replicates = pure_error(data.x, around.other, data.t, data.sd)
        reference = reference_sigma(axis.noise, axis.fit(axis.highest), replicates)
    candidates = [order_of(axis, k, shape, reference) for k in orders]
    results = judge_all(candidates, store, settings, partial(_tell, progress))
    best = best_of(results)
    tests = _tests(axis, best, around, store, settings) if shape.conjugate else ()
    case = Case(axis, results, shape, reference, tests, around.geometry)
    verdict = _verdict(case, settings)
    averaged = averaged_over(axis, results, verdict.order)
    plain = AxisComparison(
        data,
        axis.noise,
        axis.source,
        axis.rule,
        reference,
        pure_error(data.x, None, data.t),
        results,
        verdict.with_findings((), averaged_words(averaged)),
        noise_model=shape,
        averaged=averaged,
    )
    if not settings.defend:
        return plain
    if progress is not None:
        progress(f"defence of {data.axis}", 0)
    return _defended(replace(plain, adequacy=tests), axis, around, store, settings)


def _verdict(case: Case, settings: Settings) -> AxisVerdict:
    """Say which order, what stands against it, and whether it is enough."""
    axis, results = case.axis, case.results
    enough = partial(
        sufficiency,
        axis.data,
        axis.noise,
        results,
        tolerance=settings.tolerance,
        triangle=axis.factors.r,
    )
    return verdict_on(results, findings(case), enough)


def _tell(progress: Progress | None, key: Key) -> None:
    if progress is not None and key.axis is not None:
        progress(key.axis, key.orders[0])


def _defended(
    plain: AxisComparison, axis: Axis, around: _Around, store: Store, settings: Settings
) -> AxisComparison:
    """Add the answers to a referee; a plain comparison does not pay for importing them."""
    from bayescal.comparison.defence.argument import argue
    from bayescal.comparison.defence.defence import defend
    from bayescal.comparison.defence.other_noise import about_noise
    from bayescal.comparison.defence.world_units import world_units

    rng = Key.of_axis(axis.data.axis, 0, GAUSSIAN.name).rng(settings.seed)
    results, verdict, shape = plain.orders, plain.verdict, plain.noise_model
    defence = defend(
        axis, shape, results, verdict, around.groups, store, settings, rng, around.again
    )
    criteria = {r.order: r.criteria for r in results}
    argued = about_noise(
        argue(verdict, defence, criteria, axis.data.size), plain.chosen, defence.noises
    )
    # Stated errors of world coordinates need no hint of what they are worth.
    camera = around.camera if axis.data.x_sd is None and shape.conjugate else None
    units = () if camera is None else world_units(axis.data, plain.chosen.fit, camera)
    return replace(plain, verdict=argued, defence=defence, world_units=units)


def _tests(
    axis: Axis, result: OrderResult, around: _Around, store: Store, settings: Settings
) -> tuple[AdequacyTest, ...]:
    """Test an order's residuals; a defence asks what its draws predict, too."""
    draws = None
    if settings.defend:
        drawn = result.posterior.chain.draws
        draws = drawn.reshape(-1, drawn.shape[2])
    find = partial(
        adequacy,
        axis.data,
        axis.fit(result.order),
        axis.noise,
        around.other,
        around.depth,
        around.group_names,
        draws,
        Key.of_axis(axis.data.axis, 0, GAUSSIAN.name).rng(settings.seed, 1),
    )
    name = f"{axis.data.axis} adequacy{', defended' if settings.defend else ''}"
    return store.once(name, tuple[AdequacyTest, ...], find)
