"""What the title block of a report says of a calibration."""

from __future__ import annotations

from dataclasses import dataclass, fields

from bayescal.errors import InputError

LONGEST = 200  # characters; a title block is read at a glance


@dataclass(frozen=True)
class Heading:
    """What whoever calibrates says of it; empty: nothing.

    Attributes
    ----------
    title : str
        In place of the page's own.
    camera, serial : str
        Which camera was calibrated, and its serial number.
    operator : str
        Who calibrated it.
    """

    title: str = ""
    camera: str = ""
    serial: str = ""
    operator: str = ""

    def __post_init__(self) -> None:
        for name, text in self.facts.items():
            if not isinstance(text, str | None):
                raise InputError(f"{name} must be text in quotes")
            if text is not None and not (text.isprintable() and len(text) <= LONGEST):
                raise InputError(
                    f"{name} must be one line of at most {LONGEST} printable characters"
                )

    @property
    def facts(self) -> dict[str, str | None]:
        """Entries by name; None where there is nothing."""
        return {one.name: getattr(self, one.name) or None for one in fields(self)}

    def over(self, other: Heading) -> Heading:
        """Give what this one says and, where it is silent, the other."""
        return Heading(**{name: text or getattr(other, name) for name, text in self.facts.items()})


SILENT = Heading()
