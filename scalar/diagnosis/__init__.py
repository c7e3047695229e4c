"""From residual to the effect that the model lacks: clean, score, add, refit, judge on held-out poses, repeat."""

from scalar.diagnosis.diagnose import diagnose
from scalar.diagnosis.result import Diagnosis

__all__ = ["Diagnosis", "diagnose"]
