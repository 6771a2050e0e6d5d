"""Is the recommended order adequate: what the residuals say against the model."""

from bayescal.comparison.adequacy.block import adequacy
from bayescal.comparison.adequacy.outcome import AdequacyTest, concerns
from bayescal.comparison.adequacy.replicates import pure_error

__all__ = ["AdequacyTest", "adequacy", "concerns", "pure_error"]
