"""/diagnostics on the torque model: what it left at the last diagnosis, and what it leaves now."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

from core_helpers import exact_model
import numpy as np
import pytest

from hand_load_estimator.estimators.residual_watch import Aged, EARLIER
from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.nodes.controller_report import report_torque_model
from hand_load_estimator.nodes.diagnostics import OK, WARN
from hand_load_estimator.nodes.model_report import report_model
from hand_load_estimator.nodes.stamps import StampBase
from hand_load_estimator.torque.model_file import read_model
from hand_load_estimator.torque.simulated_model import told_of_simulated

THEN = np.array([0.5, 0.41, np.nan, 0.2])


def reported(now, aged=('j1',), diagnosed='2026-03-01T14:30:00+00:00', sliding=THEN,
             enough=(True,) * 4, recordings=(), simulated=False, since=5.0):
    """Return what is said of a model with residuals now (4,) [Nm], joints aged."""
    model = exact_model('four')
    model = replace(model, diagnosed=diagnosed, recordings=recordings,
                    residuals=replace(model.residuals, sliding=sliding))
    now = np.array(now)
    found = tuple(Aged(name, 2.1, since, 45.0, now[model.robot.joints.index(name)])
                  for name in aged)
    watch = SimpleNamespace(aged=found, residual=now, ratio=np.full(4, 2.0),
                            seconds=np.full(4, 60.0), enough=np.array(enough))
    return report_model(SimpleNamespace(watch=watch, model=model, model_file=Path('m.yaml')), 0.0,
                        StampBase(), simulated)


def test_what_has_grown_since_the_diagnosis_is_told_with_both_figures():
    level, message, values = reported([0.5, 1.02, 0.3, 0.2])
    assert level == WARN
    assert message.endswith('since the diagnosis of 2026-03-01 14:30 residual of j1 has grown '
                            'from 0.41 to 1.02 Nm')
    assert values['diagnosed'] == '2026-03-01T14:30:00+00:00'
    assert values['residual j1 [Nm]'] == 1.02
    assert values['residual j1 at the last diagnosis [Nm]'] == 0.41
    assert 'residual j2 at the last diagnosis [Nm]' not in values


def test_a_joint_that_aged_before_a_restart_has_no_date():
    _, message, values = reported([0.5, 1.02, 0.3, 0.2], since=EARLIER)
    assert 'times the stated since before the last restart (45 s of motion)' in message
    assert values['aged since'] == 'before the last restart'


def test_what_was_so_already_has_not_grown():
    message = reported([0.5, 0.44, 0.3, 0.2])[1]
    assert 'grown' not in message
    assert message.endswith('at the diagnosis of 2026-03-01 14:30 it was 0.41 Nm already, now '
                            '0.44 Nm')


@pytest.mark.parametrize('keywords', [{'diagnosed': None, 'sliding': None}, {'aged': ('j2',)}])
def test_what_is_not_known_of_the_diagnosis_is_not_said(keywords):
    level, message, values = reported([0.5, 1.02, 3.0, 0.2], **keywords)
    assert level == WARN and message.endswith('(45 s of motion)')
    assert (values['diagnosed'] == 'not known') == ('sliding' in keywords)


def test_two_aged_joints_are_told_apart():
    message = reported([0.9, 1.02, 3.0, 0.2], ('j1', 'j0'))[1]
    assert message.count('has grown from') == 2 and message.count(';') == 1


def test_a_good_model_tells_its_diagnosis_too():
    level, message, values = reported([0.5, 0.4, 0.3, 0.2], ())
    assert (level, message) == (OK, 'residuals are what the model states')
    assert values['residual j3 at the last diagnosis [Nm]'] == 0.2


def test_a_joint_not_judged_yet_has_no_figure():
    _, _, values = reported([0.5, 1.02, 0.0, 0.2], enough=(True, True, False, True))
    assert 'residual j2 [Nm]' not in values and 'residual ratio j2' not in values
    assert values['residual j3 [Nm]'] == 0.2


def test_a_real_arm_is_told_that_the_shipped_model_is_none_of_its_own():
    shipped = read_model(find_shared('ur10e', 'models'))
    told = told_of_simulated(shipped, False)
    assert 'simulated arm: identify your own' in told
    # Wherever the file lies, and with more recordings since.
    more = replace(shipped, recordings=(*shipped.recordings, RecordingMark('monday', 'abc')))
    assert told_of_simulated(more, False) == told
    assert told_of_simulated(shipped, True) == told_of_simulated(exact_model('four'), False) == ''
    # Every shipped model is one of them.
    for path in find_shared('ur10e', 'models').parent.glob('*.yaml'):
        assert told_of_simulated(read_model(path), False), path


def test_it_is_told_with_what_else_there_is(monkeypatch):
    monkeypatch.setattr('hand_load_estimator.torque.simulated_model.SHIPPED', frozenset(['mine']))
    recordings = (RecordingMark('simulated', 'mine'),)
    both = reported([0.5] * 4, recordings=recordings)
    assert both[0] == WARN
    assert both[1].startswith('model has aged: j1') and both[1].endswith('arm is simulated')
    alone = reported([0.5] * 4, (), recordings=recordings)
    assert alone[0] == WARN and alone[1].startswith('the torque model that comes with')
    assert reported([0.5] * 4, (), recordings=recordings, simulated=True)[0] == OK
    model = replace(exact_model('four'), recordings=recordings)
    assert [report_torque_model(model, simulated)[0] for simulated in (False, True)] == [WARN, OK]
