"""Results in the hands of other libraries: frames of pandas, ArviZ's own leave-one-out.

Truth: the results themselves; exact leave-one-out; the closed form's covariance.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.faces.convert import pointwise
from bayescal.comparison.results import Comparison
from bayescal.inference.arviz_bridge import psis_loo

with warnings.catch_warnings():
    warnings.simplefilter("ignore", FutureWarning)  # ArviZ 0.23 announces its successor
    import arviz as az


# Of the thesis's r some weights have heavy tails, and ArviZ says so, as our tables do.
HEAVY = pytest.mark.filterwarnings(
    "ignore:Estimated shape parameter of Pareto:UserWarning",
    # ArviZ 0.23 sorts its table in a way that pandas 3.1 announces the end of.
    "ignore:The inplace keyword in DataFrame",
)


@pytest.fixture(scope="module")
def result(thesis_defended: Comparison) -> Comparison:
    return thesis_defended


@pytest.fixture(scope="module")
def robust() -> Comparison:
    return bc.compare(bc.thesis(), [1], axis="c", noise="student-t", ess=400, hint=False)


def test_results_iterate_index_and_have_a_length(result: Comparison) -> None:
    assert [axis.data.axis for axis in result] == ["r", "c"]
    assert [order.order for order in result["r"]] == [1, 2, 3, 4, 5]
    assert (len(result), len(result["r"])) == (2, 5)
    assert result["r"][4] is result.axes["r"].orders[3]
    assert "r" in result
    assert "x" not in result
    assert 4 in result["r"]
    assert 6 not in result["r"]
    with pytest.raises(KeyError, match="axis 'x' was not looked at; axes: r, c"):
        result["x"]
    with pytest.raises(KeyError, match="order 6 was not compared"):
        result["r"][6]


def test_frames_hold_the_same_numbers(result: Comparison) -> None:
    frame = result.to_dataframe()
    assert len(frame) == 10
    for axis in result:
        for order in axis:
            row = frame.loc[(axis.data.axis, order.order)]
            assert row.rss_px2 == order.rss_px2
            assert row.probability == order.probability
            assert row.bic == order.criteria.bic
            assert order.loo is not None
            assert row.elpd == order.loo.elpd
    own = result["r"].to_dataframe()
    assert own.equals(frame.loc[["r"]])
    summary = result.summary()
    assert summary.loc[("r", "alpha_1"), "mean"] == result["r"].chosen.posterior["alpha_1"].mean
    assert list(result["r"][2].summary().index) == list(result["r"][2].posterior.names)


def test_covariance_is_that_of_the_closed_form(result: Comparison) -> None:
    """Variances within 5 Monte Carlo errors; correlations of coefficients within 0.05."""
    found = result["r"][3]
    covariance = found.covariance()
    exact = found.exact
    assert exact is not None
    to_monomials = exact.model.factors.monomials.lead(3)
    expected = to_monomials @ exact.covariance @ to_monomials.T
    names = ["alpha_0", "alpha_1", "alpha_2", "alpha_3"]
    drawn = covariance.loc[names, names].to_numpy()
    sds = np.sqrt(np.diag(expected))
    ess = min(p.ess_bulk for p in found.posterior.parameters)
    assert (np.abs(np.diag(drawn) / sds**2 - 1) < 5 * np.sqrt(2 / ess) * 1.5).all()
    np.testing.assert_allclose(drawn / np.outer(sds, sds), expected / np.outer(sds, sds), atol=0.1)
    np.testing.assert_array_equal(covariance, covariance.T)


def test_axes_are_independent(result: Comparison) -> None:
    """Together they are block by block what each axis says."""
    together = result.covariance()
    for axis in result:
        own = axis.covariance()
        assert own.equals(axis.chosen.covariance())
        np.testing.assert_array_equal(together.loc[axis.data.axis, axis.data.axis], own)
    assert (together.loc["r", "c"] == 0).all(axis=None)
    assert set(result.to_arviz()) == {"r", "c"}


@HEAVY
def test_arviz_finds_our_leave_one_out(result: Comparison) -> None:
    """Of the same draws to rounding; the exact one within 5 Monte Carlo errors."""
    for found in result["r"]:
        held = found.to_arviz()
        theirs = az.loo(held, pointwise=True, reff=1.0)
        values = pointwise(found)
        ours = psis_loo(values.reshape(-1, values.shape[2]).T)
        # ArviZ 0.23 takes another length of tail: fitted shapes differ by some 0.02.
        allowed = 1e-9 if hasattr(theirs, "elpd_i") else 0.02
        np.testing.assert_allclose(_terms(theirs), ours.pointwise, rtol=0, atol=allowed)
        assert found.loo is not None
        # Of light tails point by point; heavier ones have no Monte Carlo error to judge by.
        light = ours.pareto_k < 0.5
        error = np.sqrt((ours.influence[light] ** 2).sum(axis=1))
        assert light.sum() > 30
        gap = np.abs(_terms(theirs) - found.loo.pointwise)[light]
        assert (gap < 5 * error + 0.005).all()


@HEAVY
def test_arviz_ranks_as_we_do(result: Comparison) -> None:
    """By our PSIS of the same draws; the winner on r is that of exact leave-one-out."""
    for axis in result:
        table = az.compare({str(o.order): o.to_arviz() for o in axis}, method="stacking")
        theirs = [int(name) for name in table.index]
        elpds = {}
        for found in axis:
            values = pointwise(found)
            elpds[found.order] = psis_loo(values.reshape(-1, values.shape[2]).T).pointwise.sum()
        ours = sorted(elpds, key=lambda k: -elpds[k])
        for a, b in zip(theirs, ours, strict=True):
            # Their weights' tails count the draws' dependence: by so much elpd may differ.
            assert a == b or abs(elpds[a] - elpds[b]) < 0.02
        exact = max(axis, key=lambda o: -np.inf if o.loo is None else o.loo.elpd)
        assert axis.data.axis == "c" or theirs[0] == exact.order


def test_the_data_and_the_draws_are_in_it(result: Comparison) -> None:
    found = result["c"][2]
    held = found.to_arviz()
    posterior, likelihood = held["posterior"], held["log_likelihood"]
    np.testing.assert_array_equal(posterior["beta_1"].values, found.posterior.chain.draws[:, :, 1])
    np.testing.assert_array_equal(held["observed_data"]["pixel"].values, result["c"].data.t)
    assert likelihood["pixel"].dims == ("chain", "draw", "point")


def test_log_likelihood_is_a_plain_sum(result: Comparison, robust: Comparison) -> None:
    """Of the reported parameters, by scipy, for the Gaussian and for Student's t."""
    from scipy import stats

    for found, shape in ((result["r"][2], stats.norm), (robust["c"][1], stats.t)):
        parameters = enumerate(found.posterior.names)
        draws = {name: found.posterior.chain.draws[:, :, [j]] for j, name in parameters}
        powers = [found.data.x**k for k in range(found.order + 1)]
        mean = sum(draws[f"{found.data.symbol}_{k}"] * x for k, x in enumerate(powers))
        own = (draws["nu"],) if "nu" in draws else ()
        expected = shape.logpdf(found.data.t, *own, loc=mean, scale=draws["sigma"])
        np.testing.assert_allclose(pointwise(found), expected, rtol=0, atol=1e-8)


def test_robust_results_go_to_arviz_too(robust: Comparison) -> None:
    found = robust["c"][1]
    assert np.isfinite(_elpd(az.loo(found.to_arviz())))
    assert found.to_arviz() is not None
    assert robust.to_dataframe().aic.isna().all()


def _terms(found: Any) -> np.ndarray:
    terms = found.elpd_i if hasattr(found, "elpd_i") else found.loo_i
    return np.asarray(terms)


def _elpd(found: Any) -> float:
    return float(found.elpd if hasattr(found, "elpd") else found.elpd_loo)
