"""What the user decides beside the data."""

from __future__ import annotations

import dataclasses
import numbers
import operator
from collections.abc import Iterable

from bayescal.errors import InputError
from bayescal.noise.choice import NoiseChoice
from bayescal.noise.model import NoiseModel
from bayescal.points.setup import LARGEST_PX
from bayescal.polynomials.axis_data import AxisData

DEFAULT_ORDERS = range(1, 6)
DEFAULT_ESS = 4000
HIGHEST_ORDER = 20
SIGMA_WORDS = ("inferred", "replicates", "scale")


@dataclasses.dataclass(frozen=True)
class Settings:
    """What the user decides beside the data. The public functions take these as keywords.

    Attributes
    ----------
    sigma : float or str, optional
        Noise level: a known number of px; ``"inferred"``; ``"replicates"``: from their
        spread; ``"scale"``: the points' own deviations times an inferred factor. By
        default the points' own deviations where they have them, else inferred.
    prior : str, optional
        ``"field"``, ``"flat"`` or ``"stated"``; by default the setup's own where it
        states one, else field.
    tau : float, optional
        Fixes the strength of the non-linearity of the field prior, as a fraction of the
        image; by default it is inferred.
    seed : int, optional
        Seed of the random numbers.
    ess : int, optional
        Effective samples wanted of every parameter.
    defend : bool, optional
        Also answer a referee: leave-one-out, sensitivity to the prior, stability under
        removal and resampling of points, orders beyond the range (some ten seconds more).
    noise : str, optional
        ``"gaussian"``, ``"student-t"`` (heavy tails) or ``"outlier-mixture"`` (good and
        bad points); the latter two are sampled without a closed form, which takes longer.
    nu : float, optional
        Fixes the degrees of freedom of Student-t noise; by default they are inferred.
    bad_offset : bool, optional
        Infer an offset of the mixture's bad points; by default it is zero.
    tolerance : float, optional
        Difference of predictions that does not matter, px: an order suffices where those that
        can't be excluded stay within it. By default a quarter of the noise level.

    Raises
    ------
    InputError
        Where a setting is not usable.
    """

    sigma: float | str | None = None
    prior: str | None = None
    tau: float | None = None
    seed: int = 0
    ess: int = DEFAULT_ESS
    defend: bool = False
    noise: str = "gaussian"
    nu: float | None = None
    bad_offset: bool = False
    tolerance: float | None = None

    def __post_init__(self) -> None:
        # Plain numbers, whatever numpy's or int they come as: a run writes them down.
        for name in ("sigma", "tau", "nu", "tolerance"):
            if isinstance(value := getattr(self, name), numbers.Real):
                object.__setattr__(self, name, float(value))
        for name in ("seed", "ess"):
            if isinstance(value := getattr(self, name), numbers.Integral):
                object.__setattr__(self, name, int(value))
        if isinstance(self.sigma, str) and self.sigma not in SIGMA_WORDS:
            raise InputError(
                f"sigma must be {', '.join(SIGMA_WORDS)} or a number of px, not {self.sigma!r}"
            )
        if not 100 <= self.ess <= 1_000_000:
            raise InputError(f"ess must be from 100 to 1000000, not {self.ess}")
        if self.tolerance is not None and not 0 < self.tolerance < LARGEST_PX:
            raise InputError(f"tolerance must be a positive number of px, not {self.tolerance:g}")
        if self.seed < 0:
            raise InputError(f"seed must not be negative, but is {self.seed}")
        if self.choice.robust and self.prior == "flat":
            raise InputError(
                f"{self.noise} noise needs a proper prior, under which an evidence exists; take "
                "the prior field or state one"
            )

    @property
    def choice(self) -> NoiseChoice:
        """The noise model wanted, with its options."""
        return NoiseChoice(self.noise, self.nu, self.bad_offset)

    def noise_model(self, data: AxisData) -> NoiseModel:
        """Make the noise model of an axis."""
        return self.choice.model(data.pixel)


def checked_orders(orders: Iterable[int], lowest: int = 1) -> tuple[int, ...]:
    """Sort the orders wanted and refuse those out of range.

    Raises
    ------
    InputError
        Where there is none, or one is no whole number from `lowest` to 20.
    """
    try:
        wanted = tuple(sorted({operator.index(k) for k in orders}))
    except TypeError:
        raise InputError(
            f"orders must be whole numbers, such as [1, 2, 3] or range(1, 6), not {orders!r:.60}"
        ) from None
    if not wanted:
        raise InputError("no order is given; give at least one, such as 1-5")
    if wanted[0] < lowest or wanted[-1] > HIGHEST_ORDER:
        bad = wanted[0] if wanted[0] < lowest else wanted[-1]
        raise InputError(f"order {bad} is out of range; orders go from {lowest} to {HIGHEST_ORDER}")
    return wanted
