"""The noise models that can be asked for: one line each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bayescal.errors import InputError
from bayescal.noise.gaussian import Gaussian
from bayescal.noise.model import NoiseModel
from bayescal.noise.outlier_mixture import WIDTH_BOUNDS, OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.noise.world_errors import WorldErrors


@dataclass(frozen=True)
class NoiseChoice:
    """Which noise model the user wants, with its options.

    Attributes
    ----------
    nu : float or None
        Fixes the degrees of freedom of Student-t noise; None: inferred.
    bad_offset : bool
        Whether the mixture's bad points have an offset, inferred; else it is zero.
    """

    name: str = "gaussian"
    nu: float | None = None
    bad_offset: bool = False

    def __post_init__(self) -> None:
        if self.name not in NOISE_MODELS:
            raise InputError(f"noise must be {', '.join(NOISE_MODELS)}, not {self.name!r}")
        if self.nu is not None and self.name != "student-t":
            raise InputError(f"nu belongs to student-t noise; the noise here is {self.name}")
        if self.bad_offset and self.name != "outlier-mixture":
            raise InputError(
                f"a bad offset belongs to outlier-mixture noise; the noise here is {self.name}"
            )
        self.model(1.0)  # refuse options that the model can't have

    @property
    def robust(self) -> bool:
        """Whether there is no closed form, so that the evidence is sampled."""
        return self.name != "gaussian"

    def model(self, pixel: float) -> NoiseModel:
        """Make the noise model.

        Parameters
        ----------
        pixel : float
            What stands for a pixel (`bayescal.points.pixel`).
        """
        return NOISE_MODELS[self.name](self, pixel)


NOISE_MODELS: dict[str, Callable[[NoiseChoice, float], NoiseModel]] = {
    "gaussian": lambda _choice, _pixel: Gaussian(),
    "student-t": lambda choice, _pixel: StudentT(choice.nu),
    "outlier-mixture": lambda choice, pixel: OutlierMixture(
        (WIDTH_BOUNDS[0] * pixel, WIDTH_BOUNDS[1] * pixel), choice.bad_offset
    ),
}

# Their names as they stand in a sentence.
NOISE_WORDS = {
    "gaussian": "Gaussian",
    "student-t": "Student-t",
    "outlier-mixture": "mixture",
    WorldErrors.name: "Gaussian, with errors of the world,",
}
