"""Thresholds of what a diagnosis reports and ships: each is tested with numbers on both sides of it, so that half or double the threshold changes the
decision.

``snakemake sensitivity`` names these tests for thresholds on which no blind set depends.
"""

import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from scalar.diagnosis.explained import Explained
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.naming import judged_effects
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.noise.identified_components import identified_components
from scalar.diagnosis.result import Diagnosis
from scalar.diagnosis.settings import DEFAULTS
from scalar.diagnosis.shipping import doubtful_effects, focused_choice, shipped_fit
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.diagnosis.stand_ins import scored, state
from tests.effects.injected import make_cell

components = sys.modules["scalar.diagnosis.noise.identified_components"]
NOISES = (("best", 30.0), ("near", 28.0), ("far", 26.0))  # with the log likelihood that each gains
DIAGNOSE = sys.modules["scalar.diagnosis.diagnose"]  # the package's own name for it is the function


@pytest.mark.parametrize(("std", "is_found"), [(14e-6, False), (28e-6, True)])
def test_joints_that_repeat_as_well_as_any_are_no_finding(std, is_found, monkeypatch):
    """A standard deviation of 14 microradians is below that of the best data sheets, and one of 28 is above it; both are significant."""
    dataset = make_cell(seed=1, poses_per_plane=10, points_per_scan=10).dataset
    model, prepared = geometry_fit(dataset)
    found = refit(dataset, model, prepared.free, ())
    jitter = VarianceComponent("pose_jitter", std, 1e-6, 50.0, 1e-12, np.zeros((0, 1, 1)))
    given: Any = SimpleNamespace(
        residuals=found.residuals,
        model=found.model,
        variance_components=[jitter],
        settings=DEFAULTS,
        background_within_scans=lambda: None,
    )
    monkeypatch.setattr(
        components, "fit_components", lambda _, kernels: SimpleNamespace(log_likelihood=50.0 * len(kernels))
    )
    assert bool(identified_components(given)) == is_found


@pytest.mark.parametrize(("share", "left_out"), [(0.9, True), (0.96, False)])
def test_effects_are_left_out_only_if_the_error_is_clearly_smaller(share, left_out, monkeypatch):
    """An expected error of 90 % without one of two effects is clearly smaller, and one of 96 % is not."""
    errors = {(0, 1): (1.0, 1.0, 1.0), (0,): (share, 1.0, 1.0)}
    assert bool(chosen(monkeypatch, errors).left_out) == left_out


@pytest.mark.parametrize(("share", "shipped"), [(0.6, 2), (0.8, 0)])
def test_what_leaves_most_of_the_error_is_not_corrected(share, shipped, monkeypatch):
    """A correction that leaves 60 % of the expected error is made, and one that leaves 80 % is not."""
    errors = {(0, 1): (share, share, share), (): (1.0, 1.0, 1.0)}
    assert len(chosen(monkeypatch, errors).left_out) == 2 - shipped


@pytest.mark.parametrize(
    ("share", "approximate", "beside_arm", "shipped"),
    [(0.1, True, False, 2), (0.3, True, False, 0), (0.3, False, False, 2), (0.3, True, True, 2)],
)
def test_a_map_and_its_remainder_are_corrected_only_where_much_is_expected(
    share, approximate, beside_arm, shipped, monkeypatch
):
    """A correction of two errors of the instrument, one of any smooth form, is made if it leaves a tenth of the expected error, and not if it leaves
    30 %; with an effect of the arm, or with two errors of known form, it is."""
    errors = {(0, 1): (share, share, share), (): (1.0, 1.0, 1.0)}
    kind = {"of_instrument": True, "any_smooth_form": approximate, "acts_on_arm": beside_arm}
    assert len(chosen(monkeypatch, errors, kind=kind).left_out) == 2 - shipped


def test_a_choice_that_becomes_implausible_is_not_made(monkeypatch):
    """Where the model with fewer effects ends with implausible coefficients, all that were found are kept."""
    errors = {(0, 1): (1.0, 1.0, 1.0), (0,): (0.5, 1.0, 1.0)}
    assert chosen(monkeypatch, errors).left_out and not chosen(monkeypatch, errors, plausible=False).left_out


@pytest.mark.parametrize(
    ("left", "all_of_it", "in_time", "kept"),
    [
        (0.4, 9.0, True, 2),
        (0.6, 9.0, True, 1),
        (0.6, 0.2, True, 2),
        (0.6, 9.0, False, 2),
        (0.8, 9.0, False, 1),
    ],
)
def test_a_doubtful_effect_is_corrected_only_where_much_is_expected_of_it(
    left, all_of_it, in_time, kept, monkeypatch
):
    """A doubtful change in time beside a sure effect is corrected if it leaves 40 % of the error, and not if it leaves 60 %; another one with 60 %.

    It is corrected as well if both leave a fifth of the error without effects. The error with the sure effect alone is 1, and ``all_of_it`` is the
    share of the error without effects that both leave.
    """
    without = left / all_of_it if all_of_it < 1 else 1.5
    errors = {(0, 1): (left,) * 3, (0,): (1.0,) * 3, (): (without,) * 3}
    choice = chosen(monkeypatch, errors, unsure=["scale_1"], in_time=in_time)
    assert len(choice.left_out) == 2 - kept


