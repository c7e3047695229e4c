"""Find the effects that a rigid model lacks: clean the data, score candidates on the residual, add the best, refit, test held-out poses, repeat."""

from scalar.diagnosis.diagnose import diagnose
from scalar.diagnosis.result import Diagnosis

__all__ = ["Diagnosis", "diagnose"]
