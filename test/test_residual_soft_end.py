"""A gain is told from an effort that ends softly, and what stands beside either."""

import numpy as np
import pytest
from residual_helpers import (alone, clean_runs, declared_model, diagnosed, on, ripple, SECONDS,
                              told)

from hand_load_estimator.residual.diagnosis import CONFIRMED, SUSPECTED, UNKNOWN


def softly(joint, end):
    """Return an effect: effort of one joint that ends at so many times its largest torque."""
    end *= max(np.abs(torque[:, joint]).max() for _, _, torque in clean_runs(SECONDS))
    return alone(lambda run: end * np.tanh(run.torque / end) - run.torque, joint)


def gain(joint, size):
    return alone(lambda run: size * run.torque, joint)


def test_an_effort_that_ends_softly_is_no_gain():
    """What comes nearest is at most suspected."""
    diagnosis, _ = diagnosed(softly(1, 0.5))
    found = {f.name: f for f in diagnosis.findings}
    assert told(diagnosis) == {UNKNOWN: (declared_model().robot.joints[1],)}
    assert found[UNKNOWN].variables == ('drive torque',)
    assert found['torque_scale'].verdict == SUSPECTED
    assert any('j1: torque_scale is only suspected, because a function of torque' in text
               for text in diagnosis.remains)


@pytest.mark.parametrize('joint, end', [(0, 0.5), (3, 1.4)])
def test_what_a_soft_end_explains_as_well_is_not_confirmed(joint, end):
    """Friction is most of the torque of these joints, and makes up for the bend."""
    diagnosis, _ = diagnosed(softly(joint, end))
    assert [f.name for f in diagnosis.findings] == ['torque_scale', 'coulomb_friction']
    assert not told(diagnosis)
    assert (f'j{joint}: torque_scale is only suspected, because an effort that ends softly is '
            'not surely told from it') in diagnosis.remains
    assert (f'j{joint}: coulomb_friction is only suspected, because beside an effort that ends '
            'softly it gains nothing sure') in diagnosis.remains


def test_what_else_a_joint_has_is_confirmed_beside_a_soft_end():
    """2.0 is far beyond what joint 1 ever shows. The gain of another joint is another step."""
    diagnosis, _ = diagnosed(softly(1, 2.0), on(1, 4.0, ripple), gain(2, 0.1))
    assert told(diagnosis) == {'torque_ripple': ('j1',), 'torque_scale': ('j2',)}
    assert [f.joints for f in diagnosis.findings
            if (f.name, f.verdict) == ('torque_scale', SUSPECTED)] == [('j1',)]


def test_gains_are_parted_into_what_saturates_what_may_and_what_does_not():
    diagnosis, _ = diagnosed(softly(0, 0.5), softly(1, 0.5), gain(2, 0.2))
    gains = {f.joints: f.verdict for f in diagnosis.findings if f.name == 'torque_scale'}
    assert gains == {('j0',): SUSPECTED, ('j1',): SUSPECTED, ('j2',): CONFIRMED}


@pytest.mark.parametrize('joint, size', [(0, 0.1), (3, -0.1)])
def test_a_gain_is_no_soft_end(joint, size):
    """Whichever way it goes, and though friction is most of the torque."""
    diagnosis, _ = diagnosed(gain(joint, size))
    assert told(diagnosis) == {'torque_scale': (f'j{joint}',)}
    assert not any('only suspected' in text for text in diagnosis.remains)


def test_a_gain_that_leaves_a_little_is_one():
    def cubic(run):
        return run.torque ** 3

    assert told(diagnosed(gain(1, 0.1))[0]) == {'torque_scale': ('j1',)}
    assert 'torque_scale' in told(diagnosed(gain(1, 0.1), on(1, 0.7, cubic))[0])


def test_a_gain_and_a_soft_end_are_told_joint_by_joint():
    diagnosis, _ = diagnosed(gain(1, 0.2), softly(2, 0.7))
    assert told(diagnosis) == {'torque_scale': ('j1',), UNKNOWN: ('j2',)}
