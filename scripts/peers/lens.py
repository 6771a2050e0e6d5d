"""NumPyro's NUTS on a lens, its poses, sigma and strengths: every dimension, whitened."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.laplace import SIGMA_BOUNDS, degrees
from scripts.peers.sampled import Sampled, of_chains

CHAINS, WARM_UP, DRAWS = 4, 500, 500
SAME = 1e-6  # px^2, relative: sums of squares by both programs


class LensNuts:
    """Radial lens of order 2 with tangential terms under independent noise, in JAX.

    Parameters
    ----------
    problem : Problem
        At its mode, without bow, offsets or shared noise.
    """

    def __init__(self, problem: Problem) -> None:
        import jax
        import jax.numpy as jnp
        import numpyro
        from numpyro import distributions as dist
        from numpyro.infer import MCMC, NUTS, init_to_value

        jax.config.update("jax_enable_x64", True)
        model, data, poses = problem.model, problem.data, problem.poses
        if model.key != "radial 2 + p" or model.bow or problem.root is not None:
            raise ValueError("the peer knows radial 2 + p under independent noise alone")
        d, n_views = model.dimension, data.n_views
        world, pixels, seen = (jnp.asarray(a) for a in (data.world, data.pixels, data.seen))
        rotation, translation = jnp.asarray(poses.rotation), jnp.asarray(poses.translation)
        powers = jnp.array([3.0, 5.0, 2.0, 2.0])  # of the radius: k1, k2, p1, p2

        def turned(spin: Any) -> Any:
            """Rotation by a vector: Rodrigues' formula."""
            angle = jnp.sqrt(spin @ spin + 1e-30)
            x, y, z = spin / angle
            k = jnp.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            return jnp.eye(3) + jnp.sin(angle) * k + (1 - jnp.cos(angle)) * (k @ k)

        def squares(x: Any, steps: Any) -> Any:
            """Sum of squares at the lens's coordinates and steps of the poses."""
            fx = model.size[0] * jnp.exp(x[0])
            fy = fx * jnp.exp(x[1])
            k1, k2, p1, p2 = x[4:] * fx ** (powers - 1) / model.radius**powers
            turn = jax.vmap(turned)(steps[:, :3]) @ rotation
            at = jnp.einsum("vij,vnj->vni", turn, world)
            at = at + (translation + steps[:, 3:])[:, None]
            a, b = at[..., 0] / at[..., 2], at[..., 1] / at[..., 2]
            w = a**2 + b**2
            radial = 1 + w * (k1 + w * k2)
            u = a * radial + 2 * p1 * a * b + p2 * (w + 2 * a**2)
            v = b * radial + 2 * p2 * a * b + p1 * (w + 2 * b**2)
            off = jnp.stack([fx * u + x[2], fy * v + x[3]], axis=-1) - pixels
            return (jnp.where(seen[..., None], off, 0.0) ** 2).sum()

        here = float(squares(jnp.asarray(problem.x), jnp.zeros((n_views, 6))))
        ours = float((problem.stack.residuals**2).sum())
        if abs(here - ours) > SAME * ours:
            raise ValueError(f"sums of squares differ: {here} and {ours} px^2")
        sigma = (ours / degrees(data)) ** 0.5
        mean = np.concatenate([problem.x, np.zeros(6 * n_views)])
        root = jnp.asarray(sigma * _root(problem))
        plain_mean, plain_sd = (jnp.asarray(a) for a in model.plain_prior)
        groups = model.groups

        def density() -> None:
            log_sigma = numpyro.sample("log_sigma", dist.Uniform(*np.log(SIGMA_BOUNDS)))
            z = numpyro.sample("z", dist.Normal(0.0, 1.0).expand([d + 6 * n_views]).mask(False))
            x = jnp.asarray(mean) + root @ z
            lens = x[:d]
            numpyro.factor("plain", -0.5 * (((lens[:4] - plain_mean) / plain_sd) ** 2).sum())
            for group in groups:
                log_tau = numpyro.sample(group.name, dist.Uniform(*np.log(group.bounds)))
                sd = group.unit * jnp.exp(log_tau)
                numpyro.factor(
                    f"of {group.name}",
                    dist.Normal(0.0, sd).log_prob(lens[jnp.array(group.columns)]).sum(),
                )
            left = squares(lens, x[d:].reshape(n_views, 6))
            numpyro.factor(
                "residuals", -2 * data.n_points * log_sigma - left / (2 * jnp.exp(2 * log_sigma))
            )

        start = {"z": jnp.zeros(d + 6 * n_views), "log_sigma": np.log(sigma)}
        self._lens = np.asarray(root)[:d]
        self.dimension = d + 6 * n_views + 1 + len(groups)
        self._mcmc = MCMC(
            NUTS(density, init_strategy=init_to_value(values=start)),
            num_warmup=WARM_UP, num_samples=DRAWS, num_chains=CHAINS,
            chain_method="vectorized", progress_bar=False,
        )  # fmt: skip

    def run(self, seed: int) -> tuple[Sampled, float]:
        """Sample, compiled before: what the lens's coordinates have, and processor time, s."""
        import jax

        self._mcmc.run(jax.random.PRNGKey(seed))  # compiles
        begin = time.process_time()
        self._mcmc.run(jax.random.PRNGKey(seed + 1))
        z = np.asarray(self._mcmc.get_samples(group_by_chain=True)["z"])
        return of_chains(z @ self._lens.T), time.process_time() - begin


def _root(problem: Problem) -> Array:
    """Root of the inverse of J'J, of lens and poses, ``(n, n)``."""
    stack, n_views, d = problem.stack, problem.data.n_views, problem.model.dimension
    rows = np.zeros((*stack.residuals.shape, d + 6 * n_views))
    rows[..., :d] = stack.by_lens
    for view in range(n_views):
        at = d + 6 * view
        rows[view, ..., at : at + 6] = stack.by_pose[view]
    triangle = np.linalg.qr(rows.reshape(-1, rows.shape[-1]), mode="r")
    return np.asarray(np.linalg.inv(triangle))
