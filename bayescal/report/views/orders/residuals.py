"""What the recommended order leaves over, looked at four ways."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Blocks, Details, Figure, Part
from bayescal.report.views.views import Topic


def of_axis(comparison: Comparison, axis: AxisComparison) -> Blocks:
    """Show residuals over both regressors; against normal quantiles folded away."""
    name, regressor = axis.data.axis, axis.data.regressor
    of = f"{name} at order {axis.chosen.order}"
    captions = {
        "residuals": f"Residuals of {of} over {regressor}. A trend here asks for a higher order.",
        "other": f"Residuals of {of} over the other regressor. A trend here is one that no order "
        f"of {regressor} can take up.",
    }
    if len(comparison.axes) == 1:
        del captions["other"]
    shown = [Figure(kind, comparison, words, name) for kind, words in captions.items()]
    words = f"Normal quantiles of the studentised residuals of {of}, with a 95% envelope."
    quantiles = Figure("qq", comparison, words, name)
    return (*shown, Details(f"Are the residuals of {name} normal?", (quantiles,)))


def over_the_image(comparison: Comparison) -> Blocks:
    """Show residuals over the image."""
    if comparison.points is None:
        return ()
    words = "Residuals over the image plane, from predicted to measured; lengths magnified."
    return (Part("r and c together", (Figure("image", comparison, words),)),)


TOPIC = Topic(
    "residuals",
    "Residuals",
    "What the recommended orders leave over should look like noise in every view.",
    of_axis,
    after=over_the_image,
)
