"""What a setup states of the camera beyond its position: how sure it is, and its optics."""

from __future__ import annotations

from dataclasses import dataclass, fields

from bayescal.errors import InputError

Triple = tuple[float, float, float]
Pair = tuple[float, float]
# World coordinates and pixels beyond this overflow a double downstream.
LARGEST = 1e100
LARGEST_SD_DEG = 180.0


@dataclass(frozen=True, repr=False)
class StatedCamera:
    """What the setup file says of the camera's pose and optics; None where it is silent.

    Attributes
    ----------
    position_sd : tuple of float or None
        Standard deviations of the camera position, world units.
    orientation : tuple of float or None
        Rotation vector that takes world directions to the camera's frame, degrees.
    orientation_sd : tuple of float or None
        Standard deviations of a small rotation about it, degrees.
    focal : float or None
        Median of the focal length, px.
    focal_log_sd, ratio_log_sd : float or None
        Standard deviations of ln of the focal length, and of ln of c's over r's.
    centre, centre_sd : tuple of float or None
        Principal point u0, v0 and its standard deviations, px.
    """

    position_sd: Triple | None = None
    orientation: Triple | None = None
    orientation_sd: Triple | None = None
    focal: float | None = None
    focal_log_sd: float | None = None
    ratio_log_sd: float | None = None
    centre: Pair | None = None
    centre_sd: Pair | None = None

    def __post_init__(self) -> None:
        for one in fields(self):
            value = getattr(self, one.name)
            values = value if isinstance(value, tuple) else (value,)
            if value is None:
                continue
            free = one.name in ("orientation", "centre")
            if not all(abs(v) < LARGEST and (free or v > 0) for v in values):
                what = "finite" if free else "positive and finite"
                exact = "; --position stated holds the position exactly"
                hint = exact if one.name == "position_sd" else ""
                raise InputError(f"{one.name} must be {what}, not {value}{hint}")
        if self.orientation_sd is not None and max(self.orientation_sd) > LARGEST_SD_DEG:
            raise InputError(f"orientation_sd must be at most {LARGEST_SD_DEG:g} degrees")
        for name in ("focal_log_sd", "ratio_log_sd"):
            if (getattr(self, name) or 0) > 10:
                raise InputError(f"{name} must be at most 10: a factor of e^10 is no knowledge")

    def __repr__(self) -> str:
        stated = ((one.name, getattr(self, one.name)) for one in fields(self))
        return f"StatedCamera({', '.join(f'{n}={v}' for n, v in stated if v is not None)})"


# How many numbers each of them has in a setup file, and where it stands.
CAMERA_KEYS = {"position_sd": 3, "orientation": 3, "orientation_sd": 3}
PINHOLE_KEYS = {"focal": 1, "focal_log_sd": 1, "ratio_log_sd": 1, "centre": 2, "centre_sd": 2}
