"""What a diagnosis promises: its model, its errors, what is kept for the test, its residual."""

from core_helpers import four_axes
import numpy as np
from residual_helpers import (assert_repaired, cable, clean_runs, declared_model, diagnosed, late,
                              noise_of, on, recorded, ripple, RUNS, SECONDS, told, viscous)

from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.doubts.limits import usable_residual
from hand_load_estimator.residual.explanation import explain
from hand_load_estimator.residual.measured.find import find_residual


def test_the_better_model_holds_what_the_report_says():
    """Every effect the old model did not have is a finding, and the reverse."""
    model = declared_model()
    for hidden in ((on(1, 2.0, ripple), on(1, 2.0, cable)), (on(1, 3.0, cable), late)):
        diagnosis, better = diagnosed(*hidden)
        old = {(u.name, u.joint) for u in model.uses}
        new = {(u.name, better.robot.joints[u.joint]) for u in better.uses
               if (u.name, u.joint) not in old}
        reported = {(f.name, joint) for f in diagnosis.findings for joint in f.joints
                    if not f.changed}
        assert new == reported


def test_tests_are_used_for_nothing_but_errors():
    """A test recording of another arm changes no finding and no parameter."""
    evidence = recorded(on(2, 2.0, ripple))
    other = recorded(on(2, 2.0, ripple), on(1, 5.0, viscous))[-1:]
    (one, first), (two, second) = (diagnose(declared_model(), evidence[:-1], test)
                                   for test in (evidence[-1:], other))
    assert [f.name for f in one.findings] == [f.name for f in two.findings] == ['torque_ripple']
    np.testing.assert_array_equal(first.mean, second.mean)
    assert two.before[1] > 2.0 * one.before[1] and two.after[1] > 2.0 * one.after[1]
    assert (one.tested_on, two.tested_on) == ('run 3', 'run 3')
    assert one.recordings == ('run 0', 'run 1', 'run 2')


def test_without_tests_the_last_quarter_is_kept():
    evidence = recorded(on(2, 2.0, ripple))
    diagnosis, _ = diagnose(declared_model(), evidence)
    assert told(diagnosis) == {'torque_ripple': (declared_model().robot.joints[2],)}
    assert 'quarter' in diagnosis.tested_on
    assert_repaired(diagnosis, 2)
    # The same, with what happens in the last quarter only: nothing is found, all of it is error.
    late_part = [Evidence(e.name, e.motion, np.where(
        (np.arange(len(e.torque)) >= 0.75 * len(e.torque))[:, None],
        bad.torque, e.torque)) for e, bad in zip(recorded(), evidence)]
    diagnosis, _ = diagnose(declared_model(), late_part)
    assert diagnosis.findings == ()
    assert diagnosis.after[2] == diagnosis.before[2] > 1.5 * noise_of(four_axes())[2]


def test_the_residual_is_measured_less_modelled():
    """One row of the residual against the model's own torque, without any detour."""
    model, evidence = declared_model(), recorded()
    residual = find_residual(model, evidence)
    np.testing.assert_allclose(
        residual.residual, np.concatenate([e.torque - clean for e, (_, _, clean) in zip(
            evidence, clean_runs(SECONDS))]), atol=1e-9)
    assert list(np.unique(residual.owner)) == [0, 1, 2, 3]
    assert len(np.unique(residual.folds)) == RUNS
    # No block belongs to two recordings.
    owners = residual.owner[residual.starts]
    np.testing.assert_array_equal(owners, residual.folds)
    assert residual.moving.mean() > 0.5


def test_recordings_are_as_the_tests_say():
    """The helper's own promise: an effect of so many times the noise, on its joint alone."""
    plain, more = (np.concatenate([e.torque for e in r]) for r in (
        recorded(), recorded(on(1, 2.0, cable))))
    rms = np.sqrt(np.mean((more - plain) ** 2, axis=0)) / noise_of(declared_model().robot)
    np.testing.assert_allclose(rms, [0.0, 2.0, 0.0, 0.0], atol=1e-9)
    assert len(clean_runs(16.0)) == 4


def test_what_is_traced_is_the_residual_of_the_evidence():
    """Also where it is that of the whole recordings, because nothing was left out."""
    runs = recorded(on(1, 2.0, viscous))
    for test in (runs[-1:], ()):
        ex = explain(declared_model(), runs[:3], test, lambda text: None)
        own, still = usable_residual(declared_model(), ex.evidence)
        assert (ex.residual is ex.whole) == bool(test) and ex.still == still
        for name in ('residual', 'weights', 'starts', 'folds'):
            np.testing.assert_array_equal(getattr(ex.residual, name), getattr(own, name))
