"""Runs of the effects suite: from plant to result and page, resumed or broken off."""

from dataclasses import replace
import json

from core_helpers import four_axes
from effects_suite_helpers import JOINT, PLANT, result
import numpy as np
from plant_helpers import ur10e
import pytest
from residual_helpers import recorded
import yaml

from hand_load_estimator import cli
from hand_load_estimator.benchmark import cases, effect_measure, effect_recordings, effect_run
from hand_load_estimator.benchmark.effect_cases import EffectCase, Hidden, suite_cases
from hand_load_estimator.benchmark.effect_outcome import judge
from hand_load_estimator.benchmark.effect_page import effects_markdown
from hand_load_estimator.benchmark.effect_recordings import Recordings, without_temperatures
from hand_load_estimator.benchmark.effect_scores import effect_rows
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.residual.diagnosis import CONFIRMED, Diagnosis, Evidence, Finding


def identified_again(model, evidence, test):
    """Diagnose without choosing: the default effects once more, on the changed arm."""
    n = model.robot.n
    found = Finding('viscous_friction', (model.robot.joints[1],), {'coefficient': (1.0, 0.1, 'x')},
                    np.zeros(n), Evidence(9.0, 1.0, 3.0, 20, 40, 1.0), (), '', True, CONFIRMED)
    zero = np.zeros(n)
    diagnosis = Diagnosis(model.robot.name, tuple(model.robot.joints), zero, zero, zero, (found,),
                          zero)
    return diagnosis, identify(model.robot, evidence), 1.0


@pytest.fixture(scope='module')
def robot_path(tmp_path_factory):
    """Return the path of a small arm's robot file: one, so that its arms are made once."""
    path = tmp_path_factory.mktemp('small') / 'arm.yaml'
    path.write_text(yaml.safe_dump(four_axes().file.content))
    return path


@pytest.fixture
def small(robot_path, monkeypatch):
    """Return the path of a small arm's robot file; recordings are brief, no diagnosis is made."""
    brief = (('excite', 20.0, 9.0), ('pick_place', 30.0, 6.0))
    monkeypatch.setattr(effect_recordings, 'IDENTIFIED', cases.Recorded(brief))
    monkeypatch.setattr(cases, 'DURATION', 5.0)
    monkeypatch.setattr(effect_recordings, 'DIAGNOSED', brief)
    monkeypatch.setattr(effect_recordings, 'TESTED', (('excite', 25.0, 6.0),))
    monkeypatch.setattr(effect_recordings, 'LOADED', 1)
    monkeypatch.setattr(effect_measure, 'diagnosis_of', identified_again)
    return robot_path


def test_a_small_case_from_plant_to_result(small, tmp_path, monkeypatch):
    case = EffectCase('single', PLANT, (Hidden('viscous_friction', 5.0, (1,)),))
    (found,) = effect_run.run_cases([case], small, tmp_path / 'raw', workers=0)
    assert [p.name for p in (tmp_path / 'raw').iterdir()] == [f'{case.label}.json']
    assert judge(found)[0][0]['outcome'] == 'found'
    (figure,) = found['parameters']
    assert figure['estimate'] == pytest.approx(figure['truth'], rel=0.2)
    # identified_again states that of it.
    assert figure['std'] == 0.1
    torque = {key: np.array(value) for key, value in found['torque'].items()}
    assert torque['before'][1] > 2.0 * torque['without'][1]
    assert torque['after'][1] < 1.5 * torque['without'][1]
    seen = {key: np.array(value) for key, value in found['seen'].items()}
    assert seen['before'][1] > 2.0 * seen['known'][1]
    np.testing.assert_allclose(seen['known'], torque['without'], rtol=0.1)
    assert set(found['mass']) == {'before', 'after', 'without'}
    assert all(len(errors) == 1 for kind in found['mass'].values() for errors in kind.values())
    # What is there is read, not made again.
    monkeypatch.setattr(effect_run, 'case_result', None)
    assert effect_run.run_cases([case], small, tmp_path / 'raw', workers=0) == [found]
    assert 'viscous_friction' in effects_markdown([found], '', '')


def test_a_small_case_of_the_whole_arm(small, tmp_path):
    case = EffectCase('single', PLANT, (Hidden('load_change', 5.0),))
    (found,) = effect_run.run_cases([case], small, tmp_path / 'raw', workers=0)
    assert judge(found)[0][0]['outcome'] == 'confused'
    (figure,) = found['parameters']
    assert figure['truth'] > 0.01 and figure['estimate'] is None and figure['std'] is None
    assert '| `load_change` | 5 | 0 of 1 |' in effects_markdown([found], '', '')


def test_what_cannot_be_made_is_skipped_with_its_reason(small, tmp_path):
    case = EffectCase('single', PLANT, (
        Hidden('temperature_dependent_viscous_friction', 500.0, (0, 1)),))
    (found,) = effect_run.run_cases([case], small, tmp_path / 'raw', workers=0)
    assert 'so strong' in found['skipped'] and not effect_rows([found])


