"""docs/thesis.md quotes what the program prints and the numbers it computes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.outliers.results import AxisOutliers
from bayescal.report.terminal import render
from bayescal.reproduction.tables import reproduction_view

TEXT = (Path(__file__).parents[2] / "docs" / "thesis.md").read_text(encoding="utf-8")
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


@pytest.mark.parametrize(("axis", "order"), [("r", 4), ("c", 1)])
def test_what_each_noise_model_says_of_the_points_worth_naming(axis, order):
    found = bc.outliers(bc.thesis(), [order], axis=axis).axes[axis]
    rows = [line.strip("| ").split(" | ") for line in TEXT.splitlines()]
    quoted = {row[1]: row[2:] for row in rows if row[0] == f"{axis}, {order}"}
    assert {p.label for p in found.suspicious} < set(quoted)
    named = {p.label: p for p in found.points if p.label in quoted}
    assert set(named) == set(quoted)
    for label, (residual, standard, test, weight, chance, measured, predicted) in quoted.items():
        point = named[label]
        assert (residual, standard) == (f"{point.residual:+.1f}", f"{point.standardised:+.1f}")
        assert test == ("removes it" if order in point.rejected_at else "keeps it")
        assert float(measured) == point.measured
        # Means of 1000 effective draws of numbers from 0 to 1: se below 0.016, rounded to 0.01.
        assert float(weight) == pytest.approx(point.weight, abs=0.07)
        assert float(chance) == pytest.approx(point.bad_probability, abs=0.07)
        mean, sd = map(float, predicted.split(" ± "))
        assert mean == pytest.approx(point.predicted, abs=0.2 * point.predicted_sd)
        assert sd == pytest.approx(point.predicted_sd, rel=0.2)
    _check_order_of_rows(found, list(quoted))
    _check_evidences(found, axis, order)


def _check_evidences(found: AxisOutliers, axis: str, order: int) -> None:
    """The table's column of this order, rounded to 0.1; sampled evidences spread by 0.01 nat."""
    column = 1 + "rc".index(axis) * 5 + order - 1
    names = {"gaussian": "Gaussian", "student-t": "Student-t", "outlier-mixture": "outlier mixture"}
    table = {
        cells[0]: cells for line in TEXT.splitlines() if (cells := line.strip("| ").split(" | "))
    }
    compared = {t.noise: t for t in found.treatments if t.n_points == len(found.data)}
    assert set(compared) == set(names)
    for noise, name in names.items():
        quoted = float(table[name][column].strip("*"))
        assert quoted == pytest.approx(compared[noise].log_evidence[order], abs=0.05 + 0.04)


def _check_order_of_rows(found: AxisOutliers, labels: list[str]) -> None:
    """The table names the most suspicious points, none left out between them."""
    chances = {p.label: p.bad_probability for p in found.points}
    least = min(chances[label] for label in labels)
    assert all(chances[p] < least + 0.07 for p in chances if p not in labels)
