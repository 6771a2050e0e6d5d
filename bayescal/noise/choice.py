"""The noise models that can be asked for."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module

from bayescal.errors import InputError
from bayescal.noise import NAMES
from bayescal.noise.model import NoiseModel
from bayescal.noise.world_errors import WorldErrors

NOISE_MODELS: dict[str, type[NoiseModel]] = {
    name: import_module(f"bayescal.noise.{name.replace('-', '_')}").NOISE for name in NAMES
}

# Their names as they stand in a sentence.
NOISE_WORDS = {
    **{name: made.words for name, made in NOISE_MODELS.items()},
    WorldErrors.name: WorldErrors.words,
}


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
        return not NOISE_MODELS[self.name].conjugate

    def model(self, pixel: float) -> NoiseModel:
        """Make the noise model.

        Parameters
        ----------
        pixel : float
            What stands for a pixel (`bayescal.points.pixel`).
        """
        made = NOISE_MODELS[self.name]
        return made.of(pixel, **{option: getattr(self, option) for option in made.options})
