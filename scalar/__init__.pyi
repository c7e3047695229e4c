from .data.dataset import Dataset, read_dataset
from .data.declared import PlaneGuess, Sensor
from .diagnosis.diagnose import diagnose
from .diagnosis.result import Diagnosis
from .effects.effect import Effect
from .errors import InvalidInput, ScalarError, Undetermined
from .estimation.calibrate import calibrate
from .estimation.result import Calibration
from .geometry.robot import Robot
from .ingest.urdf.to_robot import read_robot
from .sensors.protocol import Measurement

__all__ = [
    "Calibration",
    "Dataset",
    "Diagnosis",
    "Effect",
    "InvalidInput",
    "Measurement",
    "PlaneGuess",
    "Robot",
    "ScalarError",
    "Sensor",
    "Undetermined",
    "calibrate",
    "diagnose",
    "read_dataset",
    "read_robot",
]
__version__: str
