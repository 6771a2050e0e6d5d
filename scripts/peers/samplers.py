"""One class per peer: what it prepares (cold), and a run to so many effective samples (warm)."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.checked_posterior import sample_posterior
from bayescal.inference.coordinates import WhitenedProposal, Whitening
from bayescal.inference.diagnostics import diagnose
from bayescal.inference.move import IndependenceMove
from bayescal.inference.proposal import LinearProposal
from bayescal.inference.sampling import autocorrelation_time, quiet_sampler
from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import exact_posterior
from scripts.peers.posterior import Posterior

OURS, MANY, DIRECT = "bayescal", "bayescal, 1000 walkers", "closed form, drawn from"
CHAINS, WARM_UP, DRAWS = 4, 1000, 1500
ENSEMBLES, WALKERS = 2, 32
RHAT = 1.01
BUDGET = 100.0  # seconds of processor time after which a run is not made longer


class Sampled(NamedTuple):
    """What a run gave: effective samples of the worst parameter, R-hat, evidence and its error."""

    ess: float
    rhat: float | None = None
    log_evidence: float | None = None
    error: float | None = None


class Sampler(Protocol):
    """A peer, prepared for a posterior."""

    def __init__(self, posterior: Posterior) -> None: ...

    def run(self, seed: int, ess: int) -> Sampled:
        """Sample until so many effective samples are there, where it can be told to."""
        ...


def of_chains(chains: Array) -> Sampled:
    """Bulk and tail ESS and R-hat of chains ``(chains, draws, dimension)``, the worst of each."""
    found = diagnose(chains)
    return Sampled(min(min(d.ess_bulk, d.ess_tail) for d in found), max(d.rhat for d in found))


def of_ensembles(chains: list[Array]) -> Sampled:
    """ESS by emcee's autocorrelation time, R-hat over ensembles ``(steps, walkers, dimension)``."""
    from emcee.autocorr import integrated_time

    size = math.inf
    for j in range(chains[0].shape[2]):
        each = [c[:, :, j].size / integrated_time(c[:, :, j], tol=0)[0] for c in chains]
        size = min(size, float(sum(each)))
    merged = np.array([c.reshape(-1, c.shape[2]) for c in chains])
    return Sampled(size, of_chains(merged).rhat)


def grown(more: Callable[[int], Sampled], first: int, ess: int) -> Sampled:
    """Go on, as many draws again each time, until a run has what is wanted of it."""
    begin, steps = time.process_time(), first
    found = more(steps)
    while found.ess < ess or (found.rhat or math.inf) >= RHAT:
        if time.process_time() - begin > BUDGET:
            break
        found = more(steps)
        steps *= 2
    return found


class Bayescal:
    """The program itself: closed form, emcee with an independence move, diagnosed and checked."""

    def __init__(self, posterior: Posterior) -> None:
        self.model = posterior.linear

    def run(self, seed: int, ess: int) -> Sampled:
        """Sample as `compare` does."""
        found = sample_posterior(self.model, np.random.default_rng(seed), ess)
        chain = found.chain
        size = min(min(d.ess_bulk, d.ess_tail) for d in chain.diagnostics)
        rhat = max(d.rhat for d in chain.diagnostics)
        return Sampled(size, rhat, found.log_evidence, found.log_evidence_error)


class Thousand:
    """The closed form and the independence move alone, at 1000 walkers, for as many draws."""

    walkers, steps = 1000, 400

    def __init__(self, posterior: Posterior) -> None:
        self.model = posterior.linear

    def run(self, seed: int, ess: int) -> Sampled:  # noqa: ARG002 - a length of its own
        """Sample; 64 walkers say how the others are."""
        model, rng = self.model, np.random.default_rng(seed)
        exact = exact_posterior(model)
        whitening = Whitening.of(exact)
        proposal = WhitenedProposal(LinearProposal(exact), whitening)
        start = proposal.draw(rng, self.walkers)
        move = IndependenceMove(proposal, rng)
        sampler = quiet_sampler(
            self.walkers, start.shape[1], lambda u: log_prob(model, whitening.theta(u)), move
        )
        sampler.run_mcmc(start, self.steps, skip_initial_state_check=True)
        some = sampler.get_chain()[:, :64].swapaxes(0, 1)
        times = [autocorrelation_time(some[:, :, j]) for j in range(some.shape[2])]
        found, error = exact.log_evidence, exact.log_evidence_error
        return Sampled(self.walkers * self.steps / max(times), None, found, error)


