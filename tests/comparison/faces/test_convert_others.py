"""Families, bad points and lenses in the hands of other libraries, and ArviZ on a run's files.

Truth: the results themselves; our own leave-one-out of the same draws.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.criteria.psis import thinned
from bayescal.inference.arviz_bridge import psis_loo

with warnings.catch_warnings():
    warnings.simplefilter("ignore", FutureWarning)  # ArviZ 0.23 announces its successor
    import arviz as az

HEAVY = pytest.mark.filterwarnings("ignore:Estimated shape parameter of Pareto:UserWarning")


@pytest.fixture(scope="module")
def families():
    return bc.compare_families(
        bc.thesis(), ["separable", "pinhole"], [1], radial_orders=[0], tau=0.05, ess=100
    )


def test_families_iterate_index_and_convert(families):
    names = [str(model.key) for model in families]
    assert len(families) == len(names) == 2
    assert names[0] in families
    assert "fisheye 1" not in families
    frame = families.to_dataframe()
    assert list(frame.index) == names
    for model in families:
        row = frame.loc[str(model.key)]
        assert row.log_evidence == model.log_evidence
        assert row.probability == model.probability
        assert row.elpd == model.loo.elpd
    assert families.summary().equals(families.best.summary())
    assert families.covariance().equals(families.best.covariance())


def test_parameters_of_every_way_of_having_them(families):
    """Sampled, weighted and in closed form: means and sds are the result's own."""
    ways = set()
    for model in families:
        frame = model.summary()
        if model.posterior is not None:
            ways.add("sampled")
            p = model.posterior.parameters[0]
            assert (frame.loc[p.name, "mean"], frame.loc[p.name, "ess_bulk"]) == (
                p.mean,
                p.ess_bulk,
            )
            drawn = model.posterior.chain.draws.reshape(-1, len(frame))
            np.testing.assert_allclose(model.covariance(), np.cov(drawn.T))
        elif model.exact:
            ways.add("closed form")
            means, sds = (value[0] for value in model.exact[0].summary)
            assert tuple(frame.loc["alpha_0", ["mean", "sd"]]) == pytest.approx((means, sds))
            covariance = model.covariance()
            assert covariance.loc["alpha_0", "alpha_0"] == pytest.approx(sds**2)
            assert covariance.loc["alpha_0", "beta_0"] == 0
            with pytest.raises(bc.InputError, match="has no draws"):
                model.to_arviz()
    assert ways == {"sampled", "closed form"}


@HEAVY
def test_arviz_leaves_points_out_as_we_do_of_both_axes(families, tmp_path: Path):
    """In memory and from a run's file, of the same draws to rounding."""
    bc.save_run(families, tmp_path / "run")
    model = next(m for m in families if m.posterior is not None and m.camera is not None)
    kept = tmp_path / "run" / "draws" / f"{model.key.file()}.nc"
    for held in (model.to_arviz(), az.from_netcdf(kept)):
        theirs = az.loo(held, pointwise=True, reff=1.0)
        terms = np.asarray(theirs.elpd_i if hasattr(theirs, "elpd_i") else theirs.loo_i)
        density = model.posterior.model.log_likelihood(model.posterior.completed)
        ours = psis_loo(density.T)
        # ArviZ 0.23 takes another length of tail: fitted shapes differ by some 0.02.
        allowed = 1e-9 if hasattr(theirs, "elpd_i") else 0.05
        np.testing.assert_allclose(terms, ours.pointwise, rtol=0, atol=allowed)
        good = ours.pareto_k < 0.5
        # Ours is of every so many of the draws: its error is theirs times the root of that share.
        every = len(density) / len(thinned(density, density.shape[1]))
        error = ours.mcse[good] * np.sqrt(1 + every)
        gap = np.abs(terms[good] - model.loo.pointwise[good])
        assert (gap < 5 * error + (allowed > 0.01) * allowed).all()


@HEAVY
def test_a_run_of_orders_is_read_by_arviz(tmp_path: Path):
    found = bc.compare(bc.thesis(), [2], axis="c", ess=400, hint=False)
    bc.save_run(found, tmp_path / "run")
    kept = az.from_netcdf(tmp_path / "run" / "draws" / "c-order-2.nc")
    order = found["c"][2]
    theirs, own = az.loo(kept, reff=1.0), az.loo(order.to_arviz(), reff=1.0)
    assert float(getattr(theirs, "elpd", getattr(theirs, "elpd_loo", 0))) == pytest.approx(
        float(getattr(own, "elpd", getattr(own, "elpd_loo", 0))), abs=1e-9
    )
    assert kept.observed_data["pixel"].to_numpy().tolist() == order.data.t.tolist()


def test_lenses_convert(lens_comparison):
    frame = lens_comparison.to_dataframe()
    assert list(frame.index) == [judged.name for judged in lens_comparison]
    assert len(frame) == len(lens_comparison)
    assert frame.index[0] in lens_comparison
    assert frame.rms_px.iloc[0] == lens_comparison.best.rms
    names = list(lens_comparison.posterior.names)
    assert list(lens_comparison.summary().index) == names
    assert lens_comparison.covariance().shape == (len(names), len(names))
    assert set(lens_comparison.to_arviz().posterior.data_vars) == set(names)


def test_a_lens_weighed_by_linear_algebra_has_the_covariance_of_its_draws(lens_comparison):
    """Truth: the draws of the best one, to their error and that of a normal approximation."""
    best, drawn = lens_comparison.best, lens_comparison.covariance()
    names = [name for name in best.evidence.problem.model.names if name in drawn.index]
    own = best.covariance().loc[names, names]
    sd = np.sqrt(np.diag(drawn.loc[names, names]))
    np.testing.assert_allclose(np.sqrt(np.diag(own)), sd, rtol=0.2)
    gap = (own - drawn.loc[names, names]) / np.outer(sd, sd)
    assert np.abs(gap.to_numpy()).max() < 0.3
    summary = best.summary()
    np.testing.assert_allclose(summary.loc[names, "sd"], np.sqrt(np.diag(own)))
    with pytest.raises(bc.InputError, match="has no draws"):
        best.to_arviz()
