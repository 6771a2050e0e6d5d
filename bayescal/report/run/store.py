"""A run in place of the sampler: draws are read where they would be computed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from bayescal.comparison.key import Key
from bayescal.comparison.store import Store
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.chains.chain import Chain
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.stored import unpacked
from bayescal.inference.target import log_prob
from bayescal.inference.weighting import WeightedDraws
from bayescal.linear.model import LinearModel
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.report.run.files import RunFiles

if TYPE_CHECKING:
    from bayescal.comparison.store import Kept


# Draws whose density is evaluated again, and by how much it may differ, nat: rounding elsewhere.
SPOTS, WITHIN = 4, 1e-4


class StoredDraws(Store):
    """The draws of a run, in whose files' names the noise that is `usual` there is left out."""

    def __init__(self, run: RunFiles, usual: str = GAUSSIAN.name) -> None:
        super().__init__()
        self.run, self.usual = run, usual

    def read(self, key: Key, model: LinearModel | SampledModel, *, beside: bool) -> Kept | None:
        """Read the draws of a model; None where it stands `beside` and the run kept none."""
        name = key.file(self.usual)
        if beside and not self.run.keeps_draws(name):
            return None
        checked = self.run.derives

        def unpack(draws: Draws) -> Kept:
            found = unpacked(draws, model)
            if checked and not isinstance(found, WeightedDraws):
                _spot_check(model, found.chain)
            return found

        return self.run.read_draws(name, unpack)

    def known(self, name: str, kind: Any) -> tuple[Any] | None:
        """Read a value that took long; None where the run kept none of that name."""
        return self.run.derived_value(name, kind)


def _spot_check(model: LinearModel | SampledModel, chain: Chain) -> None:
    """Evaluate the density at a few draws; ValueError where it is not what was kept of them."""
    theta, kept = chain.theta.reshape(-1, chain.theta.shape[2]), chain.log_prob.ravel()
    some = np.linspace(0, len(kept) - 1, SPOTS).astype(int)
    now = (
        log_prob(model, theta[some])
        if isinstance(model, LinearModel)
        else model.log_prob(theta[some])
    )
    if not np.allclose(now, kept[some], rtol=0, atol=WITHIN):
        raise ValueError("the density of its draws is not the one that was kept of them")
