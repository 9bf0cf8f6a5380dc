"""The suite of measured recordings: its errors, who is judged by what, and one set measured."""

import os
from pathlib import Path

import numpy as np
import pytest
from ros_helpers import ROOT

from hand_load_estimator.benchmark import offline, real
from hand_load_estimator.benchmark.contestants import (Contestant, NOMINAL, OUR_MODEL, TEXTBOOK,
                                                       TEXTBOOK_CAREFUL)
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.real_course import CourseOf
from hand_load_estimator.benchmark.real_page import real_blocks
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.method import Belief

METHODS = 'bayes', 'gp_bayes', 'gp_bayes_known_load'
DATA = Path(os.environ.get('HAND_LOAD_DATA', ROOT.parent / 'shared' / 'data'))


def course(**told):
    return {'bayes': {'changes': 0, 'worst': None, 'inside': None, 'mismatch': 0.0, **told},
            NOMINAL: {'changes': None, 'worst': 9.0, 'inside': 0.5, 'mismatch': None}}


def test_the_error_on_a_recording_is_less_what_the_model_was_identified_with():
    nominal = [[150.0, 1.0]] * 5
    runs = {'real_a': [{'set': 'a', 'run': 'r', 'truth': 150.0, 'rated': 300.0,
                        'methods': {'bayes': [[144.0, 5.0], [156.0, 5.0], None, None,
                                              [153.0, 2.0]], NOMINAL: nominal,
                                    'figaroh': [None, None, None, None, [151.5, 1.0]]},
                        'course': course(changes=3, worst=30.0, inside=0.8, mismatch=0.1)},
                       {'set': 'a', 'run': 's', 'truth': 0.0, 'rated': 10.0,
                        'methods': {'bayes': [[0.4, 0.1], None, None, None, [0.3, 0.1]]},
                        'course': course()}]}
    content = real.real_scores(runs)
    bayes, rival = content['methods']['bayes'], content['methods']['figaroh']
    assert bayes == {
        'runs': 2, 'median_percent': pytest.approx(2.0), 'worst_percent': pytest.approx(3.0),
        'possible_percent': pytest.approx(2.0), 'inside': 0.5,
        'percent_at': {'0.5 s': pytest.approx(3.0), '1 s': pytest.approx(2.0), '3 s': None,
                       '10 s': None, 'end': pytest.approx(2.0)},
        'later_percent': pytest.approx(10.0), 'time_inside': pytest.approx(0.8),
        'mismatch': pytest.approx(0.05), 'changes': 3}
    assert rival['percent_at']['end'] == pytest.approx(0.5) and rival['changes'] is None
    page = to_markdown(real_blocks(content))
    assert '+3.000 (2.000)' in page and '| -6.00 / +6.00 / - / - |' in page
    assert '| bayes | 2 | 3.00 | 2.00 | - | - | 2.00 | 2.00 | 3.00 | 10.0 |' in page
    assert '| bayes | 50 | 80.0 | 3 | 5.0 |' in page and '| figaroh | 100 | - | - | - |' in page
    assert '| load changes counted | true [kg] | bayes |' in page, 'only ours count any'


def test_a_mass_below_zero_counts_as_zero_in_a_column_of_its_own():
    """A rival that names possible bodies only would have half of its errors for nothing."""
    def run(name, truth, mass):
        return {'set': 'a', 'run': name, 'truth': truth, 'rated': 10.0, 'course': {},
                'methods': {'bayes': [None] * 4 + [[mass, 1.0]]}}

    runs = {'real_a': [run('r', 0.0, -0.5), run('s', 0.0, 0.2), run('t', 2.0, 1.7)]}
    bayes = real.real_scores(runs)['methods']['bayes']
    assert bayes['median_percent'] == pytest.approx(3.0)
    assert bayes['possible_percent'] == pytest.approx(2.0)


def test_a_course_is_judged_later_than_one_second_and_counts_all_the_while():
    """What is over at the end is no less told: two of ten samples were 2 kg off."""
    class Jumping:
        changes, mismatch, at = 4, '', 0

        def update(self, sample, prediction):
            self.mismatch = 'torque' if self.at < 3 else ''
            self.at += 1
            return Belief(np.r_[2.0 if self.at in (1, 6, 7) else 0.1, np.zeros(9)],
                          0.01 * np.eye(10))

    contestant, followed = Contestant(None, lambda _: Jumping()), CourseOf(0.0)
    for k in range(12):
        followed.update(contestant.update(None), k >= 2)
    assert followed.told(contestant) == {'changes': 4, 'worst': 2.0, 'inside': pytest.approx(0.8),
                                         'mismatch': pytest.approx(0.25)}
    assert CourseOf(0.0).told(Contestant(None, lambda _: object())) == {
        'changes': None, 'worst': None, 'inside': None, 'mismatch': None}


def test_where_nothing_is_held_ours_are_judged_as_rivals_are():
    """What is published never weighs less than nothing: half of noise would be gone."""
    class Noisy:
        tared = np.zeros(10)

        def belief(self):
            return Belief(np.r_[-0.01, np.zeros(9)], 1e-4 * np.eye(10))

        def update(self, sample, prediction):
            return self.belief()

    racing = {'bayes': Contestant(None, lambda _: Noisy())}
    beliefs = {name: contestant.update(None) for name, contestant in racing.items()}
    assert beliefs['bayes'].mean[0] >= 0.0
    assert real.judged(racing, beliefs, 0.0)['bayes'].mean[0] == -0.01
    assert real.judged(racing, beliefs, 2.6) is beliefs


def test_data_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match='--data'):
        real.real_jobs(tmp_path / 'none', None, tmp_path, None)
    (tmp_path / 'panda').mkdir()
    assert list(real.real_jobs(tmp_path, None, tmp_path, None)) == ['real_panda']


@pytest.mark.skipif(not (DATA / 'staubli_tx40').is_dir(), reason=f'no recordings at {DATA}')
def test_a_measured_set_is_identified_and_estimated(tmp_path, monkeypatch):
    monkeypatch.setattr(offline, '_identify', lambda name: lambda robot, run: (
        np.full(10, float(len(run.stamp))), np.full(10, 0.5)))
    (found,) = real.measure_set('staubli_tx40', str(DATA), str(tmp_path), METHODS, ('figaroh',))
    # Nothing is learned there beside a load of its own.
    assert set(found['methods']) == {'bayes', 'gp_bayes', NOMINAL, TEXTBOOK, TEXTBOOK_CAREFUL,
                                     OUR_MODEL, 'figaroh'}
    assert found['methods']['gp_bayes'][-1] != found['methods']['bayes'][-1]
    # Asked at 3 s, at 10 s where the run is that long, and at the end.
    early, late = found['methods']['figaroh'][2], found['methods']['figaroh'][-1]
    assert found['methods']['figaroh'][:2] == [None, None]
    assert early[1] == late[1] == 0.5 and 0.0 < early[0] < late[0]
    assert found['truth'] == 0.0 and found['rated'] == 1.7
    mass, std = found['methods']['bayes'][-1]
    assert abs(mass) < 1.7 and 0.0 < std < 1.0
    assert set(found['course']) == set(found['methods']) - {'figaroh'}
    ours, plain = found['course']['bayes'], found['course'][TEXTBOOK]
    assert ours['changes'] == 0 and ours['mismatch'] is not None and plain['changes'] is None
    assert 0.0 <= plain['inside'] < ours['inside'] <= 1.0
    # The nominal model knows no friction: its rival is not given the identified one by mistake.
    assert found['methods'][NOMINAL][-1] != found['methods'][TEXTBOOK][-1]
