"""A figure of one panel in axes that the user gives.

Truth: the same artists as in a figure of its own; the user's figure and settings stay theirs.
"""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import bayescal as bc

ONE = ("joint", "residuals", "other", "image", "qq", "curve", "autocorrelation")
SEVERAL = ("trace", "verdict", "evidence")
WITHOUT_AXIS = ("joint", "verdict")


@pytest.fixture(scope="module")
def found():
    return bc.compare(bc.thesis(), [1, 2], hint=False, ess=100)


def numbers(ax: Axes) -> list[np.ndarray]:
    return [np.asarray(line.get_xydata()) for line in ax.lines] + [
        np.asarray(c.get_offsets()) for c in ax.collections
    ]


@pytest.mark.parametrize("kind", ONE)
def test_one_panel_is_drawn_where_it_is_asked_for(found, kind):
    axis = None if kind in WITHOUT_AXIS else "r"
    own = bc.plot(found, kind, axis=axis)
    theirs = Figure(figsize=(3, 5))
    left, right = theirs.subplots(1, 2)
    with mpl.rc_context({"font.size": 13}):
        assert bc.plot(found, kind, axis=axis, ax=right) is theirs
    assert not left.has_data()
    assert theirs.get_size_inches().tolist() == [3, 5]
    made = numbers(right)
    assert len(made) > 0
    for one, other in zip(numbers(own.axes[0]), made, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("kind", SEVERAL)
def test_several_panels_are_refused(found, kind):
    ax = Figure().subplots()
    axis = None if kind in WITHOUT_AXIS else "r"
    with pytest.raises(bc.InputError, match="several panels can't be drawn in one; leave out ax"):
        bc.plot(found, kind, axis=axis, ax=ax)
    assert not ax.has_data()
    bc.plot(found, kind, axis=axis)  # negative control; what was given is forgotten


def test_what_is_no_axes_is_refused(found):
    with pytest.raises(bc.InputError, match="ax must be axes of matplotlib, not a Figure"):
        bc.plot(found, "curve", axis="r", ax=Figure())


def test_a_figure_within_a_figure(found):
    theirs = Figure()
    within = theirs.subfigures(1, 2)[0].subplots()
    assert bc.plot(found, "residuals", axis="r", ax=within) is theirs
