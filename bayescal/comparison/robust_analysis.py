"""One axis compared under robust noise: every order sampled, no closed form anywhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from bayescal.comparison.criteria import Criteria
from bayescal.comparison.evidence import probabilities
from bayescal.comparison.goodness import GoodnessOfFit, ReferenceSigma
from bayescal.comparison.key import Key
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.comparison.robust_caveats import robust_caveats
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.comparison.verdict import judge
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.sampled_posterior import sample_model
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.linear.replicates import pure_error
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule


def compare_robustly(
    level: tuple[AxisData, NoiseLevel, str],
    rule: PriorRule,
    fits: Mapping[int, LeastSquaresFit],
    settings: Settings,
    store: Store,
    progress: Callable[[str, int], None] | None,
) -> AxisComparison:
    """Compare the orders of an axis under a noise model without a closed form.

    Chi-squared and the criteria are Gaussian and left empty; the least-squares fits stay,
    for comparison.

    Parameters
    ----------
    level : tuple
        Data, noise level and how it was chosen, as `noise_level` gives it.
    rule : PriorRule
    fits : mapping of int to LeastSquaresFit
        By order.
    settings : Settings
    store : Store
    progress : callable or None

    Returns
    -------
    AxisComparison
    """
    data, noise, words = level
    shape = settings.noise_model(data)
    # All are built, and one that can't be is refused, before any is sampled.
    models = {k: RobustLinearModel.of_order(data, k, noise, rule.of_order(k), shape) for k in fits}
    posteriors = {}
    for k, model in models.items():
        if progress is not None:
            progress(data.axis, k)
        key = Key.of_axis(data.axis, k, shape.name)
        sample = partial(sample_model, model, key.rng(settings.seed), settings.ess)
        posteriors[k] = store.posterior(key, model, sample)
    evidence = {k: p.log_evidence for k, p in posteriors.items()}
    chances = dict(zip(evidence, probabilities(list(evidence.values())), strict=True))
    results = tuple(
        OrderResult(
            k,
            fit,
            float(np.sum((data.t - data.design(k) @ fit.amplitudes) ** 2)),
            GoodnessOfFit(None, fit.dof, None, None, None, None, None),
            Criteria(_parameters(posteriors[k].model.names), None, None, None, None),
            posteriors[k],
            chances[k],
        )
        for k, fit in fits.items()
    )
    verdict = judge(chances, evidence, {}, robust_caveats(results, noise))
    plain = AxisComparison(
        data,
        noise,
        words,
        rule,
        ReferenceSigma("none", None, None),
        pure_error(data.x, None, data.t),
        results,
        verdict,
        noise_model=shape,
    )
    if not settings.defend:
        return plain
    if progress is not None:
        progress(data.axis, 0)
    return _defended(plain, store, settings)


def _parameters(names: tuple[str, ...]) -> int:
    """K: everything inferred but tau, a hyperparameter."""
    return len(names) - ("tau" in names)


def _defended(plain: AxisComparison, store: Store, settings: Settings) -> AxisComparison:
    """Add the answers to a referee, as far as they exist."""
    from bayescal.comparison.defence.argument import argue
    from bayescal.comparison.defence.noise_evidence import about_noise, with_noises
    from bayescal.comparison.defence.robust_defence import defend_robustly

    defence = with_noises(plain, defend_robustly(plain, store, settings), store, settings)
    argued = about_noise(argue(plain.verdict, defence, {}, plain.data.size), plain, defence)
    return replace(plain, verdict=argued, defence=defence)