class Direct:
    """The closed form and independent draws of it by numpy: nothing is sampled."""

    draws, together = 400_000, 40_000

    def __init__(self, posterior: Posterior) -> None:
        self.model = posterior.linear

    def run(self, seed: int, ess: int) -> Sampled:  # noqa: ARG002 - a length of its own
        """Draw."""
        rng, exact = np.random.default_rng(seed), exact_posterior(self.model)
        proposal = LinearProposal(exact)
        for _ in range(self.draws // self.together):
            proposal.draw(rng, self.together)
        return Sampled(self.draws, None, exact.log_evidence, exact.log_evidence_error)


class Emcee:
    """emcee's own move, the density one draw at a time: what a first script does."""

    def __init__(self, posterior: Posterior) -> None:
        import emcee

        dimension = len(posterior.names)
        self.start = posterior.start
        self.samplers = [
            emcee.EnsembleSampler(WALKERS, dimension, posterior.log_prob) for _ in range(ENSEMBLES)
        ]

    def run(self, seed: int, ess: int) -> Sampled:
        """Continue ensembles from least squares, a fifth of the first steps thrown away."""
        states = []
        for i, sampler in enumerate(self.samplers):
            rng = np.random.default_rng([seed, i])
            sampler.reset()
            sampler.random_state = np.random.RandomState(seed + i).get_state()
            begin = self.start + 1e-3 * rng.standard_normal((WALKERS, len(self.start)))
            states.append(sampler.run_mcmc(begin, 500, store=False))

        def more(steps: int) -> Sampled:
            for i, sampler in enumerate(self.samplers):
                states[i] = sampler.run_mcmc(states[i], steps)
            return of_ensembles([s.get_chain() for s in self.samplers])

        return grown(more, 2000, ess)


class Lmfit:
    """lmfit's Minimizer.emcee, told the log posterior."""

    def __init__(self, posterior: Posterior) -> None:
        import lmfit

        parameters = lmfit.Parameters()
        limits = dict(zip(posterior.names[posterior.p :], posterior.bounds, strict=True))
        for name, value in zip(posterior.names, posterior.start, strict=True):
            low, high = limits.get(name, (-np.inf, np.inf))
            parameters.add(name, value=value, min=low, max=high)

        def objective(p: Any) -> float:
            return float(posterior.log_prob(np.array([one.value for one in p.values()])))

        self.parameters = parameters
        self.minimizers = [lmfit.Minimizer(objective, parameters) for _ in range(ENSEMBLES)]

    def run(self, seed: int, ess: int) -> Sampled:
        """Continue ensembles by `reuse_sampler`."""
        options: dict[str, Any] = {"nwalkers": WALKERS, "float_behavior": "posterior"}
        chains: list[list[Array]] = [[] for _ in self.minimizers]
        first = True

        def more(steps: int) -> Sampled:
            nonlocal first
            for i, minimizer in enumerate(self.minimizers):
                burn = 500 if first else 0
                found = minimizer.emcee(
                    self.parameters, steps=steps + burn, burn=burn, seed=seed + i,
                    reuse_sampler=not first, progress=False, **options,
                )  # fmt: skip
                chains[i] = [*chains[i], np.asarray(found.chain)[-steps:]]
            first = False
            return of_ensembles([np.concatenate(c) for c in chains])

        return grown(more, 2000, ess)


class NumPyro:
    """NumPyro's NUTS, four chains side by side."""

    def __init__(self, posterior: Posterior) -> None:
        import jax
        import jax.numpy as jnp
        import numpyro
        from numpyro import distributions as dist
        from numpyro.infer import MCMC, NUTS, init_to_value

        jax.config.update("jax_enable_x64", True)
        design, t = jnp.asarray(posterior.design), jnp.asarray(posterior.t)
        half, p = posterior.size / 2, posterior.p

        def model() -> None:
            log_sigma = numpyro.sample("log_sigma", dist.Uniform(*posterior.bounds[0]))
            sd = half * jnp.ones(p)
            if posterior.order > 1:
                log_tau = numpyro.sample("log_tau", dist.Uniform(*posterior.bounds[1]))
                sd = sd.at[2:].set(posterior.size * jnp.exp(log_tau))
            b = numpyro.sample("b", dist.Normal(jnp.asarray(posterior.mean), sd))
            numpyro.sample("t", dist.Normal(design @ b, jnp.exp(log_sigma)), obs=t)

        start = {"b": jnp.asarray(posterior.start[:p])}
        start |= dict(zip(posterior.names[p:], posterior.start[p:], strict=True))
        kernel = NUTS(model, init_strategy=init_to_value(values=start))
        self.mcmc = MCMC(
            kernel, num_warmup=WARM_UP, num_samples=DRAWS, num_chains=CHAINS,
            chain_method="vectorized", progress_bar=False,
        )  # fmt: skip

    def run(self, seed: int, ess: int) -> Sampled:
        """Warm up, then continue the chains."""
        import jax

        chains: list[Array] = []
        self.mcmc.post_warmup_state = None

        def more(draws: int) -> Sampled:
            for _ in range(max(draws // DRAWS, 1)):
                self.mcmc.run(jax.random.PRNGKey(seed))
                chains.append(stacked(self.mcmc.get_samples(group_by_chain=True)))
                self.mcmc.post_warmup_state = self.mcmc.last_state
            return of_chains(np.concatenate(chains, axis=1))

        return grown(more, DRAWS, ess)


class Nutpie:
    """nutpie's NUTS of a PyMC model, compiled by numba."""

    def __init__(self, posterior: Posterior) -> None:
        import nutpie
        import pymc as pm
        import pytensor.tensor as pt

        p = posterior.p
        with pm.Model() as model:
            log_sigma = pm.Uniform("log_sigma", *posterior.bounds[0])
            sd = np.full(p, posterior.size / 2)
            if posterior.order > 1:
                log_tau = pm.Uniform("log_tau", *posterior.bounds[1])
                scaled = posterior.size * pt.exp(log_tau) * np.ones(p - 2)
                sd = pt.concatenate([sd[:2], scaled])
            b = pm.Normal("b", posterior.mean, sd, initval=posterior.start[:p])
            pm.Normal("t", pt.dot(posterior.design, b), pt.exp(log_sigma), observed=posterior.t)
        self.compiled = nutpie.compile_pymc_model(model)

    def run(self, seed: int, ess: int) -> Sampled:
        """Sample anew, longer, where the first run is too short."""
        import nutpie

        total = 0

        def more(draws: int) -> Sampled:
            nonlocal total
            total += draws
            found = nutpie.sample(
                self.compiled, draws=total, tune=WARM_UP, chains=CHAINS, cores=1, seed=seed,
                progress_bar=False,
            )  # fmt: skip
            names = [n for n in ("b", "log_sigma", "log_tau") if n in found.posterior]
            return of_chains(stacked({n: found.posterior[n].values for n in names}))

        return grown(more, DRAWS, ess)


def stacked(found: dict[str, Any]) -> Array:
    """Arrays ``(chains, draws, ...)`` by name as one, ``(chains, draws, dimension)``."""
    arrays = [np.asarray(values) for values in found.values()]
    return np.concatenate([a.reshape(*a.shape[:2], -1) for a in arrays], axis=2)


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


PEERS: dict[str, type[Sampler]] = {
    OURS: Bayescal,
    MANY: Thousand,
    DIRECT: Direct,
    "nutpie": Nutpie,
    "NumPyro": NumPyro,
    "emcee": Emcee,
    "lmfit": Lmfit,
    "dynesty": Dynesty,
    "UltraNest": UltraNest,
}
