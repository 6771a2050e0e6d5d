"""Models of r and c in sentences: what was assumed, how they fit, what their table does not say."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison, GroupedErrors
from bayescal.comparison.key import FREE, PINHOLE
from bayescal.inference.correlation import weak_lines
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.polynomials import bivariate
from bayescal.report.numbers import correlations
from bayescal.report.views.words import p_words, shape_words
from bayescal.rounding import counted, significant

FEW = 100  # points, below which leave-one-out's own errors are too small


def about(found: FamilyComparison) -> list[str]:
    """Points and camera, a line each."""
    x, y, z = found.points.setup.position
    return [
        f"{len(found.points)} points from {found.points.source}, r and c jointly; camera stated at "
        f"({x:g}, {y:g}, {z:g})",
        *(f"note: {note}" for note in found.notes),
    ]


def assumed_lines(found: FamilyComparison) -> list[tuple[str, str]]:
    """Noise and priors, named."""
    r, c = found.noise
    shape = shape_words(found.settings.choice.model(1.0))
    pairs = [("noise", f"{shape}; sigma of r {r}; sigma of c {c}")]
    pairs += [("prior", line) for line in found.priors]
    if any(m.key.family == PINHOLE for m in found.models):
        pairs.append(("distortion", f"radial, in {found.request.radial} powers of the radius"))
    return pairs


def weak_words(posterior: SampledPosterior) -> list[str]:
    """Name what moves together, a sentence for each combination."""
    return weak_lines(posterior.names, correlations(posterior))


def methods_words(found: FamilyComparison) -> Iterator[str]:
    """Say, beside a comparison of orders, how the models were compared."""
    names = list(dict.fromkeys(m.key.family for m in found.models))
    places = sorted({m.key.position for m in found.models}, reverse=True)
    one = len(found.models) == 1
    yield (
        f"Beside them, {'one joint model' if one else f'{len(found.models)} joint models'} "
        "of r and c "
        f"{'was' if one else 'were'} compared on the same pixels (families: {', '.join(names)}; "
        f"camera position {' or '.join(places)}), families equally probable beforehand."
    )
    if not all(m.exact for m in found.models):
        yield "Evidences without a closed form come from importance sampling."


def no_criteria(found: FamilyComparison) -> str:
    """Say why a model has no AIC and BIC."""
    if found.settings.choice.robust:
        return "no AIC and BIC: under this noise the likelihood may have no maximum."
    return "no AIC and BIC: residuals of an axis are rounding, it is fitted exactly."


def power_words(model: JointModel) -> list[str]:
    """Say which power of a coefficient's name is whose, where it has two."""
    if model.key.family != bivariate.NAME:
        return []
    return ["First power: of x/z in r (alpha), of y/z in c (beta); second: of the other."]


def grouped_words(found: GroupedErrors | None) -> list[str]:
    """Say what the deviations by groups are; nothing where there are none."""
    if found is None:
        return []
    groups = "groups" if found.source == "column group" else "planes of equal z"
    return [
        f"sd, groups: by the jackknife over {found.count} {groups}, of the pixels alone; it holds "
        "where points of a group share errors, which sd and interval take for independent. "
        f"Student's t of {found.count - 1} degrees of freedom makes an interval of it."
    ]


def fit_words(model: JointModel) -> str | None:
    """Say how well a model fits, where sigma is not inferred."""
    good = model.goodness
    if good is None or good.chi2 is None or good.chi2_reduced is None:
        return None
    assert good.chi2_reduced_sd is not None, "there are degrees of freedom"
    words = (
        f"Chi-squared of {model.key}: {good.chi2:.1f} with {good.dof} dof, reduced "
        f"{good.chi2_reduced:.2f} (1 ± {good.chi2_reduced_sd:.2f} expected)"
    )
    if good.p_value is not None and good.p_value_lower is not None:
        words += f", p {p_words(good.p_value)} (lower tail {p_words(good.p_value_lower)})"
    if model.key.family == PINHOLE or model.key.position == FREE:
        words += "; dof of a non-linear model are approximate"
    return f"{words}."


def models_notes(found: FamilyComparison, rows: Iterable[int], rest: str) -> list[str]:
    """Say what the table of models does not, and where the `rest` of the models is."""
    shown = [found.models[i] for i in rows]
    notes = []
    if not all(m.sound for m in shown):
        notes.append("! marks an evidence that should not be trusted; the caveats say why.")
    loos = [m.loo for m in shown if m.loo is not None]
    errors = [loo.mcse for loo in loos if loo.reliable]
    refits = sum(len(loo.refitted) for loo in loos)
    if refits:
        largest = significant(max(errors, default=0.0), 1)
        notes.append(
            f"elpd: {counted(refits, 'term')} whose importance weights had a heavy tail (Pareto k "
            "from 0.4) come from the evidence without the point."
            + f" Monte Carlo errors of elpd: at most {largest}."
            * bool(errors)
        )
    if len(loos) < len(shown):
        notes.append(
            "elpd is left empty where too few draws count, or fit into memory, to tell of every "
            "point."
        )
    if not all(loo.reliable for loo in loos):
        notes.append(
            "? marks an elpd whose importance weights have too heavy a tail (Pareto k not below "
            "0.7): neither it nor its differences should be trusted."
        )
    if len(found.points) < FEW:
        notes.append(
            f"Under {FEW} points, errors of elpd differences may be up to twice too small (Sivula "
            "et al. 2020)."
        )
    notes += filter(None, [fit_words(found.best)])
    left = len(found.models) - len(shown)
    if left:
        notes.append(f"{left} less probable models are not shown ({rest}).")
    return notes


def sampling_words(found: FamilyComparison) -> str:
    """Say how the sampling of all models went; empty where none was sampled."""
    sampled = [m.posterior for m in found.models if m.posterior is not None]
    if not sampled:
        return ""
    parameters = [p for s in sampled for p in s.parameters]
    return (
        f"emcee, {len(sampled)} model{'s' * (len(sampled) > 1)}, seed {found.settings.seed}: "
        f"acceptance at least {min(s.chain.acceptance for s in sampled):.2f}, ESS at least "
        f"{min(p.ess for p in parameters):.0f}, R-hat at most "
        f"{max(p.rhat for p in parameters):.3f}."
    )
