"""Where the residual lives, in the report: JSON without surprises, maps and words that agree."""

import base64
import dataclasses
import json
from xml.etree import ElementTree

from diagnose_helpers import assert_structure
from diagnosis_report_helpers import found, JOINTS, Reader
import numpy as np
import pytest

from hand_load_estimator.report import diagnosis_json, diagnosis_page
from hand_load_estimator.report.structure_figures import pairs_svg, variables_svg
from hand_load_estimator.residual.diagnosis import Structure
from hand_load_estimator.residual.doubts.not_named import not_named, sentences_on, SMALLEST
from hand_load_estimator.residual.measured.structure import ORDER

ELBOW, WRIST = 2, 4


def side(share):
    """Return a Structure: the elbow follows position, wrist 2 the elbow; wrist 3 stands still."""
    shares = {name: np.array([0.0, -0.3, 0.01, 0.004, 0.0, np.nan]) for name in ORDER}
    chance = {name: np.full(6, 0.02) for name in ORDER}
    shares['position'][ELBOW], shares['temperature'][:] = share, np.nan
    pairs = np.full((6, 6), -0.1)
    pairs[ELBOW, ELBOW], pairs[WRIST, ELBOW] = share, 0.5 * share
    rms = np.array([1.3, 1.2, 1.0 + 1.4 * share, 0.4, 0.4, np.nan])
    return Structure(rms, np.array([1.3, 1.2, 1.0, 0.3, 0.4, np.nan]), shares, chance, pairs,
                     np.full((6, 6), 0.02))


def diagnosis(before=1.04, after=0.03):
    """Return a Diagnosis with Structures whose share of the elbow's position is stated."""
    first = side(before)
    return dataclasses.replace(
        found(), structure=(first, first if after is None else side(after)))


def words(of):
    return Reader(diagnosis_page.page(of)).words()


def written(svg):
    """Return the texts in an SVG; matplotlib names the text it draws in comments."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    return [node.text.strip() for node in ElementTree.fromstring(svg, parser).iter()
            if node.tag is ElementTree.Comment]


def test_structure_without_a_name_is_told_with_what_it_follows():
    left = side(0.6), side(0.6)
    told = not_named(left, JOINTS)
    assert told[ELBOW] == (('position', 0.6),)
    assert told[WRIST] == (('the motion of elbow_joint', 0.3),)
    # Shares count of what is left; those of a Structure count of what there was before.
    fewer = not_named((side(0.6), side(0.3)), JOINTS)[ELBOW]
    was, now = (1.0 + 1.4 * share for share in (0.6, 0.3))
    assert fewer == (('position', pytest.approx(0.3 * (was ** 2 - 1.0) / (now ** 2 - 1.0))),)
    assert not_named((side(0.6), side(0.02)), JOINTS)[ELBOW] == ()
    # No more than chance, too little for a sentence, not known.
    assert [told[j] for j in (0, 1, 3, 5)] == [()] * 4
    assert sentences_on(left, JOINTS) == (
        'elbow_joint: structure not named: follows position (60 %)',
        'wrist_2_joint: structure not named: follows the motion of elbow_joint (30 %)')
    both = diagnosis(before=0.6, after=0.6)
    content = diagnosis_json.diagnosis_content(both)['not_named']
    assert content[ELBOW] == [{'follows': 'position', 'share': 0.6}] and content[0] == []
    assert diagnosis_json.diagnosis_content(found())['not_named'] is None


def test_json_has_every_variable_and_pair_with_its_chance():
    content = diagnosis_json.diagnosis_content(diagnosis())
    structure = content['structure']
    assert_structure(structure, 6)
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert structure['before']['share']['position'] == [0.0, 0.0, 1.0, 0.004, 0.0, None]
    assert structure['after']['share']['position'][ELBOW] == pytest.approx(0.03)
    assert structure['before']['pairs'][WRIST][ELBOW] == pytest.approx(0.52)
    assert structure['before']['pairs_chance'][WRIST][ELBOW] == 0.02
    assert structure['before']['structured'][3] == pytest.approx(1.0 - 0.75 ** 2)
    assert diagnosis_json.diagnosis_content(found())['structure'] is None


def test_the_page_says_what_each_joint_follows():
    text = words(diagnosis())
    assert 'Where the residual lives' in text
    assert 'elbow_joint: position (100 %); after: position (3 %).' in text
    assert 'wrist_2_joint: the motion of elbow_joint (52 %); after: nothing beyond chance.' in text
    assert 'wrist_1_joint and wrist_3_joint: nothing beyond chance.' in text
    assert 'elbow_joint2.461.041.0083 % → 8 %' in text
    assert 'nan' not in text
    assert 'Where the residual lives' not in words(found())


def test_an_unchanged_model_has_one_map_and_no_after():
    same = diagnosis(after=None)
    text = words(same)
    assert 'elbow_joint: position (100 %).' in text and '; after:' not in text
    assert 'elbow_joint2.462.461.0083 %' in text and '→ 83' not in text
    for svg in (variables_svg(JOINTS, *same.structure), pairs_svg(JOINTS, *same.structure)):
        assert [text for text in written(svg) if 'structure' in text] == [
            'before, % of structure']


def test_maps_show_what_is_beyond_chance_and_what_cannot_be_told():
    first, second = diagnosis().structure
    drawn = written(variables_svg(JOINTS, first, second))
    assert {'before, % of structure', 'after, % of structure', 'position', 'time', 'elbow',
            'shoulder lift'} <= set(drawn)
    assert drawn.count('100') == 1 and drawn.count('3') == 1
    # No temperatures; no motion of wrist 3.
    assert drawn.count('?') == 2 * (6 + len(ORDER) - 1)
    drawn = written(pairs_svg(JOINTS, first, second))
    assert drawn.count('100') == 1 and drawn.count('52') == 1
    assert 0.0 < SMALLEST < 0.03


def test_the_maps_are_in_the_page():
    images = Reader(diagnosis_page.page(diagnosis())).images
    maps = [image for image in images if image['alt'].startswith('Map of joint')]
    assert len(maps) == 2 and len(images) == 7
    for image in maps:
        assert b'<svg' in base64.b64decode(image['src'].partition('base64,')[2])
