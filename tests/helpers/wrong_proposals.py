"""Proposals that are wrong on purpose, for negative controls."""

from __future__ import annotations

from bayescal.inference.proposals.proposal import LinearProposal
from bayescal.linear.closed_form import ExactPosterior


class Misstated:
    """Draws as wide as `width` says, from a density that claims the exact width."""

    def __init__(self, exact: ExactPosterior, width: float) -> None:
        self.drawn, self.claimed = LinearProposal(exact, width), LinearProposal(exact)

    def draw(self, rng, size):
        return self.drawn.draw(rng, size)

    def log_density(self, theta):
        return self.claimed.log_density(theta)
