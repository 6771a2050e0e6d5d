"""What a defence found: the answers to a referee, on one axis."""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.comparison.criteria.leave_one_out import LeaveOneOut, TotalLeaveOneOut
from bayescal.comparison.defence.sensitivity import TauSensitivity
from bayescal.comparison.defence.stability import Bootstrap, Removal
from bayescal.comparison.judged import Weighed
from bayescal.comparison.orders.beyond import Beyond


@dataclass(frozen=True, eq=False)
class Prediction:
    """Leave-one-out of one order, beside that of the others.

    Attributes
    ----------
    loo : LeaveOneOut or TotalLeaveOneOut
        Exact where there is a closed form, else from the draws.
    difference, difference_se : float
        elpd less the best order's, and its paired standard error.
    group_elpd : float or None
        Sum of ln p(group | all other points); None where there are no groups.
    psis : LeaveOneOut or None
        From the draws (Pareto-smoothed importance sampling); None where the data are too many
        for it, or the draws can't tell of a point.
    influential : tuple of str
        Labels of the points whose Pareto k is not good, the worst first.
    """

    loo: LeaveOneOut | TotalLeaveOneOut
    difference: float
    difference_se: float
    group_elpd: float | None
    psis: LeaveOneOut | None
    influential: tuple[str, ...] = ()


@dataclass(frozen=True)
class Worth:
    """How far another order's prediction is from the recommended one's.

    Attributes
    ----------
    largest : float
        Largest difference over the domain, px.
    sd : float
        Posterior sd of the larger order's prediction there, px.
    at : float
        Regressor where it is.
    """

    order: int
    largest: float
    sd: float
    at: float


@dataclass(frozen=True, eq=False)
class Defence:
    """Answers to a referee, on one axis.

    Attributes
    ----------
    prediction : dict of int to Prediction
        By order; empty where leave-one-out does not exist.
    tau : TauSensitivity or None
        None where the prior has no tau.
    group_source : str or None
        What makes a group: ``"column group"`` or ``"plane z"``.
    points_that_matter, groups_that_matter : tuple of Removal
        Whose removal changes the winner; of many points the strongest.
    further_points : int
        How many points more there are whose removal does.
    resampled : tuple of Bootstrap
        By point and, where there are groups, by group.
    worth : tuple of Worth
        Of every other plausible order.
    noises : tuple of Weighed
        The recommended order under the other noise models.
    """

    prediction: dict[int, Prediction]
    tau: TauSensitivity | None = None
    group_source: str | None = None
    points_that_matter: tuple[Removal, ...] = ()
    groups_that_matter: tuple[Removal, ...] = ()
    resampled: tuple[Bootstrap, ...] = ()
    beyond: Beyond | None = None
    worth: tuple[Worth, ...] = ()
    noises: tuple[Weighed, ...] = ()
    further_points: int = 0
