"""What views of every kind say alike: noise, prior, verdict, caveats."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison
from bayescal.comparison.verdict import Verdict
from bayescal.noise.level import WHOLE_PIXEL, NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from bayescal.report.blocks import Blocks, Prose, listed
from bayescal.rounding import counted

# Beside a number whose evidence should not be trusted.
MARK = "?"
# What folds a table away that says what a figure above it shows.
IN_NUMBERS = "The same in numbers"


def noise_words(axis: AxisComparison) -> str:
    """Name the noise model with its priors, and where its level comes from."""
    noise = axis.noise_model
    plain = not noise.parameters and noise.level == "sigma"
    words = f"{shape_words(noise, axis.data)}{',' if plain else ';'} {noise.level}"
    return f"{words} {axis.noise_source}{level_words(axis.noise)}"


def shape_words(noise: NoiseModel, data: AxisData | None = None) -> str:
    """Say what a noise model is, with its priors."""
    return noise.described("px" if data is None else data.unit)


def level_words(level: NoiseLevel) -> str:
    """Say what an inferred sigma's prior is; nothing where sigma is known."""
    if level.bounds is None:
        return ""
    name, unit = level.parameter, "" if level.source == "scale" else " px"
    bounds = "uniform from {:.4g} to {:.4g}".format(*level.bounds)
    ruled_out = f"; below, ruled out by whole-pixel rounding, {1 - level.mass:.0%} of the prior"
    return f" (ln {name} {bounds}{unit}{ruled_out if level.mass < 1 else ''})"


def floor_words(data: AxisData, level: NoiseLevel) -> str:
    """Say where robust noise rules out part of sigma's prior that Gaussian noise keeps."""
    if data.generic or level.on_readings(data.t, data.sd).mass == 1:
        return ""
    return (
        f" Robust noise rules out sigma below the rounding of whole pixels, {WHOLE_PIXEL:.2g} px; "
        "above it the prior is the same."
    )


def prior_words(rule: PriorRule) -> str:
    """Name a prior and its numbers."""
    if not rule.proper:
        return "flat; improper, so that there is no evidence and no probability of an order"
    if not rule.scaled:
        return "stated in the setup: a normal for each Legendre amplitude"
    half = f"{rule.size / 2:g}"
    low, high = rule.tau_bounds
    tau = (
        f"= {rule.tau:g}"
        if rule.tau is not None
        else f"inferred, log-uniform {low:.3g} to {high:g} ({low * rule.size:.3g} to "
        f"{high * rule.size:.4g} px)"
    )
    return (
        f"field; b0 ~ N({rule.centre:g}, {half}²), b1 ~ N(0, {half}²), bj ~ N(0, (tau * "
        f"{rule.size:g})²) px; tau {tau}"
    )


def doubts(verdict: Verdict) -> tuple[str, ...]:
    """Say, beside an answer in large type, what could be wrong with it, the gravest first."""
    rest = sum(not finding.withholds for finding in verdict.findings)
    more = "more " if verdict.withheld else ""
    caveats = f"{counted(rest, f'{more}caveat')} below" if rest else ""
    # Where nothing is withheld, the answer itself says what else is plausible.
    open_ = verdict.not_excluded if verdict.withheld else ""
    return tuple(filter(None, (*verdict.withheld, open_, caveats)))


def p_words(value: float) -> str:
    """Probability of a tail, to three digits."""
    if value < 0.001:
        return "<0.001"
    return f"{value:.3f}"


def one_decimal(value: float) -> str:
    """Format with one decimal, or three digits where that would be too wide."""
    return f"{value:.1f}" if abs(value) < 1e5 else f"{value:.3g}"


def verdict_blocks(verdict: Verdict, lead: str) -> Blocks:
    """Say a verdict in words, with its caveats."""
    return Prose(verdict.text, lead=lead), *caveats(verdict)


def caveats(verdict: Verdict) -> Blocks:
    """Say what stands against a verdict or limits it, the gravest first."""
    return listed([f"{caveat}." for caveat in verdict.caveats], "caveat")


def distrust(why: str, *, sound: bool) -> Blocks:
    """Say why a result must not be trusted; nothing where it is sound."""
    return () if sound else (Prose(why, lead="NOT SOUND"),)
