"""The fit through lmfit: the same optimum and standard errors as the fit that a calibration makes, and lmfit's report of it."""

import lmfit
import numpy as np
import pytest

from scalar.estimation import lmfit_fit
from scalar.estimation.least_squares import fit
from scalar.estimation.lmfit_fit import fit_with_lmfit
from scalar.estimation.prepare import prepare
from tests.random_scene import make_scene


@pytest.mark.parametrize("kind", ["line-laser", "tracker"])
def test_lmfit_ends_at_the_same_optimum(kind):
    """The cost agrees to 1e-10, values to 1e-6 standard errors, and lmfit's own standard errors to 1e-6. The report names every parameter."""
    prepared = prepare(make_scene(kind=kind, seed=5, poses_per_plane=30).dataset)
    model = prepared.initial.model
    ours = fit(prepared.residuals, model, prepared.free)
    theirs, result = fit_with_lmfit(prepared.residuals, model, prepared.free)
    std = np.sqrt(np.diag(ours.covariance))
    off = (theirs.model.vector - ours.model.vector)[prepared.free]
    assert ours.converged and theirs.converged
    assert theirs.chi_squared == pytest.approx(ours.chi_squared, rel=1e-10)
    assert np.max(np.abs(off) / std) < 1e-6
    errors = [parameter.stderr for parameter in result.params.values()]
    np.testing.assert_allclose(np.array(errors, dtype=float), std, rtol=1e-6)
    report = lmfit.fit_report(result)
    names = [name for name, is_free in zip(model.names, prepared.free, strict=True) if is_free]
    assert all(f"{name}:" in report for name in names)


def test_errors_and_correlations_are_those_of_lmfit(monkeypatch):
    """Every number that lmfit's own method writes into a result is there, to the bit, and the reports are the same."""
    prepared = prepare(make_scene(seed=5, poses_per_plane=30).dataset)
    run = prepared.residuals, prepared.initial.model, prepared.free
    ours = fit_with_lmfit(*run)[1]
    monkeypatch.delattr(lmfit_fit._Minimizer, "_calculate_uncertainties_correlations")
    theirs = fit_with_lmfit(*run)[1]
    for own, other in zip(ours.params.values(), theirs.params.values(), strict=True):
        assert (own.name, own.value, own.stderr) == (other.name, other.value, other.stderr)
        assert own.correl == other.correl
    assert ours.errorbars is theirs.errorbars is True
    assert [str(one) for one in ours.uvars.values()] == [str(one) for one in theirs.uvars.values()]
    assert lmfit.fit_report(ours) == lmfit.fit_report(theirs)
