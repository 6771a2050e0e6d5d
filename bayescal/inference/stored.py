"""A chain as arrays and JSON values: what a file keeps so that nothing is sampled again.

How a model without a closed form is kept: the same groups, with its completed draws as
``unconstrained_posterior/full`` ``(n_chains, n_draws, n_full)``, and its evidence estimate
as ``values["estimate"]`` (``dataclasses.asdict``). Unknown arrays and values are left
alone by `unpack`, so that both kinds share the file, and a reader of the one need not know
the other.
"""

from __future__ import annotations

import numpy as np

from bayescal.inference.arviz_bridge import Diagnostics, Draws
from bayescal.inference.sampling import Chain


def pack(chain: Chain, names: tuple[str, ...]) -> Draws:
    """Arrange a chain in ArviZ's groups.

    Parameters
    ----------
    chain : Chain
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
    draws : Draws
    names : tuple of str
        Of the parameters that the model reports.

    Raises
    ------
    ValueError
        Where the draws are of other parameters, or something is missing.
    """
    values = draws.values
    try:
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
    except (KeyError, TypeError) as error:
        raise ValueError(f"lacks {error}") from None
    if chain.draws.shape[:2] != chain.log_prob.shape or len(chain.diagnostics) != len(names):
        raise ValueError("holds arrays that don't fit together")
    return chain
