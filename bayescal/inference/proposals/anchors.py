"""What stays in a proposal whatever the draws say: the modes, and a broad component."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array
from bayescal.inference.optimum import Mode
from bayescal.inference.t_mixture import TMixture

COMPONENTS = 9
DOF, BROAD_DOF = 8.0, 3.0  # while adapting; the final tails are chosen
INFLATED = 1.5  # first guess over the Laplace approximation, in deviations
BROAD = 3.0  # the defensive component over all draws, in deviations
DEFENSIVE = 0.03
HELD = 0.02  # by the modes
# With a ladder: held by its rungs, and components. Where a tau that reaches down to a hundredth of
# a pixel makes a spike, the effective fraction rises from 0.24 to 0.46 on the thesis data.
LADDER_HELD, LADDER_COMPONENTS = 0.2, 18


@dataclass(frozen=True, eq=False)
class Anchors:
    """What stays in a proposal whatever the draws say, and how many components it has.

    Attributes
    ----------
    held : float
        Share of the proposal that they keep.
    """

    modes: tuple[Mode, ...]
    held: float
    components: int

    @classmethod
    def of(cls, modes: tuple[Mode, ...], ladder: tuple[Mode, ...]) -> Anchors:
        """Hold the modes where there are several, and the rungs of a ladder."""
        if ladder:
            return cls((*modes, *ladder), LADDER_HELD, LADDER_COMPONENTS)
        return cls(modes, HELD * (len(modes) > 1), COMPONENTS)

    @property
    def laplace(self) -> TMixture:
        """Laplace approximations, inflated; a mode's mass is only guessed."""
        return TMixture(
            np.asarray(softmax([m.log_mass / 4 for m in self.modes])),
            np.array([m.theta for m in self.modes]),
            np.array([INFLATED * m.root for m in self.modes]),
            np.full(len(self.modes), DOF),
        )

    def defended(self, narrow: TMixture, mean: Array, root: Array) -> TMixture:
        """Add the anchors, and a broad component.

        A mode of a hundredth of the mass is soon lost by the draws, and then a single draw there
        may weigh as much as a quarter of all.
        """
        kept, share = self.laplace, 1 - self.held - DEFENSIVE
        return TMixture(
            np.concatenate([share * narrow.weights, self.held * kept.weights, [DEFENSIVE]]),
            np.concatenate([narrow.means, kept.means, mean[None]]),
            np.concatenate([narrow.roots, kept.roots, BROAD * root[None]]),
            np.concatenate([narrow.dof, kept.dof, [BROAD_DOF]]),
        )

    def with_more(
        self, narrow: TMixture, theta: Array, weights: Array, root: Array, rng: np.random.Generator
    ) -> TMixture:
        """Add components about weighted draws, up to so many; all alike in share."""
        more = max(self.components - len(narrow.weights), 0)
        seeds = rng.choice(len(theta), more, p=weights)
        n = len(narrow.weights) + more
        return TMixture(
            np.full(n, 1 / n),
            np.concatenate([narrow.means, theta[seeds]]),
            np.concatenate([narrow.roots, np.repeat(root[None], more, axis=0)]),
            np.full(n, DOF),
        )
