"""The thesis's two variants against an independent evaluation of its listing."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.linear.design_fit import fit_design
from bayescal.polynomials.separable import axis_data
from bayescal.reproduction.models import AS_CODED, AS_WRITTEN, ThesisModel
from tests.helpers.listing import MODELS, ORDERS, columns, exact_listing, listing


def fitted(variant: str, axis: str, order: int):
    points = bc.thesis()
    w, u = axis_data(points, "r").x, axis_data(points, "c").x
    return fit_design(ThesisModel(variant, axis, order).design(w, u), points.pixel(axis))


@pytest.mark.parametrize(("variant", "axis", "order"), MODELS)
def test_every_residual_is_the_listings_to_a_billionth_of_a_pixel(variant, axis, order):
    _, truth = listing(variant, axis, order)
    assert np.abs(fitted(variant, axis, order).residuals - truth).max() < 1e-9


@pytest.mark.parametrize(("variant", "axis", "order"), MODELS)
def test_residuals_and_coefficients_are_the_rational_ones(variant, axis, order):
    """Backward stable: 1e4 roundings of the largest pixel, and cond(X) < 100 times that."""
    coefficients, residuals = exact_listing(variant, axis, order)
    found = fitted(variant, axis, order)
    assert np.abs(found.residuals - np.array(residuals, dtype=float)).max() < 1e4 * 2e-16 * 1626
    truth = np.array(coefficients, dtype=float)
    assert np.abs(found.coefficients / truth - 1).max() < 1e-11


def test_the_listings_own_arithmetic_costs_it_digits_that_the_factorisation_keeps():
    """Negative control of the tolerance: inv(X'X) loses digits of c's coefficients at order 5."""
    truth = np.array(exact_listing("as-coded", "c", 5)[0], dtype=float)
    by_listing = np.abs(listing("as-coded", "c", 5)[0] / truth - 1).max()
    by_factorisation = np.abs(fitted("as-coded", "c", 5).coefficients / truth - 1).max()
    assert by_factorisation < by_listing / 10


@pytest.mark.parametrize(("axis", "normal", "scaled"), [("r", 1.2e5, 24), ("c", 2.7e9, 52)])
def test_condition_numbers_that_the_documents_state(axis, normal, scaled):
    points = bc.thesis()
    w, u = axis_data(points, "r").x, axis_data(points, "c").x
    design = ThesisModel(AS_WRITTEN, axis, 5).design(w, u)
    assert np.linalg.cond(design.T @ design) == pytest.approx(normal, rel=0.05)
    by_norm = design / np.linalg.norm(design, axis=0)
    assert np.linalg.cond(by_norm) == pytest.approx(scaled, rel=0.05)


@pytest.mark.parametrize("order", [*ORDERS, 8])
def test_the_slip_is_in_the_third_and_higher_powers_of_r_alone(order):
    rng = np.random.default_rng(order)
    w, u = rng.uniform(-1, 1, (2, 10))

    def design(variant: str, axis: str) -> np.ndarray:
        return ThesisModel(variant, axis, order).design(w, u)

    assert np.array_equal(design(AS_CODED, "c"), design(AS_WRITTEN, "c"))
    same = design(AS_CODED, "r") == design(AS_WRITTEN, "r")
    assert same.all(axis=0).tolist() == [power < 3 for power in range(order + 1)]
    assert ThesisModel(AS_CODED, "r", order).slipped == (order >= 3)
    assert not ThesisModel(AS_CODED, "c", order).slipped
    assert not ThesisModel(AS_WRITTEN, "r", order).slipped


def test_columns_and_coefficients_are_named():
    coded = ThesisModel(AS_CODED, "r", 4)
    assert coded.monomials == ("1", "x/z", "(x/z)^2", "(y/z)^3", "(y/z)^4")
    assert coded.coefficients == ("alpha_0", "alpha_1", "alpha_2", "alpha_3", "alpha_4")
    assert ThesisModel(AS_WRITTEN, "r", 3).monomials == ("1", "x/z", "(x/z)^2", "(x/z)^3")
    assert ThesisModel(AS_WRITTEN, "c", 2).monomials == ("1", "y/z", "(y/z)^2")
    assert ThesisModel(AS_WRITTEN, "c", 1).coefficients == ("beta_0", "beta_1")


@pytest.mark.parametrize(
    ("variant", "axis", "order", "named"),
    [("as-is", "r", 1, "as-is"), (AS_CODED, "z", 1, "z"), (AS_CODED, "r", 0, "0")],
)
def test_what_the_thesis_does_not_have_is_refused(variant, axis, order, named):
    with pytest.raises(bc.InputError, match=named):
        ThesisModel(variant, axis, order)


def test_equation_53_taken_literally_is_no_model_of_c():
    """Its x/z in place of y/z and its repeated cube: the numbers docs/thesis.md gives."""
    points = bc.thesis()
    x, y, z = points.camera_frame().T
    w, t = x / z, points.pixel("c")
    u = np.column_stack(columns(AS_WRITTEN, "c", 5, x, y, z))
    literal = {
        3: [u[:, 0], w, u[:, 2], u[:, 3]],
        4: [u[:, 0], w, u[:, 2], u[:, 3], u[:, 3]],
        5: [u[:, 0], w, u[:, 2], u[:, 3], u[:, 4], u[:, 5]],
    }
    rss, rank = {}, {}
    for order, parts in literal.items():
        design = np.column_stack(parts)
        solution, _, rank[order], _ = np.linalg.lstsq(design, t, rcond=None)
        rss[order] = float(((t - design @ solution) ** 2).sum())
    assert rank == {3: 4, 4: 4, 5: 6}
    assert [round(v) for v in rss.values()] == [178563, 178563, 67293]
    with pytest.raises(bc.InputError, match="4 of 5 coefficients"):
        fit_design(np.column_stack(literal[4]), t)
