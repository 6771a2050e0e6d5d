"""What is asked for of bad points."""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT


@dataclass(frozen=True)
class OutlierRequest:
    """Which axes, orders and treatments of bad points.

    Attributes
    ----------
    axes : tuple of str
    orders : tuple of int
        Ascending.
    noises : tuple of StudentT, OutlierMixture
        The noise models that know bad points.
    rejection : RejectionRule
        Of the chi-squared elimination.
    """

    axes: tuple[str, ...]
    orders: tuple[int, ...]
    noises: tuple[StudentT, OutlierMixture]
    rejection: RejectionRule
