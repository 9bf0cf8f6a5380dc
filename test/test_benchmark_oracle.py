"""An oracle takes for a load what is one, and only that; what it says of effects on the page."""

from functools import lru_cache

from benchmark_helpers import result
from core_helpers import block, exact_model, four_axes
import numpy as np
from plant_helpers import LOAD, ur10e
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases, measure, oracle
from hand_load_estimator.benchmark.contestants import Contestant, FIXED
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.measure import MOMENTS
from hand_load_estimator.benchmark.oracle_scores import ALL, oracle_blocks, oracle_scores
from hand_load_estimator.benchmark.rivals import FixedLoad
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.plant import JointEvent

PLANT = seeds.DEVELOPMENT_PLANTS[94]
LEFT = np.full(6, 0.5)   # [Nm]
EARLY, LATE = 0.2, 99.0  # [s], before the first motion and after the last


@lru_cache
def hidden(name=None, joint='elbow_joint', **parameters):
    """Return the Case of an effect on a joint and its AddedTorque."""
    entry = {'name': name, 'joints': [joint], 'parameters': parameters}
    case = cases.Case(PLANT, 7, LOAD, 25.0, 1.0, hidden=(entry,) if name else ())
    return case, oracle.added_torque(ur10e(), case)


def told(*args, **parameters):
    """Return the oracle's Likeness and its figures of the mass, EARLY and LATE."""
    _, added = hidden(*args, **parameters)
    return (oracle.likeness(added, LEFT),
            oracle.mass_figures(ur10e(), LOAD, added, [EARLY, LATE]))


def test_what_is_bolted_to_the_last_link_is_a_load():
    """Its torque is all a load's, its mass the oracle's error, and no torque tells them apart."""
    likeness, mass = told('link_inertia', 'wrist_3_joint', mass=0.5, x=0.02, y=-0.05, z=0.1)
    assert likeness.share == pytest.approx(1.0, abs=1e-4)
    assert likeness.chance < 0.9 and likeness.rest < 0.05
    assert mass['mass'][1] == pytest.approx(0.5, abs=0.005)
    assert mass['mass_free'][1] == pytest.approx(0.5, abs=0.02)
    assert mass['mass_bound'][1] > 0.5
    # Nothing has moved: nothing is taken for anything, and the prior is all there is.
    assert mass['mass'][0] == mass['mass_free'][0] == 0.0
    assert mass['mass_bound'][0] == pytest.approx(load_prior(ur10e()).std[0])


def test_a_ripple_is_none():
    likeness, mass = told('torque_ripple', torque=4.0, periods=100.0)
    assert likeness.share < 0.02
    # A sine and its harmonic, in a joint of which the model leaves 0.5 Nm.
    assert likeness.rest > 4.0
    assert abs(mass['mass'][1]) < 0.05
    assert mass['mass_bound'][1] < 0.01


def test_an_offset_is_one_until_the_joints_are_free():
    """A constant is the same at all times: what share of it a load makes is all by chance."""
    likeness, mass = told('torque_offset', torque=8.0)
    assert likeness.share > 0.1
    assert likeness.chance == pytest.approx(likeness.share, abs=0.01)
    assert abs(mass['mass'][1]) > 0.02
    assert abs(mass['mass_free'][1]) < 0.02 * abs(mass['mass'][1])


def test_errors_grow_with_the_effect_and_shares_do_not():
    small, large = (told('torque_offset', torque=size) for size in (4.0, 8.0))
    assert small[0].share == pytest.approx(large[0].share, abs=0.02)
    assert large[0].rest == pytest.approx(2.0 * small[0].rest, rel=0.05)
    assert large[1]['mass'][1] == pytest.approx(2.0 * small[1]['mass'][1], rel=0.05)


def test_what_did_not_happen_has_no_share():
    likeness, mass = told()
    assert np.isnan([likeness.share, likeness.chance, likeness.rest]).all()
    assert abs(mass['mass'][1]) < 0.002


def test_the_run_is_the_one_that_is_measured():
    """As long, and along a motion that only encoders blur."""
    case, added = hidden('torque_offset', torque=8.0)
    events = [e for e in cases.case_events(ur10e(), case) if isinstance(e, JointEvent)]
    np.testing.assert_array_equal(added.stamp, [e.stamp for e in events])
    speed = np.array([e.velocity for e in events])
    quick = np.abs(speed) > 0.1
    assert quick.mean() > 0.2 and (added.precision > 0.0)[quick].all()


def test_a_case_with_an_effect_has_an_oracle_at_every_time(monkeypatch):
    monkeypatch.setattr(cases, 'DURATION', 5.0)
    monkeypatch.setattr(measure, 'TIMES', (0.5, 1.0))
    monkeypatch.setattr(measure, 'contestants', lambda robot, *_: {
        FIXED: Contestant(None, lambda follower: FixedLoad(robot))})
    robot, model = four_axes(), exact_model('four')
    offset = {'name': 'torque_offset', 'joints': [robot.joints[1]], 'parameters': {'torque': 1.0}}
    for effects in ((), (offset,)):
        case = cases.Case(PLANT, 7, block(2.0), 25.0, 1.0, hidden=effects)
        found = measure.run_case(robot, case, {'ours': model, 'textbook': model})
        if not effects:
            assert found['oracle'] is None
            continue
        assert 0.0 < found['oracle']['share'] < 1.0
        # The method's moments, and with more data the bound is less.
        assert len(found['bound']) == len(found['oracle']['mass']) == 3
        assert (np.diff(found['oracle']['mass_bound']) < 0.0).all()


def suffered(effect, share, off, oracle_off):
    """Return a case of an effect in which a method and an oracle are off by so much [kg]."""
    out = {**result(1, 1, off=off, std=0.1), 'hidden': [effect]}
    figures = dict.fromkeys(('mass', 'mass_free', 'mass_bound'), [oracle_off] * len(MOMENTS))
    return {**out, 'oracle': {'share': share, 'chance': 0.5 * share, 'rest': 2.0, **figures}}


def test_effects_are_told_beside_the_oracle():
    nothing = float('nan')
    runs = [suffered('link_inertia', 0.9, 0.1, 0.3), suffered('link_inertia', 0.7, 0.3, -0.4),
            suffered('external_contact', nothing, 0.0, 0.0)]
    found = oracle_scores(runs, 'lstm')
    assert list(found) == ['external_contact', 'link_inertia', ALL]
    inertia = found['link_inertia']
    assert (inertia['share'], inertia['chance']) == (pytest.approx(0.8), pytest.approx(0.4))
    # The sign of an error is no matter, and one of 0.1 kg is within 1.96 x 0.1 kg.
    assert inertia['mass_rmse']['oracle']['1 s'] == pytest.approx(np.sqrt((0.09 + 0.16) / 2.0))
    assert inertia['mass_rmse']['method']['end'] == pytest.approx(np.sqrt((0.01 + 0.09) / 2.0))
    assert inertia['mass_coverage'] == {'method': 0.5, 'oracle': 0.0}
    assert found[ALL]['cases'] == 3 and found[ALL]['share'] == pytest.approx(0.8)
    assert found[ALL]['mass_coverage']['method'] == pytest.approx(2.0 / 3.0)
    page = to_markdown(oracle_blocks(found, 'lstm'))
    assert '| link_inertia | 80 | 40 | 2.00 | 224 / 224 | 354 / 354 | ' in page
    assert '| external_contact | - | - | 2.00 | 0 / 0 |' in page
    assert 'without a motion without load' in page
    assert oracle_blocks({}, 'lstm') == []
