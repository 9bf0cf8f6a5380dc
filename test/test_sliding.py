"""The residual while joints slide: the same figure offline, at a diagnosis, and from the watch."""

from core_helpers import exact_model, messages, recording_of
import numpy as np
import pytest
from test_residual_watch import JOINT, rubbed, watched

from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.stream.joint_stream import motion_of
from hand_load_estimator.torque.sliding import BLOCK, FEWEST_SECONDS, sliding_rms, surely_slides

DT = 0.02
EMPTY = LoadParameters()


def rms_of(residual, sliding=None, owner=None):
    """Return the RMS (1,) of one joint's residual (N,)."""
    count = len(residual)
    sliding = np.ones(count, dtype=bool) if sliding is None else sliding
    owner = np.zeros(count, dtype=int) if owner is None else owner
    return sliding_rms(residual[:, None], sliding[:, None], np.full(count, DT), owner)[0]


def test_what_lasts_stays_and_what_alternates_goes():
    assert rms_of(np.full(500, -0.7)) == pytest.approx(0.7)
    assert rms_of(np.tile([0.7, -0.7], 250)) < 1e-9
    white = rms_of(np.random.default_rng(0).normal(size=20000))
    assert white == pytest.approx(np.sqrt(DT / BLOCK), rel=0.05)


def test_rows_at_rest_and_other_recordings_do_not_count():
    residual = np.tile([1.0, 50.0], 250)
    assert rms_of(residual, residual < 2.0) == pytest.approx(1.0)
    # Two recordings of opposite offset whose border lies within a block.
    parts = np.where(np.arange(505) < 253, 1.0, -1.0)
    assert rms_of(parts, owner=(np.arange(505) >= 253).astype(int)) == pytest.approx(1.0)


def test_with_too_little_motion_it_is_not_known():
    count = int(FEWEST_SECONDS / DT)
    assert np.isnan(rms_of(np.ones(count - 20)))
    assert np.isnan(rms_of(np.ones(500), np.zeros(500, dtype=bool)))
    assert rms_of(np.ones(count + 20)) == pytest.approx(1.0)


def test_a_joint_slides_when_it_is_fast_and_its_friction_has_turned():
    assert surely_slides(0.1, 1.0, 0.0) and surely_slides(-0.1, -0.99, 0.01)
    assert not surely_slides(0.02, 1.0, 0.0) and not surely_slides(0.1, 0.9, 0.0)
    assert not surely_slides(0.1, 1.0, 0.2)


@pytest.mark.parametrize('times', [0.0, 2.0])
def test_the_watch_gives_the_same_figure_as_a_diagnosis(times):
    """Online the load is estimated beside it, which takes a part of the residual."""
    model = exact_model('four')
    stream = rubbed(model, messages(model, EMPTY, 30.0), times=times)
    motion, _ = motion_of(model.robot, recording_of(stream, model.robot.joints, 25.0))
    found = find_residual(model, [prepare(model.robot, 'run', motion, EMPTY)], cut=False)
    offline = sliding_rms(found.residual, found.sliding, found.dt, found.owner)
    online = watched(model, stream).residual
    np.testing.assert_allclose(online[JOINT], offline[JOINT], rtol=0.15)
    assert (online < 1.3 * offline).all() or times
    stated = np.sqrt(model.residuals.intensity / BLOCK)
    assert (offline[JOINT] > 2.0 * stated[JOINT]) == bool(times)
