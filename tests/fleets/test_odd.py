"""Which cameras are odd: the spread's estimate, false alarms, and cameras that are known to be."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bayescal.fleets.odd import (
    FEWEST,
    LEVEL,
    biweight_scale,
    common_model,
    oddities,
    score_limit,
    spreads,
)
from bayescal.fleets.record import Choice, Estimate, Record

QUANTITIES = 8


def choice(values, sigma=1.0, model="1", probability=None, sd=0.1):
    parameters = {f"alpha_{j}": Estimate(float(v), sd) for j, v in enumerate(values)}
    chances = {"1": 0.9, "2": 0.1} if probability is None else probability
    plausible = tuple(chances)
    spread = Estimate(sigma, None)
    return Choice("r", model, "undecided", plausible, chances, spread, {"1": parameters})


def fleet(rng, n, wide=1.0):
    numbers = wide * rng.standard_normal((n, QUANTITIES))
    sigmas = np.exp(0.1 * rng.standard_normal(n))
    pairs = zip(numbers, sigmas, strict=True)
    return {f"{i}": Record(57, 0, True, (choice(v, s),)) for i, (v, s) in enumerate(pairs)}


def test_scale_is_the_standard_deviation_of_normal_numbers():
    """Truth: 3; the biweight's efficiency is over 0.8, so its error is below 3 / sqrt(1.6 n)."""
    x = 3 * np.random.default_rng(1).standard_normal(100_000)
    found = biweight_scale(x)
    assert found == pytest.approx(3, abs=0.01 * 3 + 4 * 3 / math.sqrt(1.6e5))


def test_scale_by_its_definition():
    """Equation 9 of Beers, Flynn & Gebhardt, term by term."""
    x = np.array([1.0, 2, 2.5, 3, 3.5, 4, 5, 6, 7, 90])
    middle = np.median(x)
    mad = np.median(abs(x - middle))
    above = below = 0.0
    for value in x:
        u = (value - middle) / (9 * mad)
        if abs(u) < 1:
            above += (value - middle) ** 2 * (1 - u**2) ** 4
            below += (1 - u**2) * (1 - 5 * u**2)
    assert biweight_scale(x) == pytest.approx(math.sqrt(len(x) * above) / abs(below), rel=1e-12)


def test_odd_cameras_do_not_widen_the_scale():
    x = np.random.default_rng(2).standard_normal(200)
    with_odd = np.append(x, [1e3] * 10)
    assert biweight_scale(with_odd) == pytest.approx(biweight_scale(x), rel=0.15)


def test_no_spread_where_cameras_agree_or_are_few():
    assert biweight_scale(np.ones(20)) is None
    assert biweight_scale(np.arange(FEWEST - 1.0)) is None
    few = fleet(np.random.default_rng(3), FEWEST - 1)
    assert score_limit(spreads(few)) == math.inf
    assert oddities(few, spreads(few)) == ()


@pytest.mark.parametrize("n", [FEWEST, 30])
def test_false_alarms_in_fleets_of_equal_cameras(n):
    """Truth: at most 5 % of fleets, by the binomial error of 400 of them."""
    rng, sets = np.random.default_rng(n), 400
    alarms = 0
    for _ in range(sets):
        records = fleet(rng, n)
        alarms += bool(oddities(records, spreads(records)))
    assert alarms / sets <= LEVEL + 3 * math.sqrt(LEVEL * (1 - LEVEL) / sets)


def test_cameras_of_few_views_are_not_odd_for_it():
    """Truth: 0.1 px everywhere; 27 cameras of 1314 degrees of freedom, 3 of 93."""
    rng, sets, alarms = np.random.default_rng(6), 300, 0
    for _ in range(sets):
        records = {}
        for i, dof in enumerate([1314] * 27 + [93] * 3):
            sigma = 0.1 * math.sqrt(rng.chisquare(dof) / dof)
            chances = {"a": 1.0}
            estimate = Estimate(sigma, sigma / math.sqrt(2 * dof))
            one = Choice("lens", "a", "decided", ("a",), chances, estimate, {"a": {}})
            records[f"{i}"] = Record(dof, 0, True, (one,))
        alarms += bool(oddities(records, spreads(records)))
    assert alarms / sets <= LEVEL + 3 * math.sqrt(LEVEL * (1 - LEVEL) / sets)


def test_a_lens_is_kept_with_sds_and_an_unbiased_sigma(lens_comparison):
    """Truth: the posterior by emcee, within 5 Monte Carlo errors and the least-squares sigma."""
    (kept,) = Record.of_lenses(lens_comparison).choices
    best, views = lens_comparison.best, lens_comparison.views
    dof = 2 * views.n_points - 6 * len(views.names) - best.model.dimension
    assert kept.sigma.value == pytest.approx(math.sqrt(best.fit.sum_of_squares / dof))
    for parameter in lens_comparison.posterior.parameters:
        if parameter.name in kept.parameters[best.name]:
            estimate = kept.parameters[best.name][parameter.name]
            assert estimate.sd == pytest.approx(parameter.sd, rel=0.15)
            assert abs(estimate.value - parameter.mean) < 0.2 * parameter.sd


def test_a_camera_that_is_off_is_found():
    records = fleet(np.random.default_rng(4), 40)
    records["off"] = Record(57, 0, True, (choice([0] * 3 + [12.0] + [0] * 4),))
    records["noisy"] = Record(57, 0, True, (choice([0] * 8, sigma=5.0),))
    found = oddities(records, spreads(records))
    assert {(o.camera, o.name) for o in found} == {("off", "alpha_3"), ("noisy", "sigma")}
    assert "alpha_3 12.00 px, the fleet 0." in next(o.text for o in found if o.camera == "off")


def test_a_camera_that_is_merely_uncertain_is_not():
    """Negative control of the one above: the same distance with a standard deviation as large."""
    records = fleet(np.random.default_rng(4), 40)
    unsure = choice([0] * 3 + [12.0] + [0] * 4, sd=12.0)
    records["unsure"] = Record(57, 0, True, (unsure,))
    assert oddities(records, spreads(records)) == ()


def test_the_common_model_excluded():
    records = fleet(np.random.default_rng(5), 20)
    other = choice([0] * 8, model="2", probability={"1": 1e-6, "2": 1 - 1e-6})
    leaning = choice([0] * 8, model="2", probability={"1": 0.01, "2": 0.99})
    records["other"], records["leaning"] = (Record(57, 0, True, (c,)) for c in (other, leaning))
    assert common_model([c for r in records.values() for c in r.choices]) == "1"
    (found,) = oddities(records, spreads(records))
    assert found.camera == "other"
    assert found.text == "r: order 2; order 1, the fleet's, has <0.1%"
