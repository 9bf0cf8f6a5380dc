"""The report of a diagnosis as one page: its headline, its words, no other file needed."""

import base64
import dataclasses
from xml.etree import ElementTree

from diagnosis_report_helpers import (found, JOINTS, nothing, Reader, ripple, spring, swing,
                                      tuned, unknown)
import numpy as np
import pytest

from hand_load_estimator.report import diagnosis_json, diagnosis_page
from hand_load_estimator.residual.diagnosis import (Alternative, Evidence, Finding, LoadError,
                                                    Picture, SUSPECTED, UNKNOWN)
from hand_load_estimator.residual.tracing.confusable import NO_MOTION


@pytest.fixture(scope='module', name='read')
def read_page(tmp_path_factory):
    """Return the page of the three findings as a browser reads it."""
    path = tmp_path_factory.mktemp('report') / 'report.html'
    diagnosis_page.write_page(path, found())
    return Reader(path.read_text(encoding='utf-8'))


def test_headline_names_joint_effect_and_errors():
    assert diagnosis_page.headline(found()) == \
        'Joint elbow_joint: torque ripple found, torque error 2.41 → 1.33 Nm'


@pytest.mark.parametrize(('finding', 'begins'), [
    (spring(), 'Joints shoulder_lift_joint and wrist_1_joint: gravity spring may have changed '
               '(or link inertia or cable drag: not told apart), '
               'torque error of shoulder_lift_joint 5.20 → 3.10 Nm'),
    (dataclasses.replace(ripple(), name='time_delay', joints=JOINTS),
     'All joints: time delay found, torque error of elbow_joint 2.41 → 1.33 Nm'),
    (unknown(), 'Joint wrist_2_joint: an effect of unknown kind suspected')])
def test_headline_of_other_findings(finding, begins):
    diagnosis = dataclasses.replace(found(), findings=(finding,))
    assert diagnosis_page.headline(diagnosis).startswith(begins)


def test_headline_prefers_what_is_confirmed():
    diagnosis = dataclasses.replace(found(), findings=(unknown(), ripple()))
    assert 'torque ripple found' in diagnosis_page.headline(diagnosis)


def test_every_finding_has_a_sentence():
    diagnosis = dataclasses.replace(found(), findings=(unknown(), ripple(), spring()))
    told = diagnosis_page.sentences(diagnosis)
    assert len(told) == 3 and told[0] == diagnosis_page.headline(diagnosis)
    assert any('gravity spring may have changed (or link inertia or cable drag: not told apart)'
               in text for text in told)
    assert any('of unknown kind suspected' in text for text in told)


def test_that_it_is_rather_another_arm_leads():
    diagnosis = dataclasses.replace(found(), another_state=True)
    assert diagnosis_page.headline(diagnosis).startswith('Rather another arm')
    assert diagnosis_page.sentences(diagnosis)[1:] == diagnosis_page.sentences(found())


def test_a_worse_error_is_a_warning():
    worse = dataclasses.replace(found(), after=2.0 * np.array(found().before))
    assert 'worse on the test' in diagnosis_page.headline(worse)
    assert 'worse' not in diagnosis_page.headline(found())


def test_headline_does_not_call_structure_a_fit():
    assert diagnosis_page.headline(nothing()).startswith('No missing effect found')
    left = np.array([0.0, 0.0, 0.4, 0.0, 0.0, 0.0])
    doubtful = diagnosis_page.headline(dataclasses.replace(nothing(), unexplained=left))
    assert 'does not fit' in doubtful and 'elbow_joint' in doubtful
    lost = dataclasses.replace(nothing(), unexplained=np.full(6, np.nan))
    assert 'cannot tell' in diagnosis_page.headline(lost)
    assert 'Nothing of weight' not in diagnosis_page.page(lost)


@pytest.mark.parametrize('times, begins', [
    (1.1, 'No missing effect found: the torque model fits ur10e as closely as it says'),
    (2.0, 'No effect named, but the torque model does not fit ur10e: look at joint elbow_joint')])
def test_structure_within_what_the_model_states_is_no_misfit(times, begins):
    left = np.array([0.0, 0.3, 0.2, 0.0, 0.0, 0.0])
    stated = nothing().after / [1.0, 1.1, times, 1.0, 1.0, 1.0]
    known = dataclasses.replace(nothing(), unexplained=left, stated=stated)
    assert diagnosis_page.headline(known) == begins
    assert diagnosis_json.diagnosis_content(known)['stated'] == pytest.approx(stated)


def test_page_needs_nothing_from_outside(read):
    assert read.open == []
    for key, value in read.attributes:
        if key in ('src', 'href'):
            assert value.startswith(('data:', '#effect-')), value
    assert ('name', 'viewport') in read.attributes
    assert '@media print' in diagnosis_page.page(nothing())