def test_a_broken_case_is_told_and_tried_again(tmp_path):
    case = EffectCase('clean', PLANT)
    (found,) = effect_run.run_cases([case], 'no such arm', tmp_path / 'raw', 1,
                                    write=lambda text: None)
    assert found['failed'].startswith('ConfigurationError: ') and found['label'] == case.label
    assert not list((tmp_path / 'raw').iterdir())


def test_cases_are_measured_on_the_backend_that_was_chosen(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(effect_run, 'suite_cases', lambda *_: [])
    monkeypatch.setattr(effect_run, 'measure_all',
                        lambda *args, **_: asked.append(args[3:5]) or {})
    monkeypatch.setattr(effect_run, 'runner_of', lambda backend: asked.append(backend))
    monkeypatch.setattr(effect_run, 'write_results', lambda *_: 'page')
    assert effect_run.run_effects('ur10e', tmp_path, '', workers=2, backend='dask') == 'page'
    assert asked == ['dask', (2, 'dask')]


def test_a_suite_writes_its_pages_and_resumes(tmp_path, monkeypatch):
    """Cases measured before are read, not measured again."""
    chosen = suite_cases(ur10e())[:3]
    monkeypatch.setattr(effect_run, 'suite_cases', lambda *_: chosen)
    monkeypatch.setattr(effect_run, 'commit_now', lambda: 'abc')
    raw, told = tmp_path / 'raw', []
    raw.mkdir()
    for case in chosen:
        hidden = [(h.name, (JOINT,) if h.joints else ()) for h in case.hidden]
        (raw / f'{case.label}.json').write_text(json.dumps(result(hidden, [], case.kind)))
    page = effect_run.run_effects('ur10e', tmp_path, 'the command', told.append)
    assert 'the command' in page and told[0] == '3 of 3 are there'
    assert (tmp_path / 'README.md').read_text() == page
    html = (tmp_path / 'index.html').read_text()
    assert html.count('<table>') == page.count('| --- |\n') and '<h1>Undeclared effects' in html
    assert '| ' not in html.split('<body>')[1]
    assert json.loads((tmp_path / 'scores.json').read_text())['suite'] == 'effects'
    monkeypatch.setattr(effect_run, 'commit_now', lambda: 'def')
    with pytest.raises(ConfigurationError, match='another suite, robot, artefact or commit'):
        effect_run.run_effects('ur10e', tmp_path, 'the command', told.append)


def test_a_suite_broken_off_writes_the_page_of_what_is_there(tmp_path, monkeypatch):
    chosen = suite_cases(ur10e())[:3]
    monkeypatch.setattr(effect_run, 'suite_cases', lambda *_: chosen)
    (tmp_path / 'raw').mkdir()
    (tmp_path / 'raw' / f'{chosen[0].label}.json').write_text(json.dumps(
        {**result([(h.name, (JOINT,)) for h in chosen[0].hidden], [], chosen[0].kind),
         'label': chosen[0].label}))

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(effect_run, 'run_cases', interrupted)
    with pytest.raises(KeyboardInterrupt):
        effect_run.run_effects('ur10e', tmp_path, 'the command', print)
    assert 'Broken off: 1 of 3' in (tmp_path / 'README.md').read_text()


def test_the_command_chooses_the_suite(tmp_path, monkeypatch, capsys):
    called = []
    monkeypatch.setattr(effect_run, 'run_effects', lambda *args: called.append(args) or 'page')
    assert cli.main(['benchmark', '--suite', 'effects', '--out', str(tmp_path)]) == 0
    assert called[0][:2] == ('ur10e', str(tmp_path)) and 'page' in capsys.readouterr().out
    assert called[0][-3:] == (None, False, 'processes')
    assert cli.main(['benchmark', '--suite', 'effects', '--development', '--workers', '1',
                     '--backend', 'loky', '--out', str(tmp_path)]) == 0
    assert called[1][-3:] == (1, True, 'loky')
    for option in ('--learned', '--methods', '--cases', '--rivals', '--hours', '--data'):
        assert cli.main(['benchmark', '--suite', 'effects', option, '7', '--out', 'y']) == 2
        assert option in capsys.readouterr().err


def test_recordings_of_an_arm_without_sensors_hold_no_temperature():
    (run, test, *_) = recorded()
    blind = without_temperatures(Recordings((run,), (test,), ('loaded',)))
    for before, after in ((run, blind.evidence[0]), (test, blind.test[0])):
        assert np.isnan(after.motion.temperature).all()
        np.testing.assert_array_equal(after.torque, before.torque)
        np.testing.assert_array_equal(after.motion.q, before.motion.q)
    assert blind.loaded == ('loaded',)


def test_of_one_recording_each_plant_has_another(small):
    case = EffectCase('alone', PLANT)
    whole, one = (effect_measure.prepared(replace(case, kind=kind), [], small).recordings
                  for kind in ('clean', 'alone'))
    (only,) = one.evidence
    assert only.name == whole.evidence[PLANT % len(whole.evidence)].name
    assert len(whole.evidence) > 1 and len(one.test) == len(whole.test)
