"""Seed ranges do not meet, and nothing reads objects from files that could run code."""

from itertools import combinations
import re

import pytest
from ros_helpers import ROOT

from hand_load_estimator import seeds
from hand_load_estimator.benchmark.suites import cases_of, SUITES

RANGES = {name: value for name, value in vars(seeds).items() if isinstance(value, range)}
SOURCES = sorted((ROOT / 'hand_load_estimator').rglob('*.py'))


def test_there_are_ranges_for_every_purpose():
    assert {'TRAINING', 'VALIDATION', 'CALIBRATION', 'BENCHMARK_PLANTS', 'BENCHMARK_CASES',
            'DEVELOPMENT_PLANTS', 'DEVELOPMENT_CASES', 'FINAL_PLANTS',
            'FINAL_CASES', 'FINAL_UNDECLARED_PLANTS', 'FINAL_UNDECLARED_CASES',
            'FINAL_EFFECT_PLANTS', 'FINAL_EFFECT_CASES', 'FINAL_CHANGE_PLANTS',
            'FINAL_CHANGE_CASES'} <= set(RANGES)


@pytest.mark.parametrize('one, other', list(combinations(sorted(RANGES), 2)))
def test_ranges_are_disjoint(one, other):
    a, b = RANGES[one], RANGES[other]
    assert a.step == b.step == 1 and len(a) and len(b)
    assert a.stop <= b.start or b.stop <= a.start


def test_the_shipped_models_plant_is_in_no_range():
    assert not any(seeds.SHIPPED_MODEL_PLANT in span for span in RANGES.values())


@pytest.mark.parametrize('name', SUITES)
def test_suites_use_their_own_ranges_and_have_seeds_enough(name):
    suite = SUITES[name]
    kind = 'DEVELOPMENT' if name == 'development' else 'BENCHMARK'
    assert set(suite.plant_seeds) <= set(RANGES[f'{kind}_PLANTS'])
    assert suite.case_seeds == RANGES[f'{kind}_CASES']
    assert suite.plants <= len(suite.plant_seeds) and suite.count <= len(suite.case_seeds)


@pytest.mark.parametrize('name', [n for n in SUITES if n != 'development'])
def test_more_cases_than_a_suite_has_are_on_seeds_that_it_never_used(name):
    count, final = SUITES[name].count, 'FINAL_UNDECLARED' if name == 'undeclared' else 'FINAL'
    for wanted, kind in ((count, 'BENCHMARK'), (max(2000, count + 1), final)):
        for plant, part in cases_of(SUITES[name], wanted):
            assert plant in RANGES[f'{kind}_PLANTS']
            assert set(part) <= set(RANGES[f'{kind}_CASES'])
    assert all(plant in seeds.DEVELOPMENT_PLANTS
               for plant, _ in cases_of(SUITES[name], 2000, development=True))


def test_the_base_suite_is_large_enough():
    assert SUITES['base'].plants >= 20 and SUITES['base'].count >= 200


def test_training_fits_its_ranges():
    from hand_load_estimator.learning.training import Recipe
    recipe = Recipe()
    assert recipe.sequences <= len(seeds.TRAINING)
    assert recipe.calibration <= len(seeds.CALIBRATION)
    assert recipe.validation <= len(seeds.VALIDATION)


@pytest.mark.parametrize('pattern', [
    r'\bpickle\b', r'\btorch\.load\b', r'\btorch\.save\b', r'yaml\.load\((?![^)]*Safe)',
    r'yaml\.(unsafe_load|full_load)', r'allow_pickle\s*=\s*True', r'\beval\(', r'\bexec\('])
def test_no_file_is_read_in_a_way_that_runs_code(pattern):
    found = [str(path.relative_to(ROOT)) for path in SOURCES
             if re.search(pattern, path.read_text(encoding='utf-8'))]
    assert len(SOURCES) > 50 and not found


def test_the_pattern_finds_an_unsafe_loader():
    unsafe = r'yaml\.load\((?![^)]*Safe)'
    assert re.search(unsafe, 'yaml.load(text, Loader=yaml.Loader)')
    assert not re.search(unsafe, 'yaml.load(text, Loader=yaml.SafeLoader)')
