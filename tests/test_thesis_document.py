"""docs/thesis.md quotes what the program prints and the numbers it computes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.report.render import render
from bayescal.report.reproduction import reproduction_view

TEXT = (Path(__file__).parents[1] / "docs" / "thesis.md").read_text(encoding="utf-8")
PROSE = " ".join(TEXT.split())


@pytest.fixture(scope="module")
def found():
    return bc.reproduce(bc.thesis(), common=True)


def test_what_is_printed_is_quoted_as_it_is():
    assert render(reproduction_view(bc.reproduce(bc.thesis())), terminal=False).rstrip() in TEXT


def test_errors_at_points_left_out(found):
    written, coded, c = found["as-written"]["r"], found["as-coded"]["r"], found["as-written"]["c"]

    def left_out(order) -> str:
        return f"{order.before.fit.rms_left_out:.2f}"

    assert f"from {left_out(written[4])} to {left_out(written[5])} px" in PROSE
    assert f"{', '.join(map(left_out, c.orders))} px" in PROSE
    assert f"{left_out(coded[2])} px at points left out become {left_out(coded[5])}" in PROSE


def test_shares_taken_and_shares_by_chance(found):
    for variant, axis, order, words in (
        ("as-written", "r", 4, "takes another {} % off RSS, where a column of noise takes {} %"),
        ("as-written", "c", 1, "take {} % off RSS, and four columns of noise take {} %"),
        ("as-coded", "r", 2, "{} % for three columns, {} % by chance"),
    ):
        gain, by_chance = found[variant][axis].gain_beyond(order)
        assert words.format(f"{100 * gain:.1f}", f"{100 * by_chance:.1f}") in PROSE


def test_what_elimination_does_to_all_points_and_to_the_choice(found):
    written = found["as-written"]["r"]

    def on_all(order) -> str:
        return f"{np.sqrt(order.after.squared_errors.mean()):.2f}"

    one, four = written[1], written[4]
    assert f"r of order 1 from {one.before.rms:.2f} to {on_all(one)} px" in PROSE
    assert f"of order 4 from {four.before.rms:.2f} to {on_all(four)}" in PROSE
    assert f"RMS falls from {one.before.rms:.2f} to {one.after.rms:.2f} px" in PROSE
    assert f"({one.common.bic:.1f}, against {four.common.bic:.1f} at order 4)" in PROSE
    counts = ", ".join(str(len(order.after.kept)) for order in written.orders)
    assert f"({counts})" in PROSE
    x, _, z = bc.thesis().camera_frame().T
    far = [abs(x[p] / z[p]) >= 0.4 for p in one.rejection.removed]
    assert (sum(far), len(far)) == (5, 6)


def test_points_16_and_19_err_alike_in_c_alone(found):
    suspects = [15, 18]
    world = bc.thesis().world[suspects]
    assert np.array_equal(world[0, 1:], world[1, 1:])
    c, r = found["as-written"]["c"][1].before, found["as-written"]["r"][4].before
    assert "by {:.1f} and {:.1f} px in c".format(*c.residuals[suspects]) in PROSE
    assert (np.abs(r.residuals[suspects]) < 1.5 * r.rms).all()


def test_probabilities_are_those_of_compare(thesis_comparison):
    r, c = thesis_comparison.axes["r"], thesis_comparison.axes["c"]
    assert f"order 4 of r with probability {r[4].probability:.2f}" in PROSE
    assert f"(order 5: {r[5].probability:.2f})" in PROSE
    assert f"order 1 of c with {c[1].probability:.2f}" in PROSE


def test_neighbouring_residuals_of_r_are_alike(found):
    """Correlation of successive residuals beyond 2 standard errors of independent ones."""
    e = found["as-written"]["r"][4].before.residuals
    assert e[1:] @ e[:-1] / (e @ e) > 2 / np.sqrt(57)