@pytest.mark.parametrize(
    ("equations", "statistic", "unsure", "kept"),
    [
        (4.0, 24.0, (0, 1), 0),
        (4.0, 40.0, (0, 1), 2),
        (6.0, 24.0, (0, 1), 2),
        (3.0, 24.0, (0, 1), 0),
        (4.0, 24.0, (1,), 2),
    ],
)
def test_with_few_equations_effects_without_a_sure_name_are_corrected_only_if_they_explain_much(
    equations, statistic, unsure, kept, monkeypatch
):
    """With four equations for each parameter an F statistic of 24 is too small and one of 40 is not, nor is 24 beside an effect with a sure name.

    With six equations for each parameter 24 are enough.
    """
    errors = {(0, 1): (0.3,) * 3, (0,): (1.0,) * 3, (): (2.0,) * 3}
    names = [f"scale_{k}" for k in unsure]
    choice = chosen(monkeypatch, errors, unsure=names, statistic=statistic, equations=equations)
    assert len(choice.left_out) == 2 - kept


def test_nuisances_alone_are_not_corrected(monkeypatch):
    """A nuisance is shipped beside an effect that was found; where the errors are smallest with it alone, nothing is."""
    nuisance = effect_of(2)
    errors = {(0, 1): (1.0,) * 3, (2,): (0.1,) * 3, (): (2.0,) * 3}
    monkeypatch.setattr(focused_choice, "_with_least_error", lambda *_: (2,))
    choice = chosen(monkeypatch, errors, nuisances=[nuisance])
    assert len(choice.left_out) == 2 and not choice.added
    assert choice.errors_as_chosen == (2.0,) * 3


def chosen(
    monkeypatch,
    errors,
    plausible=True,
    unsure=(),
    in_time=False,
    statistic=np.inf,
    equations=np.inf,
    nuisances=(),
    kind=None,
):
    """Return the choice among two effects, given the expected errors of some models; those of all others are large."""
    wide = SimpleNamespace(
        errors=lambda kept: errors.get(kept, (10.0, 10.0, 10.0)),
        std=lambda kept: 1.0,
        f_statistic=lambda tested, kept: statistic,
    )
    monkeypatch.setattr(doubtful_effects, "equations_per_parameter", lambda _: equations)
    monkeypatch.setattr(focused_choice, "NestedModels", lambda _: wide)
    monkeypatch.setattr(focused_choice, "missing_nuisances", lambda *_: list(nuisances))
    poses = SimpleNamespace(order=np.arange(10.0))
    effects = effect_of(0), effect_of(1, in_time)
    of_arm = {"of_instrument": False, "any_smooth_form": False, "acts_on_arm": True}
    for effect in (*effects, *nuisances):
        vars(effect).update(of_arm if kind is None else kind)
    fewer = SimpleNamespace(is_plausible=plausible)
    after: Any = SimpleNamespace(
        effects=effects,
        dataset=SimpleNamespace(
            q=np.linspace(-2.0, 2.0, 180).reshape(30, 6),
            robot=SimpleNamespace(slides=np.zeros(6, dtype=bool)),
            poses=pd.DataFrame({"order": np.random.default_rng(1).permutation(30)}),
            n_poses=30,
        ),
        model=None,
        settings=DEFAULTS,
        refitted=lambda *_: fewer,
        is_plausible=True,
        residuals=SimpleNamespace(poses=poses),
    )
    return focused_choice.focused_choice(after, unsure)


def effect_of(number: int, in_time: bool = False) -> Any:
    """Return a stand-in for an effect, which may be a change in time."""
    return SimpleNamespace(
        generalised=lambda _: None,
        flexible=False,
        key=f"scale_{number}",
        since=lambda _: None,
        is_change_in_time=in_time,
        depends_on=[],
        target={},
        in_every_setup=number > 1,
        stretches_lengths=False,
    )


@pytest.mark.parametrize(("share", "fit"), [(0.6, "weights_of_component"), (0.8, "equal_weights")])
def test_weights_are_used_only_where_predictions_are_clearly_more_certain(share, fit, monkeypatch):
    """A standard error of 60 % of that with equal weights is clearly smaller, and one of 80 % is not."""
    assert weighted(monkeypatch, std=share, difference=0.0).fit == fit


