"""The noise of an axis in words, whatever it is."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison
from bayescal.noise.level import WHOLE_PIXEL, NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import RATE, SHAPE, StudentT
from bayescal.polynomials.axis_data import AxisData

# Beside a number whose evidence should not be trusted.
MARK = "?"
NU_PRIOR = f"~ Gamma(shape {SHAPE:g}, rate {RATE:g})"


def noise_kind(axis: AxisComparison) -> str:
    """Say what the noise is about its level, its priors, and where its level comes from."""
    words, level = shape_words(axis.noise_model, axis.data), axis.noise_source
    own = "its scale " if isinstance(axis.noise_model, StudentT) else ""
    return f"{words}{';' if axis.noise_model.parameters or own else ','} {own}sigma {level}"


def shape_words(noise: NoiseModel, data: AxisData | None = None) -> str:
    """Say what a noise model is, with its priors."""
    unit = "units of y" if data is not None and data.axis == "y" else "px"
    if isinstance(noise, StudentT):
        return f"Student-t, nu {NU_PRIOR if noise.nu is None else f'= {noise.nu:g}'}"
    if isinstance(noise, OutlierMixture):
        lower, upper = noise.width_bounds
        offset = "of an offset ~ N(0, width²)" if noise.infers_offset else "without offset"
        return (
            f"mixture of good points and bad ones, whose fraction is uniform from 0 to "
            f"{noise.largest_fraction:g} and which are wider by a width, log-uniform from "
            f"{lower:.4g} to {upper:.4g} {unit}, {offset}"
        )
    return "Gaussian"


def robust_footnotes(axis: AxisComparison) -> list[str]:
    """Say what the table of orders under robust noise does not."""
    lines = [
        "RSS is of least squares, for comparison: chi-squared, F tests, AIC and BIC belong to "
        "Gaussian noise. ln Z by importance sampling, checked by bridge sampling; the other "
        "columns are posterior means ± sd.",
    ]
    if isinstance(axis.noise_model, OutlierMixture):
        lines.append("Bad points: more probably bad than good, the worst first.")
    if any(r.warnings for r in axis.orders):
        lines.append(f"{MARK} marks an evidence that should not be trusted; the caveats say why.")
    return lines


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
    if data.axis == "y" or level.on_readings(data.t, data.sd).mass == 1:
        return ""
    return (
        f" Robust noise rules out sigma below the rounding of whole pixels, {WHOLE_PIXEL:.2g} px; "
        "above it the prior is the same."
    )