def test_every_picture_is_a_drawn_figure_with_a_text_beside_it(read):
    assert len(read.images) == 1 + 4
    for image in read.images:
        root = ElementTree.fromstring(base64.b64decode(image['src'].partition('base64,')[2]))
        assert root.tag.endswith('svg') and len(list(root.iter())) > 100
        assert image['alt']


@pytest.mark.parametrize('words', [
    'never used for fitting or choosing', 'the recording tuesday_fast',
    'what made its joint worse there is suspected',
    'shoulder_lift_joint5.203.101.2231 %',
    'mass [kg]0.4120.122', 'centre of mass [mm]14.16.20',
    '1412 ± 192 nats', 'Needed: 11.2 nats, with 143 hypotheses tried',
    'Next best explanation: cable drag, 655 nats behind',
    'cannot tell it from link inertia (2.50 ± 8.00 nats behind) and cable drag of '
    'shoulder_lift_joint (12.5 ± 18.0 nats behind).', 'by a full turn, slowly.',
    'What is suspected is in the model as well',
    'had this effect already', 'depends on velocity.',
    'amplitude2.710 ± 0.062 Nm', '0.820 ± 0.024 rad (47.0 ± 1.4°)',
    '0.06280 rad (3.598°), no interval',
    '(−3.10 ± 0.80)·10−5 Nm s/(rad K2)', 'Cannot tell the temperature of Coulomb from that',
    'slow change over time', 'monday_warm', '71 % at elbow_joint'])
def test_page_says(read, words):
    assert words in read.words()


def test_page_says_that_a_rival_is_ahead():
    finding = found().findings[0]
    evidence = dataclasses.replace(finding.evidence, margin=-676.0)
    said = diagnosis_page.page(dataclasses.replace(
        found(), findings=(dataclasses.replace(finding, evidence=evidence),)))
    assert 'Next best explanation: cable drag, 676 nats ahead.' in said
    assert '−676' not in said


def test_page_says_why_a_rival_close_behind_is_no_alternative():
    finding = found().findings[0]
    impossible = dataclasses.replace(finding.evidence, margin=0.85, next_possible=False)
    page = diagnosis_page.page(dataclasses.replace(
        found(), findings=(dataclasses.replace(finding, evidence=impossible),)))
    assert ('Next best explanation: cable drag, 0.850 nats behind; with the figures that fit it '
            'is impossible or too small to matter.') in Reader(page).words()


def test_page_says_where_the_gain_chose_a_shape():
    chosen = 'the shape of the formula was chosen by the same gain'
    # The knee of the last is estimated.
    for name, told in (('torque_ripple', True), ('torque_offset', False),
                       ('temperature_dependent_viscous_friction', False)):
        finding = dataclasses.replace(found().findings[0], name=name, parameters={})
        page = diagnosis_page.page(dataclasses.replace(found(), findings=(finding,)))
        assert (chosen in page) == told


def left_over(parameters):
    """Return structure that follows time only, with a picture and no fit."""
    time = np.linspace(0.0, 9.0, 200)
    zero = np.zeros(200)
    return Finding(
        UNKNOWN, ('wrist_2_joint',), parameters, np.zeros(6),
        Evidence(np.nan, np.nan, np.nan, 18, 143, 0.4), (), 'no effect of the vocabulary fits',
        False, SUSPECTED, (Picture('wrist_2_joint', 'time [s]', time, np.sin(9.0 * time), zero,
                                   zero, zero, zero),), ('time',))


def test_what_was_not_fitted_claims_no_fit_and_no_motion():
    finding = left_over({})
    page = diagnosis_page.page(dataclasses.replace(found(), findings=(finding,)))
    read = Reader(page)
    words = read.words()
    assert read.images[-1]['alt'].endswith('against time [s], nothing fitted')
    assert 'Nothing was fitted: this is what is left after 143 hypotheses tried.' in words
    assert 'not known nats' not in words and 'A motion that would' not in words
    assert 'It follows none of position' in words and 'rings' not in words
    assert 'No effect of the vocabulary fits.' in words
    ringing = left_over({'frequency': (1.43, np.nan, 'Hz')})
    assert 'it rings with one frequency.' in Reader(diagnosis_page.page(
        dataclasses.replace(found(), findings=(ringing,)))).words()


def test_what_rings_claims_no_fit_and_tells_its_evidence():
    words = Reader(diagnosis_page.page(dataclasses.replace(
        found(), findings=(swing(),)))).words()
    assert 'gain 269 ± 46.0 nats' in words and '131 were needed' in words
    assert 'No effect was fitted' in words and '62 %' in words
    assert 'the model with it gains' not in words and 'No other explanation' not in words


