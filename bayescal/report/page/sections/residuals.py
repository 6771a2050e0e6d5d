"""What the recommended order leaves over, looked at four ways."""

from __future__ import annotations

from bayescal.report.page.blocks import Block, Part, Section
from bayescal.report.page.subject import PageSubject


def section(subject: PageSubject) -> Section:
    """Show residuals over both regressors, over the image, and against normal quantiles."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        name, regressor = axis.data.axis, axis.data.regressor
        of = f"{name} at order {axis.chosen.order}"
        blocks = [
            subject.picture(
                "residuals",
                f"Residuals of {of} over {regressor}. A trend here asks for a higher order.",
                name,
            )
        ]
        if len(subject.axes) > 1:
            words = (
                f"Residuals of {of} over the other regressor. A trend here is one that no order "
                f"of {regressor} can take up."
            )
            blocks.append(subject.picture("other", words, name))
        words = f"Normal quantiles of the studentised residuals of {of}, with a 95% envelope."
        blocks.append(subject.picture("qq", words, name))
        parts[name] = tuple(blocks)
    blocks = list(subject.parts(parts))
    if subject.comparison.points is not None:
        words = "Residuals over the image plane, from predicted to measured; lengths magnified."
        blocks.append(Part("Over the image", (subject.picture("image", words),)))
    return Section(
        "residuals",
        "Residuals",
        "What the recommended orders leave over should look like noise in every view.",
        tuple(blocks),
    )
