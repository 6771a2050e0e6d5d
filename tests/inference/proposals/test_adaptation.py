"""The proposal finds the density from a bad beginning."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.inference.optimum import Mode
from bayescal.inference.proposals.adaptation import adapt
from bayescal.inference.proposals.tempering import effective_fraction
from tests.helpers.known_densities import LOG_Z, Banana, HeavyTailed, Normal, Skewed


def fraction_and_distance(model, mode, seed):
    rng = np.random.default_rng(seed)
    adapted = adapt(model.log_prob, (mode,), rng)
    theta = adapted.proposal.draw(rng, 20000)
    log_w = model.log_prob(theta) - adapted.proposal.log_density(theta)
    fraction = effective_fraction(log_w)
    log_z = float(np.logaddexp.reduce(log_w)) - np.log(len(log_w))
    return fraction, (log_z - LOG_Z) * np.sqrt(len(log_w) / (1 / fraction - 1))


@pytest.mark.parametrize("width", [0.1, 10.0])
@pytest.mark.parametrize("model", [Normal(5), HeavyTailed(4), Banana(3)], ids=repr)
def test_a_first_guess_of_the_wrong_width(model, width):
    root = width * np.diag(model.sd)
    mode = Mode(model.mean, float(model.log_prob(model.mean[None])[0]), root)
    fraction, distance = fraction_and_distance(model, mode, 0)
    assert fraction > 0.5
    assert abs(distance) < 5


def test_a_first_guess_five_deviations_away():
    model = Normal(5)
    place = model.mean + 5 * model.root[:, 0]
    mode = Mode(place, float(model.log_prob(place[None])[0]), model.root)
    fraction, distance = fraction_and_distance(model, mode, 0)
    assert fraction > 0.5
    assert abs(distance) < 5


def test_many_skewed_coordinates_are_followed():
    """Independence Metropolis from exact draws; the rounds alone give 0.42 to 0.46."""
    model, rng = Skewed(14), np.random.default_rng(0)
    mode = Mode(np.full(14, np.log(2)), 0.0, np.eye(14) / np.sqrt(2))
    proposal = adapt(model.log_prob, (mode,), rng).proposal
    exact = np.log(rng.gamma(model.shape, size=(20_000, 14)))
    proposed = proposal.draw(rng, len(exact))
    log_w = [model.log_prob(x) - proposal.log_density(x) for x in (exact, proposed)]
    assert np.minimum(1, np.exp(np.minimum(log_w[1] - log_w[0], 0))).mean() > 0.5


def test_effective_fraction():
    assert effective_fraction(np.log([1.0, 1.0, 1.0, 1.0])) == pytest.approx(1)
    assert effective_fraction(np.array([0.0, -np.inf, -np.inf, -np.inf])) == pytest.approx(0.25)
    assert effective_fraction(np.full(3, -np.inf)) == 0
