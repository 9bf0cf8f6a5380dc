"""A recording too short to diagnose is refused with what took its time away."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import block
import numpy as np
import pytest
from residual_helpers import cut, recorded

from hand_load_estimator.errors import RecordingError
from hand_load_estimator.residual.doubts.time_left import (long_loads, many_rejected,
                                                           refuse_too_short)


def disturbed(name, run, first, stop, mass=0.0):
    """Return (Residual, Disturbances) of one recording, as far as they are looked at."""
    kind = SimpleNamespace(kind=SimpleNamespace(name=name))
    return SimpleNamespace(dt=run.motion.dt), (SimpleNamespace(
        cause=kind, owner=0, first=first, stop=stop, theta=np.array([mass])),)


def refused(left, whole, *outside):
    with pytest.raises(RecordingError) as error:
        refuse_too_short(left, whole, *outside)
    return str(error.value)


def test_a_short_recording_is_named_once_and_told_what_to_do():
    run = recorded()[0]
    parts = [cut(run, slice(50)), cut(run, slice(60, 100))]
    said = refused(parts, parts)
    assert said.count('run 0') == 1 and '1.8 s are left' in said and '4.8 s' in said
    assert said.endswith('record a motion of `hand_load excite`')
    refuse_too_short([run], [run])


@pytest.mark.parametrize('declared, words', [(None, 'about 2.6 kg, declared: none'),
                                             (block(1.0), 'about 3.6 kg, declared: 1 kg')])
def test_a_load_that_takes_all_the_time_is_said(declared, words):
    run = recorded()[0]
    run = replace(run, load=declared or run.load)
    outside = disturbed('load_change', run, 0, len(run.torque) - 20, 2.6)
    said = refused([cut(run, slice(len(run.torque) - 20, None))], [run], *outside)
    assert f'run 0 looks loaded with {words}; give the load' in said and '--load' in said
    assert 'hand_load excite' not in said
    (told,) = long_loads([run], *outside)
    assert told.startswith('cannot tell whether run 0 declares the right load') and words in told
    assert not long_loads([run], *disturbed('load_change', run, 0, 100, 2.6))


def test_contacts_that_take_all_the_time_are_said():
    run = recorded()[0]
    outside = disturbed('external_contact', run, 0, len(run.torque) - 20)
    said = refused([cut(run, slice(len(run.torque) - 20, None))], [run], *outside)
    assert 'run 0 shows a contact' in said and 'looks loaded' not in said
    assert not long_loads([run], *outside)


def test_rejected_messages_are_said_with_their_reasons():
    run = replace(cut(recorded()[0], slice(100)), rejected={'gap': 3, 'implausible_effort': 97})
    said, whole = refused([run], [run]), 100 + run.motion.messages.sum()
    assert f'100 of {whole} messages of run 0 were rejected (97 implausible effort, 3 gap)' in said
    assert '`hand_load check`' in said
    (told,) = many_rejected([run])
    assert told.startswith('cannot tell') and f'100 of {whole} messages of run 0' in told
    assert not many_rejected([replace(run, rejected={'gap': 3})])
