"""A strong effect is not taken for a jitter that no arm has, where several targets on the flange leave little noise between them."""

from study.tracked_trials.design import Trial
from study.tracked_trials.measure import simulated
from study.tracked_trials.workcell import load_workcell

from scalar.diagnosis.diagnose import diagnose

COUPLED = Trial(
    sensor="targets",
    number=49,
    seed=1949871075,
    robot="ur10e",
    share_of_range=0.8185716140399266,
    poses=200,
    unseen=4,
    causes=({"name": "joint_coupling", "target": {"joint": 5, "source": 4}, "size": 1.8642e-3},),
    noise_m=1e-5,
    stated="none",
    turn_noise_rad=5e-5,
    turn_stated="fifth",
    repeatability_rad=1e-5,
    sessions=2,
    records_time=False,
    records_approach=True,
    workcell=load_workcell(),
)
"""A set of the fourth exam of trackers: on one half of its poses the coupling had been weighted away, and its name was given up."""


def test_a_coupling_is_named_though_one_half_of_the_poses_looks_like_jitter():
    """The coupling moves the targets by 0.26 mm, a hundred times as much as the joints scatter."""
    found = diagnose(simulated(COUPLED)[0], cores=1)
    (named,) = [f for f in found.findings if f.has_name]
    assert named.effect.name == "joint_coupling" and named.effect.target == {"joint": 5, "source": 4}
    assert named.confidence > 0.8
    assert found.calibration_after.residual_rms < 0.1 * found.calibration_before.residual_rms
