"""The ageing suite: its cases, its figures from rows made by hand, one small run."""

import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import ageing
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.run import Options, run_suites
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.torque.model_file import read_model


def test_every_effect_has_its_turn_on_seeds_of_its_own():
    jobs = ageing.ageing_jobs('r.yaml', None, 'lstm', None)
    cases = sorted((job[3] or '', job[4]) for job in jobs.values())
    assert cases == sorted([*((name, strength) for name in ageing.AGEING
                              for strength in ageing.STRENGTHS), *[('', 0.0)] * ageing.CLEAN])
    assert 'time_delay' in ageing.AGEING and 'external_contact' not in ageing.AGEING
    assert all(job[1] in seeds.BENCHMARK_PLANTS and job[2] in seeds.BENCHMARK_CASES
               for job in jobs.values())
    assert len({job[2] for job in jobs.values()}) == len(jobs)
    looked = ageing.ageing_jobs('r.yaml', 5, 'bayes', None, development=True)
    assert len(looked) == 5 and all(job[1] in seeds.DEVELOPMENT_PLANTS for job in looked.values())


def row(effect, strength=2.0, joints=(), first=None):
    return {'plant': 1, 'effect': effect, 'strength': strength, 'joints': list(joints),
            'first': first}


def test_what_was_told_is_counted_by_effect_and_strength():
    found = ageing.ageing_scores(dict(enumerate([
        row('torque_ripple', joints=['a'], first=[30.0, 'a']),
        row('torque_ripple', joints=['b'], first=[50.0, 'a']),
        row('torque_ripple', joints=['a']), row('base_tilt', 5.0, first=[40.0, 'c']),
        row(None, 0.0), row(None, 0.0, first=[9.0, 'a']),
        {'effect': 'backlash', 'strength': 5.0, 'skipped': 'too strong'}])), 'bayes')
    tilt, ripple = found['effects']
    assert (ripple['runs'], ripple['told'], ripple['own'], ripple['right']) == (3, 2, 2, 1)
    assert ripple['seconds'] == 40.0
    # A leaning base is of no single joint.
    assert (tilt['told'], tilt['own']) == (1, 0)
    assert found['clean'] == [2, 1, pytest.approx(2 * ageing.DURATION / 3600.0)]
    page = to_markdown(ageing.ageing_blocks(found))
    assert '| `torque_ripple` | 2 | 2 of 3 | 1 of 2 | 40 |' in page
    assert '| `base_tilt` | 5 | 1 of 1 | - | 40 |' in page
    assert '| all | 2 | 2 of 3 | 1 of 2 | 40 |' in page
    assert 'backlash (5)' in page and '50.0 % (1 of 2' in page and 'by `bayes`' in page


@pytest.fixture
def shipped(monkeypatch):
    """Look through the shipped model."""
    model = read_model(find_shared('ur10e', 'models'))
    monkeypatch.setattr(ageing, 'robot_and_models',
                        lambda path, plant, functions: (model.robot, {'ours': model}))


def test_an_arm_as_it_was_and_an_effect_too_strong_for_any_joint(shipped, monkeypatch, tmp_path):
    monkeypatch.setattr(ageing, 'DURATION', 4.0)
    monkeypatch.setattr(ageing, '_CASES', ((None, 0.0), ('torque_scale', 1e9)))
    page = run_suites('ageing', Options(methods=('bayes',), workers=0), tmp_path, 'the command',
                      lambda text: None)
    assert '0.0 % (0 of 1' in page and 'torque_scale (1e+09)' in page and 'by `bayes`' in page


def test_friction_that_grew_is_told_of_the_shipped_arm(shipped, monkeypatch):
    monkeypatch.setattr(ageing, 'DURATION', 60.0)
    found = ageing.measure_ageing('ur10e', seeds.SHIPPED_MODEL_PLANT, seeds.DEVELOPMENT_CASES[996],
                                  'coulomb_friction', 5.0, None, 'bayes')
    (joint,), (seconds, first) = found['joints'], found['first']
    assert first == joint and 20.0 < seconds < 60.0
