"""A paragraph for a paper, built from what was really done."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.prior.amplitudes import PriorRule
from bayescal.report.blocks import Listing, Prose, Section
from bayescal.report.views.words import noise_words

Cite = Callable[[str], str]
Axes = tuple[AxisComparison, ...]
REFERENCES = {
    "emcee": "Foreman-Mackey, Hogg, Lang & Goodman 2013, emcee: The MCMC Hammer, PASP 125, 306.",
    "bishop": "Bishop 2006, Pattern Recognition and Machine Learning, Springer, sections 3.3, 3.5.",
    "rhat": "Vehtari, Gelman, Simpson, Carpenter & Bürkner 2021, Rank-normalization, folding, and "
    "localization: an improved R-hat, Bayesian Analysis 16, 667.",
    "kass": "Kass & Raftery 1995, Bayes factors, J. Am. Stat. Assoc. 90, 773.",
    "aicc": "Hurvich & Tsai 1989, Regression and time series model selection in small samples, "
    "Biometrika 76, 297.",
    "bic": "Schwarz 1978, Estimating the dimension of a model, Ann. Statist. 6, 461.",
    "loo": "Vehtari, Gelman & Gabry 2017, Practical Bayesian model evaluation using leave-one-out "
    "cross-validation and WAIC, Stat. Comput. 27, 1413.",
    "psis": "Vehtari, Simpson, Gelman, Yao & Gabry 2024, Pareto smoothed importance sampling, "
    "JMLR 25, 72.",
    "sivula": "Sivula, Magnusson & Vehtari 2020, Uncertainty in Bayesian leave-one-out "
    "cross-validation based model comparison, arXiv:2008.10296.",
    "holm": "Holm 1979, A simple sequentially rejective multiple test procedure, Scand. J. "
    "Statist. 6, 65.",
}


def section(
    comparison: Comparison, beside: Iterable[str], provenance: Mapping[str, Any]
) -> Section:
    """Give the paragraph, with the references it cites numbered as cited.

    Parameters
    ----------
    beside : iterable of str
        What is said of results shown beside it.
    provenance : mapping
        Of its document.
    """
    cited: dict[str, int] = {}

    def cite(name: str) -> str:
        return f"[{cited.setdefault(name, len(cited) + 1)}]"

    axes = tuple(comparison.axes.values())
    sentences = [*_models(comparison, axes), *_inference(comparison, axes, cite)]
    sentences += [*beside, *_checks(axes, cite)]
    sentences.append(
        f"bayescal {provenance['bayescal']} was used, with emcee {provenance['emcee']}, numpy "
        f"{provenance['numpy']} and seed {provenance['seed']}."
    )
    references = tuple(REFERENCES[name] for name in cited)
    return Section(
        "methods",
        "Methods",
        "Ready to paste; built from the settings of this very analysis.",
        (Prose(" ".join(sentences), "quote"), Listing(references, "numbered")),
    )


def _models(comparison: Comparison, axes: Axes) -> Iterable[str]:
    first = axes[0]
    orders = [r.order for r in first.orders]
    names = " and ".join(f"{a.data.axis} in {a.data.regressor}" for a in axes)
    listed = ", ".join(map(str, orders[:-1])) + f" and {orders[-1]}" if orders[1:] else orders[0]
    what = "pixel coordinates" if comparison.points is not None else "values"
    yield (
        f"The {what} of {first.data.n} points were modelled by polynomials of "
        f"order{'s' * (len(orders) > 1)} {listed}: {names}."
    )
    for axis in axes:
        yield f"The noise of {axis.data.axis} was {noise_words(axis)}."
    priors = {axis.data.axis: _prior(axis.prior) for axis in axes}
    if len(set(priors.values())) == 1:
        yield _prior(first.prior)
    else:
        yield " ".join(
            f"For {name}, {words[0].lower()}{words[1:]}" for name, words in priors.items()
        )


def _prior(rule: PriorRule) -> str:
    if not rule.proper:
        return "The coefficients had a flat prior, under which models have no evidence."
    if not rule.scaled:
        return "The Legendre amplitudes of the polynomials had the normal priors of the setup file."
    low, high = rule.tau_bounds
    strength = (
        f"tau log-uniform from {low:.3g} to {high:g} and averaged over"
        if rule.tau is None
        else f"tau = {rule.tau:g}"
    )
    return (
        "In Legendre polynomials of the regressor scaled to [-1, 1], the amplitudes of orders "
        "0 and 1 had normal priors with sds of half the image, those of higher orders normal "
        f"priors about zero with sds of tau times the image, {strength}."
    )


def _inference(comparison: Comparison, axes: Axes, cite: Cite) -> Iterable[str]:
    results = [r for axis in axes for r in axis.orders]
    ess = comparison.settings.ess
    yield (
        f"Each model was sampled with emcee {cite('emcee')} until the bulk and tail effective "
        f"sample sizes of every parameter reached {ess}, R-hat fell below 1.01 {cite('rhat')} and "
        "the chains were longer than 50 autocorrelation times"
        + ("." if all(r.posterior.converged for r in results) else "; not all models reached it.")
    )
    if all(r.posterior.exact is not None for r in results):
        yield (
            f"The closed-form posterior {cite('bishop')}, with sigma and tau integrated by "
            "quadrature, gave the evidence and checked the means and standard deviations of the "
            "draws."
        )
    else:
        yield ("The evidence was estimated by importance sampling and checked by bridge sampling.")
    if all(axis.verdict.order is not None for axis in axes):
        yield (
            "Orders were equally probable beforehand; the plausible ones are the fewest whose "
            "posterior probabilities reach 0.95, and the strength of evidence is in the words of "
            f"Kass & Raftery {cite('kass')}."
        )


def _checks(axes: Axes, cite: Cite) -> Iterable[str]:
    if all(axis.noise_model.conjugate for axis in axes):
        results = [r.criteria for axis in axes for r in axis.orders]
        criteria = [
            words if all(known) else f"{words} (where it is defined)"
            for words, known in (
                (f"AICc {cite('aicc')}", [c.aicc is not None for c in results]),
                (f"BIC {cite('bic')}", [c.bic is not None for c in results]),
            )
            if any(known)
        ]
        if criteria:
            yield (
                f"For comparison, {' and '.join(criteria)} "
                f"{'were' if len(criteria) > 1 else 'was'} computed from the full maximised "
                "likelihood."
            )
    defences = [axis.defence for axis in axes if axis.defence is not None]
    if any(d.prediction for d in defences):
        yield (
            f"Predictive accuracy was judged by leave-one-out {cite('loo')}, with Pareto-smoothed "
            f"importance sampling {cite('psis')} of the draws; the standard errors of small "
            f"samples may be too small {cite('sivula')}."
        )
    resampled = [b for d in defences[:1] for b in d.resampled]
    if resampled:
        units = " and ".join(f"{b.unit}s" for b in resampled)
        yield (
            f"The choice was repeated over {resampled[0].resamples} bootstrap resamples of the "
            f"{units}, and with every single one removed."
        )
    if any(axis.adequacy for axis in axes):
        yield (
            "The adequacy of the recommended orders was tested with p-values adjusted for each "
            f"other {cite('holm')}."
        )
