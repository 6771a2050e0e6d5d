"""What is asked for of lens models."""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.errors import InputError

GAUSSIAN, MIXTURE = NOISES = ("gaussian", "outlier-mixture")


def checked_noise(name: str) -> str:
    """Refuse noise that views can't have.

    Raises
    ------
    InputError
    """
    if name == "student-t":
        raise InputError(
            "student-t noise is not offered for views, whose neighbouring points share errors; "
            "for gross errors take --noise outlier-mixture"
        )
    if name not in NOISES:
        raise InputError(f"noise must be {' or '.join(NOISES)}, not {name!r}")
    return name


@dataclass(frozen=True)
class LensRequest:
    """Which lens models are compared, and what else is held.

    Attributes
    ----------
    lenses : tuple of str or None
        As the user names them; None to have them found.
    independent : bool
        Whether noise is taken as independent and the target as exact.
    square, centred : bool
        Whether fx = fy; whether the principal point stays in the middle.
    draws : int
        Importance draws of each lens.
    per_view : bool
        Whether each view has a noise level of its own, settled before a lens is judged.
    noise : str
        ``"gaussian"``, or ``"outlier-mixture"``: each point may also be bad, and anywhere in the
        image.
    """

    lenses: tuple[str, ...] | None = None
    independent: bool = False
    square: bool = False
    centred: bool = False
    draws: int = 2000
    per_view: bool = False
    noise: str = GAUSSIAN

    @property
    def mixture(self) -> bool:
        """Whether points may be bad."""
        return self.noise == MIXTURE
