"""From residual to the effect that the model lacks: clean, score, add, refit, judge on held-out poses, repeat."""

from scalar.diagnosis.diagnose import Diagnosis, diagnose
from scalar.report.output import write_diagnosis

__all__ = ["Diagnosis", "diagnose", "write_diagnosis"]
