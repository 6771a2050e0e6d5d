"""Samplers of chains: what each prepares (cold), and a run to so many effective samples (warm)."""

from __future__ import annotations

from typing import Any

import numpy as np

from bayescal.arrays import Array
from scripts.peers.posterior import Posterior
from scripts.peers.sampled import Sampled, grown, of_chains, of_ensembles

CHAINS, WARM_UP, DRAWS = 4, 1000, 1500
ENSEMBLES, WALKERS = 2, 32


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