@pytest.mark.parametrize(("difference", "disagree"), [(1.5, False), (3.0, True)])
def test_fits_disagree_where_their_predictions_differ_beyond_chance(difference, disagree, monkeypatch):
    """Predictions that differ by three standard errors disagree, and by one and a half they do not."""
    found = weighted(monkeypatch, std=1.0, difference=difference).disagreement
    assert found is not None and found.beyond_chance == disagree


def weighted(monkeypatch, std: float, difference: float) -> shipped_fit.ShippedFit:
    """Return what is shipped if the weighted fit has the standard error ``std``, and its predictions differ by ``difference``.

    Both are in units of the standard error with equal weights.
    """

    def changes(_, whitening):
        return SimpleNamespace(
            std=1.0 if whitening is None else std, difference_from=lambda other: (difference, 1.0)
        )

    monkeypatch.setattr(shipped_fit, "prediction_changes", changes)
    monkeypatch.setattr(shipped_fit, "priors_for_whitened_rows", lambda found: found)
    monkeypatch.setattr(
        shipped_fit,
        "focused_choice",
        lambda found, _: SimpleNamespace(state=found, left_out=(), as_found=True),
    )
    monkeypatch.setattr(shipped_fit, "held_out_errors", lambda *_: SimpleNamespace(rms=1.0))
    return shipped_fit.shipped_fit(state(effects=()), state(effects=()), np.eye(3)[None])


@pytest.mark.parametrize(("share", "confirmed"), [(0.4, False), (0.6, True)])
def test_an_effect_that_few_runs_choose_is_no_finding(share, confirmed):
    """An effect that six tenths of the runs select is confirmed, and one that four tenths select is not."""
    finding = Finding(JointScale(2), 1e-9, None, None, (), 0.9, (), None)  # type: ignore[arg-type]
    after: Any = SimpleNamespace(settings=DEFAULTS, refitted=lambda _: after, is_plausible=True)
    run = Explained(None, None, after, after, None)  # type: ignore[arg-type]
    outer: Any = SimpleNamespace(answers=(None,), selected_in=lambda effect: share)
    kept = DIAGNOSE._confirmed(run, (finding,), outer)[1]
    assert bool(kept) == confirmed


def test_noises_of_nearly_the_same_likelihood_are_confounded():
    """A component two nats below the likeliest one is confounded with it, and one four nats below is not."""
    noise = [VarianceComponent(name, 1e-4, 1e-5, gain, 0.0, np.zeros((0, 1, 1))) for name, gain in NOISES]
    rms = SimpleNamespace(rms=1e-4)
    given: Any = SimpleNamespace(
        noise=noise,
        after=SimpleNamespace(settings=DEFAULTS),
        shipped=SimpleNamespace(rms_with_equal_weights=rms.rms, effects_held_out=rms),
        noise_grounds=SimpleNamespace(to_mapping=dict),
        noise_confidence=0.9,
        _noise_selected_in=None,
        component_is_no_noise=False,
    )
    assert [entry["name"] for entry in Diagnosis.noise_entry(given)["confounded_with"]] == ["near"]


def test_what_explains_nearly_as_much_is_confounded(monkeypatch):
    """A candidate four nats below the effect is confounded with it, and one seven nats below is not."""
    own = scored(JointScale(2, slides=True), 100.0)
    near, far = JointHarmonic(4, (7,)), JointHarmonic(5, (7,))
    stand_ins: dict[str, Any] = {
        "priors_for_whitened_rows": lambda after: after,
        "CandidateColumns": SimpleNamespace(of=lambda *_: None),
        "evidence_without_a_name": lambda *_: [[]],
        "leads_of_terms": lambda *_: [-np.inf],
        "_scores_given_all": lambda *_: [],
        "held_out_errors": lambda _: None,
        "rivals": lambda *_: (own, [own, scored(near, 96.0), scored(far, 93.0)]),
        "rivals_of_strongest_part": lambda *_: [],
        "background_without": lambda *_: (None,),
        "has_all_orders": lambda *_: False,
        "is_shrunk": lambda _: False,
        "without_each_fold": lambda _: [],
        "fold_odds": lambda *_: np.array([9.0, 3.0, 6.0]),
        "grounds_of_effect": lambda *_: None,
        "confidence": lambda *_: 0.9,
        "_compared_with_sets": lambda found, *_: found,
    }
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(judged_effects, name, stand_in)
    after: Any = SimpleNamespace(
        effects=(own.effect,),
        settings=DEFAULTS,
        model=None,
        refitted=lambda *_: after,
        dataset=SimpleNamespace(robot=None, known_poses=None),
    )
    (finding,) = judged_effects.findings_of(Explained(None, None, after, after, None), None)  # type: ignore[arg-type]
    assert finding.confounded_with == (near,)
