"""The errors a caller can cause, each with one line that says what to do."""

from __future__ import annotations


class BayescalError(Exception):
    """Base of every error that bayescal raises on purpose."""


class InputError(BayescalError, ValueError):
    """Data, a setup or an option that can't be used.

    The message is one line: where, what is wrong, what to do.
    """


class OutputError(BayescalError, OSError):
    """A result that can't be written where it was asked for."""
