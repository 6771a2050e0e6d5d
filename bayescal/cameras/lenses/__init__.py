"""The lens models by the names users know them by; a new lens is one file and one line here."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from typing import Any

from bayescal.cameras.lenses.division import Division
from bayescal.cameras.lenses.double_sphere import DoubleSphere
from bayescal.cameras.lenses.eucm import Eucm
from bayescal.cameras.lenses.fisheye import Fisheye
from bayescal.cameras.lenses.lens import Derivatives, Lens, Undistorted
from bayescal.cameras.lenses.radial import radial
from bayescal.cameras.lenses.rational import rational
from bayescal.cameras.lenses.thin_prism import thin_prism
from bayescal.errors import InputError

__all__ = ["LENSES", "Derivatives", "Lens", "Undistorted", "lens_named"]

LENSES: dict[str, Callable[..., Lens]] = {
    "radial": radial,
    "opencv4": partial(radial, order=2, tangential=True),
    "opencv5": partial(radial, order=3, tangential=True),
    "rational": rational,
    "opencv8": partial(rational, order=3, tangential=True),
    "thin-prism": thin_prism,
    "opencv12": partial(thin_prism, order=3, tangential=True, rational=True),
    "fisheye": Fisheye,
    "division": Division,
    "eucm": Eucm,
    "double-sphere": DoubleSphere,
}


def lens_named(name: str, **options: Any) -> Lens:
    """Lens of a name, such as ``lens_named("radial", order=2, tangential=False)``.

    Raises
    ------
    InputError
        Where there is no such lens, or it has no such option or order.
    """
    if name not in LENSES:
        raise InputError(f"no lens is called {name}: use one of {', '.join(LENSES)}")
    made = LENSES[name]
    free = () if isinstance(made, partial) else tuple(inspect.signature(made).parameters)
    if unknown := [option for option in options if option not in free]:
        known = f"it has {', '.join(free)}" if free else "it has none"
        raise InputError(f"lens {name} has no option {unknown[0]}: {known}")
    return made(**options)
