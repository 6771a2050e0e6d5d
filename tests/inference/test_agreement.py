"""Negative controls: the check against the closed form must catch wrong samplers."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np
import pytest

from bayescal.inference.checked_posterior import CheckedPosterior, sample_posterior
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.prior.amplitudes import CoefficientPrior
from tests.helpers.problems import STATED_R, THESIS_MODELS, make_model, thesis_axis
from tests.helpers.wrong_proposals import Misstated

ESS = 4000


def sampled(model: LinearModel, width: float) -> CheckedPosterior:
    exact = exact_posterior(model)
    proposal = Misstated(exact, width)
    return sample_posterior(model, np.random.default_rng(9), ESS, exact, proposal)


@pytest.mark.parametrize("width", [0.9, 1.1])
@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_draws_a_tenth_off_in_width_are_caught(axis, order, width):
    posterior = sampled(make_model(thesis_axis(axis), order), width)
    assert not posterior.agrees_with_exact


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_the_same_construction_with_the_right_width_passes(axis, order):
    """The control's own control: only the width makes the difference."""
    assert sampled(make_model(thesis_axis(axis), order), 1.0).agrees_with_exact


@dataclass(frozen=True, eq=False)
class WithoutTau(CoefficientPrior):
    """The field prior with its dependence on tau dropped from the density."""

    tau_in_use: float = field(default=0.05, kw_only=True)

    def deviations(self, log_tau):
        return super().deviations(np.full_like(log_tau, np.log(self.tau_in_use)))


def with_prior(model: LinearModel, prior: CoefficientPrior) -> LinearModel:
    return LinearModel(model.factors, model.order, model.noise, prior, model.symbol)


def sampled_against(target: LinearModel, truth: LinearModel) -> CheckedPosterior:
    """Sample one model, and check it against the closed form of another."""
    return sample_posterior(target, np.random.default_rng(9), ESS, exact_posterior(truth))


@pytest.mark.parametrize("order", [2, 5])
@pytest.mark.parametrize("axis", ["r", "c"])
def test_a_target_without_taus_prior_term_is_caught(axis, order):
    model = make_model(thesis_axis(axis), order)
    values = {f.name: getattr(model.prior, f.name) for f in fields(model.prior)}
    posterior = sampled_against(with_prior(model, WithoutTau(**values)), model)
    assert not posterior.agrees_with_exact


@pytest.mark.parametrize("dropped", [0, 2, 4])
def test_a_target_without_one_coefficients_prior_term_is_caught(dropped):
    """A deviation of 1e9 px leaves nothing of that term but a constant."""
    model = make_model(thesis_axis("r"), 4, prior="stated", stated=STATED_R)
    sd = model.prior.sd.copy()
    sd[dropped] = 1e9
    posterior = sampled_against(with_prior(model, replace(model.prior, sd=sd)), model)
    assert not posterior.agrees_with_exact


def test_a_target_that_forgets_one_point_is_caught():
    """The likelihood of 56 points against the closed form of 57."""
    data = thesis_axis("c")
    model = make_model(data, 1)
    fewer = replace(data, x=data.x[1:], t=data.t[1:], labels=data.labels[1:])
    target = LinearModel(
        replace(make_model(fewer, 1).factors, monomials=model.factors.monomials),
        1,
        model.noise,
        model.prior,
    )
    assert not sampled_against(target, model).agrees_with_exact


def test_the_right_target_passes_the_same_check():
    """The control's own control."""
    for model in (
        make_model(thesis_axis("r"), 4),
        make_model(thesis_axis("r"), 4, prior="stated", stated=STATED_R),
    ):
        assert sampled_against(model, model).agrees_with_exact
