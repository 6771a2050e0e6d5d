"""Numbers as people should read them: no digit that the uncertainty denies."""

from __future__ import annotations

import math

SMALL = 1e-4  # below it a value may be shown with an exponent


def decimals_for(uncertainty: float, digits: int = 2) -> int:
    """Decimal places that show an uncertainty with so many significant digits.

    At most two are useful in an uncertainty (JCGM 100:2008, 7.2.6). Negative where
    the last of them stands left of the decimal point.
    """
    if not (uncertainty > 0 and math.isfinite(uncertainty)):
        return 3
    return digits - 1 - math.floor(math.log10(float(f"{uncertainty:.{digits - 1}e}")))


def rounded(value: float, uncertainty: float) -> str:
    """Format a value to the decimal place of its two-digit uncertainty, at most the eighth.

    A value that so many decimals would lose has an exponent instead.
    """
    places = decimals_for(uncertainty)
    if places > 8 and 0 < abs(value) < SMALL:
        return f"{value:.{max(places + math.floor(math.log10(abs(value))), 0)}e}"
    return _fixed(value, min(places, 8)) if places >= -6 else f"{value:.4g}"


def significant(value: float, digits: int = 2) -> str:
    """Format a positive number with so many significant digits, without an exponent."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    places = decimals_for(abs(value), digits)
    return _fixed(value, places) if -6 <= places <= 8 else f"{value:.{digits - 1}e}"


def _fixed(value: float, places: int) -> str:
    """Round to a decimal place, which may stand left of the point; never a minus zero."""
    return f"{round(value, places) + 0.0:.{max(places, 0)}f}"


def plain(value: float, places: int = 1) -> str:
    """Format a number in at most seven characters and a sign, with decimals while they fit."""
    size = abs(value)
    if size >= 1e6 or (0 < size < 10**-places):
        return f"{value:.1e}"
    return f"{value:.{places if size < 1e4 else 0}f}"


def grouped(number: int) -> str:
    """Write a whole number, its thousands apart where it has more than four digits."""
    return f"{number:,}" if abs(number) >= 10_000 else f"{number}"


def counted(number: int, noun: str) -> str:
    """Write a number of things, such as ``"1 point"`` and ``"2 points"``."""
    return f"{grouped(number)} {noun}" if number == 1 else f"{grouped(number)} {noun}s"


def percent(probability: float) -> str:
    """Write a probability in per cent, with the digits that matter near 0 and 1."""
    value = 100 * probability
    if value > 99.95:
        return ">99.9%"
    if value < 0.05:
        return "<0.1%"
    return f"{value:.1f}%" if value < 10 or value > 90 else f"{value:.0f}%"
