"""A chain as arrays and JSON values: what a file keeps so that nothing is sampled again.

How a model without a closed form is kept: the same groups, with its completed draws as
``unconstrained_posterior/full`` ``(n_chains, n_draws, n_full)``, and its evidence estimate
as ``values["estimate"]`` (``dataclasses.asdict``). Unknown arrays and values are left
alone by `unpack`, so that both kinds share the file, and a reader of the one need not know
the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any

import numpy as np

from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.chains.chain import Chain
from bayescal.inference.chains.diagnostics import Diagnostics
from bayescal.inference.checked_posterior import CheckedPosterior, posterior_of
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.optimum import Mode
from bayescal.inference.posterior import Posterior, summarise
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.inference.weighting import WeightedDraws
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.model import LinearModel


def packed(kept: Posterior | WeightedDraws) -> Draws:
    """Arrange draws of whatever kind."""
    if isinstance(kept, WeightedDraws):
        return pack_weighted(kept)
    draws = pack(kept.chain, kept.names)
    if kept.estimate is not None:  # no closed form gives the evidence and the rest again
        draws.groups["unconstrained_posterior"]["full"] = kept.full
        draws.values["estimate"] = asdict(kept.estimate)
        draws.values["modes"] = [
            {"theta": m.theta.tolist(), "value": m.value, "root": m.root.tolist()}
            for m in kept.modes
        ]
    return draws


def unpacked(
    draws: Draws, model: LinearModel | SampledModel
) -> CheckedPosterior | SampledPosterior | WeightedDraws:
    """Undo `packed`, to the last bit, for the model that the draws are of.

    Raises
    ------
    ValueError
        Where the draws are of other parameters, or something is missing.
    """
    if isinstance(model, LinearModel):
        return posterior_of(exact_posterior(model), unpack(draws, model.names))
    if "log_weights" in draws.groups.get("sample_stats", {}):
        return unpack_weighted(draws, model)
    return unpack_sampled(draws, model)


def pack(chain: Chain, names: tuple[str, ...]) -> Draws:
    """Arrange a chain in ArviZ's groups.

    Parameters
    ----------
    names : tuple of str
        Of the reported parameters, the last axis of ``chain.draws``.

    Returns
    -------
    Draws
        Reported parameters as ``posterior``, sampled coordinates as
        ``unconstrained_posterior/theta``, log of likelihood times prior as
        ``sample_stats/lp``.
    """
    return Draws(
        {
            "posterior": {name: chain.draws[:, :, j] for j, name in enumerate(names)},
            "unconstrained_posterior": {"theta": chain.theta},
            "sample_stats": {"lp": chain.log_prob},
        },
        {},
        {
            "names": list(names),
            "diagnostics": [list(d) for d in chain.diagnostics],
            "acceptance": chain.acceptance,
            "autocorrelation_time": chain.autocorrelation_time,
            "converged": chain.converged,
        },
    )


def unpack(draws: Draws, names: tuple[str, ...]) -> Chain:
    """Undo `pack`, to the last bit.

    Parameters
    ----------
    names : tuple of str
        Of the parameters that the model reports.

    Raises
    ------
    ValueError
        Where the draws are of other parameters, or something is missing.
    """
    values = draws.values
    with complaints():
        if tuple(values["names"]) != names:
            raise ValueError(f"holds {', '.join(values['names'])}, not {', '.join(names)}")
        posterior = draws.groups["posterior"]
        chain = Chain(
            np.stack([posterior[name] for name in names], axis=2),
            draws.groups["unconstrained_posterior"]["theta"],
            draws.groups["sample_stats"]["lp"],
            tuple(Diagnostics(*numbers) for numbers in values["diagnostics"]),
            values["acceptance"],
            values["autocorrelation_time"],
            values["converged"],
        )
    if chain.draws.shape[:2] != chain.log_prob.shape or len(chain.diagnostics) != len(names):
        raise ValueError("holds arrays that don't fit together")
    return chain


def unpack_sampled(draws: Draws, model: SampledModel) -> SampledPosterior:
    """Undo `packed`, to the last bit."""
    chain = unpack(draws, model.names)
    with complaints():
        estimate = estimate_from(draws.values["estimate"])
        modes = tuple(
            Mode(np.array(m["theta"]), m["value"], np.array(m["root"]))
            for m in draws.values["modes"]
        )
        full = draws.groups["unconstrained_posterior"]["full"]
    return SampledPosterior(chain, summarise(model.names, chain), model, full, estimate, modes)


@contextmanager
def complaints() -> Iterator[None]:
    """Say, as a ValueError, what draws lack."""
    try:
        yield
    except (KeyError, TypeError) as error:
        raise ValueError(f"lacks {error}") from None


def estimate_from(kept: dict[str, Any]) -> EvidenceEstimate:
    """Make an estimate of what ``dataclasses.asdict`` made of it; TypeError where it lacks some."""
    return EvidenceEstimate(**{**kept, "warnings": tuple(kept["warnings"])})


def pack_weighted(draws: WeightedDraws) -> Draws:
    """Arrange weighted draws: those picked as a chain of their own, and all log weights."""
    names, reported = draws.model.names, draws.reported
    return Draws(
        {
            "posterior": {name: reported[None, :, j] for j, name in enumerate(names)},
            "unconstrained_posterior": {"full": draws.full[None]},
            "sample_stats": {"log_weights": draws.log_weights[None]},
        },
        {},
        {"names": list(names), "estimate": asdict(draws.estimate)},
    )


def unpack_weighted(draws: Draws, model: SampledModel) -> WeightedDraws:
    """Undo `pack_weighted`, to the last bit."""
    with complaints():
        if tuple(draws.values["names"]) != model.names:
            raise ValueError(f"holds other parameters than {', '.join(model.names)}")
        (full,) = draws.groups["unconstrained_posterior"]["full"]
        (log_weights,) = draws.groups["sample_stats"]["log_weights"]
    if full.ndim != 2 or log_weights.shape != full.shape[:1]:
        raise ValueError("holds arrays that don't fit together")
    kept = draws.values.get("estimate")
    estimate = from_weights(log_weights) if kept is None else estimate_from(kept)
    return WeightedDraws(model, log_weights, full, estimate)
