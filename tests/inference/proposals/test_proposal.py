"""Proposals: their draws follow the density they claim, which integrates to one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import stats

from bayescal.inference.proposals.coordinates import WhitenedProposal, Whitening
from bayescal.inference.proposals.proposal import Hats, LinearProposal, Proposal
from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.linear.model import LinearModel
from tests.helpers.brute_force import panels
from tests.helpers.problems import STATED_R, make_axis, make_model, thesis_axis
from tests.helpers.wrong_proposals import Misstated

# tau from a thousandth of the image on: the identities below take normals of the amplitudes, whose
# ratio to a density that smaller tau make spiky has no variance.
WIDE = 0.1


@dataclass
class Case:
    """A model whose proposal is put to the test."""

    axis: str
    order: int
    options: dict

    def model(self) -> LinearModel:
        data = thesis_axis(self.axis)
        return make_model(data, self.order, pixel=WIDE * data.size, **self.options)


CASES = {
    "line": Case("r", 1, {}),
    "tau inferred": Case("c", 3, {}),
    "highest order": Case("r", 5, {}),
    "tau fixed": Case("c", 4, {"tau": 0.05}),
    "sigma known": Case("c", 3, {"sigma": 3.0}),
    "both known": Case("c", 3, {"sigma": 3.0, "tau": 0.05}),
    "flat": Case("c", 2, {"prior": "flat"}),
    "stated": Case("r", 4, {"prior": "stated", "stated": STATED_R}),
}


def bulk_densities(exact: ExactPosterior, rng: np.random.Generator) -> list:
    """Seven normalised log densities well inside the posterior's bulk.

    Amplitudes: a normal half as wide as the posterior, near its mean; ln sigma and
    ln tau: uniform between the posterior's quartiles.
    """
    p = exact.model.size
    covariance = exact.covariance / 4
    root = np.linalg.cholesky(covariance)
    boxes = []
    for values, mass in exact.hyperparameters:
        quartiles = np.interp([0.25, 0.75], np.cumsum(mass), np.log(values))
        boxes.append(stats.uniform(quartiles[0], np.ptp(quartiles)))

    def log_density(shift):
        normal = stats.multivariate_normal(exact.mean + root @ shift, covariance)

        def f(theta):
            rest = [box.logpdf(v) for box, v in zip(boxes, theta[:, p:].T, strict=True)]
            return normal.logpdf(theta[:, :p]) + sum(rest)

        return f

    return [log_density(shift) for shift in [np.zeros(p), *rng.normal(0, 0.5, (6, p))]]


def scores(proposal: Proposal, exact: ExactPosterior, draws: np.ndarray) -> np.ndarray:
    """Standard scores of mean(f / q) - 1 over draws from q, for each density f.

    For any density f that q covers the mean is 1 exactly if the draws follow q and q
    is normalised where f lives.
    """
    log_q = proposal.log_density(draws)
    out = []
    for f in bulk_densities(exact, np.random.default_rng(1)):
        ratio = np.exp(f(draws) - log_q)
        out.append((ratio.mean() - 1) / (ratio.std() / np.sqrt(len(ratio))))
    return np.array(out)


@pytest.mark.parametrize("name", CASES)
def test_draws_follow_their_normalised_density(name):
    """The contract: seven identities, each within 4.5 standard errors."""
    exact = exact_posterior(CASES[name].model())
    proposal = LinearProposal(exact)
    draws = proposal.draw(np.random.default_rng(7), 40_000)
    assert draws.shape == (40_000, exact.model.dimension)
    assert np.isfinite(proposal.log_density(draws)).all()
    assert np.abs(scores(proposal, exact, draws)).max() < 4.5


@pytest.mark.parametrize("name", CASES)
def test_the_density_is_that_of_the_hats_and_normals(name):
    """The same by what is drawn: node by node, from the normals of `draw`, in the bulk."""
    exact = exact_posterior(CASES[name].model())
    proposal = LinearProposal(exact)
    theta = proposal.draw(np.random.default_rng(8), 500)
    p, model = exact.model.size, exact.model
    sigma, tau = proposal._sigma, proposal._tau
    log_sigma = theta[:, p] if model.infers_sigma else np.zeros(len(theta))
    variance = np.exp(2 * log_sigma) if model.infers_sigma else np.full(500, exact.sigma[0] ** 2)
    log_tau = theta[:, -1] if model.infers_tau else np.zeros(len(theta))
    hats = [
        np.array(
            [
                np.interp(x, h.nodes, row) if len(h.nodes) > 1 else np.ones(len(x))
                for row in np.eye(len(h.nodes))
            ]
        )
        for x, h in ((log_sigma, sigma), (log_tau, tau))
    ]
    weights = 0.99 * proposal._density @ hats[0] + proposal._uniform
    total = np.zeros(len(theta))
    for i, hat in enumerate(hats[1]):
        node = np.full(500, i)
        mean, spread = proposal._normal(node, variance)
        a = (theta[:, :p] - model.prior.mean) @ exact.conditional.from_b[i].T
        normal = stats.norm.logpdf(a, mean, np.sqrt(spread)).sum(axis=1)
        total += hat * weights[i] * np.exp(normal + exact.conditional.log_det[i])
    bulk = total > 1e-12 * total.max()
    found = np.exp(proposal.log_density(theta))
    np.testing.assert_allclose(found[bulk], total[bulk], rtol=1e-6)
    assert bulk.mean() > 0.9


@pytest.mark.parametrize("name", CASES)
def test_draws_wider_than_their_density_fail_the_contract(name):
    """Negative control: the same identities with draws 10 % wider."""
    exact = exact_posterior(CASES[name].model())
    draws = Misstated(exact, 1.1).draw(np.random.default_rng(7), 40_000)
    assert np.abs(scores(LinearProposal(exact), exact, draws)).max() > 6


def test_the_whitened_proposal_is_the_same_density_up_to_its_jacobian():
    """Identity: per unit of theta, at theta = centre + factor u."""
    exact = exact_posterior(CASES["tau inferred"].model())
    factor = np.eye(exact.model.dimension)
    factor[: exact.model.size, : exact.model.size] = exact.root
    linear, whitening = LinearProposal(exact), Whitening(np.full(len(factor), 2.0), factor)
    whitened = WhitenedProposal(linear, whitening)
    u = whitened.draw(np.random.default_rng(3), 1000)
    theta = linear.draw(np.random.default_rng(3), 1000)
    np.testing.assert_allclose(whitening.theta(u), theta, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(whitened.log_density(u), linear.log_density(theta), atol=1e-8)


def test_density_of_a_line_with_unknown_sigma_integrates_to_one():
    """Quadrature in three dimensions, exact for what is linear between nodes.

    Between nodes of ln sigma the density is linear times a normal of b: two Gauss
    points there, a trapezoid of 21 points over +-8 deviations of each amplitude.
    """
    exact = exact_posterior(make_model(thesis_axis("r"), 1))
    proposal = LinearProposal(exact)
    total, _ = _integrate_over_amplitudes(proposal, exact, exact.sigma_rule.nodes, None)
    # Outside the followed panels ln sigma has only its share of the uniform part.
    lower, upper = np.log(exact.model.noise.bounds)
    covered = np.ptp(exact.sigma_rule.nodes) / (upper - lower)
    assert total == pytest.approx(1 - 0.01 * (1 - covered), abs=1e-6)


def test_ln_sigma_of_a_line_follows_the_marginal_of_its_own_density():
    """Kolmogorov-Smirnov against the density integrated over both amplitudes."""
    exact = exact_posterior(make_model(thesis_axis("r"), 1))
    proposal = LinearProposal(exact)
    _, cumulative = _integrate_over_amplitudes(proposal, exact, exact.sigma_rule.nodes, None)
    drawn = proposal.draw(np.random.default_rng(5), 20_000)[:, 2]
    nodes = exact.sigma_rule.nodes
    inside = drawn[(drawn >= nodes[0]) & (drawn <= nodes[-1])]
    result = stats.kstest(inside, lambda v: np.interp(v, nodes, cumulative / cumulative[-1]))
    assert result.pvalue > 1e-3


def test_ln_tau_of_a_parabola_follows_the_marginal_of_its_own_density():
    """The same in four dimensions, ln tau between its nodes; and the integral is one."""
    rng = np.random.default_rng(1)
    x = np.linspace(-1, 1, 30)
    # Noise far below the smallest tau: the amplitudes hardly depend on tau.
    data = make_axis(x, 500 + 300 * x + 20 * (1.5 * x**2 - 0.5) + rng.normal(0, 0.1, 30))
    exact = exact_posterior(make_model(data, 2, sigma=0.1, pixel=WIDE * data.size))
    proposal = LinearProposal(exact)
    nodes = exact.tau_rule.nodes
    total, cumulative = _integrate_over_amplitudes(proposal, exact, None, nodes)
    assert total == pytest.approx(1, abs=1e-6)
    drawn = proposal.draw(np.random.default_rng(5), 20_000)[:, 3]
    result = stats.kstest(drawn, lambda v: np.interp(v, nodes, cumulative))
    assert result.pvalue > 1e-3


def _integrate_over_amplitudes(proposal, exact, sigma_nodes, tau_nodes):
    """Integral of the density, and its cumulative at the nodes of the last parameter."""
    p = exact.model.size
    nodes = sigma_nodes if sigma_nodes is not None else tau_nodes
    gauss, weight = np.polynomial.legendre.leggauss(2)
    half = np.diff(nodes) / 2
    places = (nodes[:-1] + half)[:, None] + half[:, None] * gauss
    z = np.linspace(-8, 8, 21)
    grid = np.stack(np.meshgrid(*[z] * p, indexing="ij"), axis=-1).reshape(-1, p)
    root = np.linalg.cholesky(exact.covariance)
    typical = float(np.mean([exact.summary[0][p]])) if sigma_nodes is not None else 1.0
    steps = []
    for row in places:
        inner = 0.0
        for place, w in zip(row, weight, strict=True):
            # Amplitudes are as wide as sigma says, to within the weak prior.
            scale = np.exp(place) / typical if sigma_nodes is not None else 1.0
            b = exact.mean + scale * grid @ root.T
            theta = np.column_stack([b, np.full(len(b), place)])
            volume = (z[1] - z[0]) ** p * np.prod(np.diag(root)) * scale**p
            inner += w * volume * np.exp(proposal.log_density(theta)).sum()
        steps.append(inner)
    cumulative = np.append(0.0, np.cumsum(np.array(steps) * half))
    return cumulative[-1], cumulative


@pytest.mark.parametrize("nodes", [[0.0, 1.0], [0.0, 0.1, 0.5, 2.0], list(np.cumsum(range(1, 9)))])
def test_hats_draw_their_own_triangle(nodes):
    """Closed form: between two nodes the density of a hat is linear (K-S per hat)."""
    hats = Hats(np.array(nodes, dtype=float))
    rng = np.random.default_rng(2)
    for j, mass in enumerate(hats.mass):
        drawn = hats.draw(rng, np.full(4000, j))
        places, weights = panels(nodes[0], nodes[-1], 0.01)
        height = np.interp(places, nodes, np.eye(len(nodes))[j])
        assert mass == pytest.approx(weights @ height, rel=1e-3)
        cumulative = np.cumsum(weights * height) / (weights @ height)
        result = stats.kstest(drawn, lambda v, p=places, c=cumulative: np.interp(v, p, c))
        assert result.pvalue > 1e-4