def test_where_no_motion_separates_none_is_offered():
    finding = dataclasses.replace(spring(), advice=f'{NO_MOTION} them')
    words = Reader(diagnosis_page.page(dataclasses.replace(found(), findings=(finding,)))).words()
    assert 'No motion of the arm in this mounting separates them.' in words
    assert 'A motion that would' not in words


def test_page_of_an_empty_diagnosis_reads_well():
    words = Reader(diagnosis_page.page(nothing())).words()
    assert 'No missing effect found' in words
    assert 'Not known: no loaded recordings with known loads were given.What' in words
    assert 'Nothing of weight' in words
    assert 'nan' not in words and 'None' not in words


def test_a_model_that_was_adapted_without_a_name_says_so_first():
    changed = dataclasses.replace(nothing(), before=nothing().after * [1.0, 9.0, 1, 1, 1, 1])
    (told,) = diagnosis_page.sentences(changed)
    assert told == (f'No effect named, but ur10e is no longer as its model says: at joint '
                    f'{JOINTS[1]} the model written has an error of 1.25 instead of 11.2 Nm')
    assert 'fits ur10e' in diagnosis_page.headline(nothing())


def test_page_says_what_became_of_the_artefact(read):
    assert 'were left as they are and run with the better model' in read.words()
    words = Reader(diagnosis_page.page(tuned())).words()
    assert 'were left as they are' not in words
    assert 'The artefact the <first> was fine-tuned from the better model into learned.' in words
    assert 'mass [kg]0.4120.122' in words and 'mass [kg]0.09800.0870' in words
    assert 'centre of mass [mm]5.104.80' in words
    assert 'was not asked' not in words
    silent = Reader(diagnosis_page.page(tuned(after=LoadError(0.09, 0.005, 12, 5)))).words()
    assert 'In 5 of 12 the network was not asked: it was trained beside temperatures' in silent
    unloaded = Reader(diagnosis_page.page(tuned(None, None))).words()
    assert 'What that did to the load estimate is not known.' in unloaded


def test_page_says_where_the_interval_of_a_searched_parameter_comes_from():
    def words(std):
        finding = dataclasses.replace(ripple(), parameters={'periods': (63.0, std, '1/turn')})
        return Reader(diagnosis_page.page(dataclasses.replace(
            found(), findings=(finding,)))).words()
    assert 'Interval of periods: from how fast the gain falls' in words(0.01)
    assert 'Interval of' not in words(np.nan) and 'no interval' in words(np.nan)


def test_names_are_text_not_markup():
    evil = '<b>$x_{</b>&'
    finding = dataclasses.replace(
        ripple(), joints=(evil,), parameters={evil: (1.0, 0.1, evil)}, advice=evil,
        alternatives=(Alternative(evil, (evil, evil), 1.0, 1.0),), explained=np.ones(1),
        pictures=(dataclasses.replace(ripple().pictures[0], joint=evil, variable=evil),))
    diagnosis = dataclasses.replace(
        found(), robot=evil, joints=(evil,), findings=(finding,), tested_on=evil,
        recordings=(evil,), cannot_tell=(evil,), remains=(evil,), before=np.ones(1),
        after=np.ones(1), noise_floor=np.ones(1), unexplained=np.ones(1),
        load_before=None, load_reason=evil)
    text = diagnosis_page.page(diagnosis)
    assert '<b>' not in text
    assert Reader(text).open == []


def test_noise_and_structure_are_told_with_their_limits():
    most = np.array([1.2, 1.8, 1.0, 0.4, 0.4, np.nan])
    diagnosis = dataclasses.replace(found(), noise_most=most)
    text = Reader(diagnosis_page.page(diagnosis)).words()
    assert '1.22 to 1.80' in text and '31 % to 85 %' in text
    assert 'that repeats' not in text and 'perfect model' not in text
    content = diagnosis_json.diagnosis_content(diagnosis)
    assert content['noise_most'][1] == 1.8 and content['noise_most'][5] is None
    assert content['unexplained_most'][1] == pytest.approx(0.845, abs=1e-3)


def test_what_is_not_known_is_told_so():
    lost = np.full(6, np.nan)
    blank = dataclasses.replace(ripple().pictures[0], **{
        name: np.full(26, np.nan) for name in ('mean', 'std', 'curve', 'low', 'high')})
    finding = dataclasses.replace(ripple(), explained=lost, pictures=(blank,),
                                  parameters={'amplitude': (np.nan, np.nan, 'Nm')})
    diagnosis = dataclasses.replace(found(), before=lost, after=lost, noise_floor=lost,
                                    unexplained=lost, findings=(finding,))
    words = Reader(diagnosis_page.page(diagnosis)).words()
    assert 'not known' in words and 'nan' not in words.lower()


def test_the_same_diagnosis_gives_the_same_page():
    assert diagnosis_page.page(found()) == diagnosis_page.page(found())
