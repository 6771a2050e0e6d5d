"""Proposals that are wrong on purpose, for negative controls."""

from __future__ import annotations

from bayescal.inference.proposals.proposal import LinearProposal
from bayescal.linear.closed_form import ExactPosterior


class Misstated(LinearProposal):
    """Draws as wide as `width` says, from a density that claims the exact width."""

    def __init__(self, exact: ExactPosterior, width: float) -> None:
        super().__init__(exact)
        self.width = width

    def _normal(self, node, variance):
        mean, spread = super()._normal(node, variance)
        return mean, self.width**2 * spread
