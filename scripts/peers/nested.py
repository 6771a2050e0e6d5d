"""Nested sampling, which ends by a rule of its own."""

from __future__ import annotations

import numpy as np

from scripts.peers.posterior import Posterior
from scripts.peers.sampled import Sampled


class Dynesty:
    """dynesty's static nested sampling with its defaults."""

    def __init__(self, posterior: Posterior) -> None:
        self.posterior = posterior

    def run(self, seed: int, ess: int) -> Sampled:  # noqa: ARG002 - its defaults decide
        """Run once."""
        from dynesty import NestedSampler

        p = self.posterior
        sampler = NestedSampler(
            lambda x: float(p.log_likelihood(x)), p.from_unit, len(p.names),
            rstate=np.random.default_rng(seed),
        )  # fmt: skip
        sampler.run_nested(print_progress=False)
        found = sampler.results
        w = found.importance_weights()
        return Sampled(
            1 / float((w**2).sum()), None, float(found.logz[-1]), float(found.logzerr[-1])
        )


class UltraNest:
    """UltraNest's reactive nested sampling, vectorised, its other defaults kept."""

    def __init__(self, posterior: Posterior) -> None:
        self.posterior = posterior

    def run(self, seed: int, ess: int) -> Sampled:  # noqa: ARG002 - its defaults decide
        """Run once."""
        import logging

        from ultranest import ReactiveNestedSampler

        logging.getLogger("ultranest").setLevel(logging.ERROR)
        np.random.seed(seed)  # noqa: NPY002 - its only source of randomness
        p = self.posterior
        sampler = ReactiveNestedSampler(p.names, p.log_likelihood, p.from_unit, vectorized=True)
        found = sampler.run(show_status=False, viz_callback=False)
        return Sampled(float(found["ess"]), None, float(found["logz"]), float(found["logzerr"]))
