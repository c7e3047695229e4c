"""Physical causes of errors for which the estimator has no effect and hence no name: one file for each place where they act.

In a config they are kinds of the effect `unknown`. So are the shapes of `injected.unknown`, which are more like the flexible terms that an
estimator tries.
"""

from scalar.simulation.injected.causes.base import Cause
from scalar.simulation.injected.causes.climate import AirConditioning, SawtoothGrowth
from scalar.simulation.injected.causes.drives import EncoderInterpolation, TwoPulleyBelt, TwoSlopeGear
from scalar.simulation.injected.causes.floor import GivingFloor
from scalar.simulation.injected.causes.hose import Hose
from scalar.simulation.injected.causes.mount import LooseMount, WanderingLaser
from scalar.simulation.injected.causes.moves import LateTrigger, Vibration
from scalar.simulation.injected.causes.spring import ForearmSpring

CAUSES: dict[str, type[Cause]] = {
    cause.kind: cause
    for cause in (
        AirConditioning,
        EncoderInterpolation,
        ForearmSpring,
        GivingFloor,
        Hose,
        LateTrigger,
        LooseMount,
        SawtoothGrowth,
        TwoPulleyBelt,
        TwoSlopeGear,
        Vibration,
        WanderingLaser,
    )
}
"""By kind, as a config names them."""
