"""A diagnosis as one self-contained HTML page, for a phone, a desk and a printer."""

import datetime
import math
from html import escape
from pathlib import Path

import numpy as np

from .. import __version__
from ..residual.diagnosis import CONFIRMED
from .diagnosis_figures import errors_svg
from .effect_section import badges_html, effect_section, what, where
from .page_parts import html_image, html_table, STYLE
from .structure_section import structure_section
from .words import (as_sentence, items_html, label_html, name_words, number_text, range_text,
                    share_text)

# What every such page says, and by which it is known again.
MARK = 'Diagnosis of the torque model of'
# Structure below this share of the residual variance is told as nothing of weight.
_WEIGHTY = 0.05
# Nor is structure in an error of less than so many times what the model states of itself: in a
# short clean recording there is some, too.
_BEYOND = 1.5
# Without a finding, a model that leaves less than this share of a joint's error says so first.
_ADAPTED = 0.8
# A test error that grew by more than this is no chance.
_WORSE = 1.15


def _nothing(diagnosis):
    """Return the headline of a diagnosis without findings."""
    left = np.nan_to_num(diagnosis.unexplained)
    structured = left.max() >= _WEIGHTY
    if diagnosis.stated is not None:
        left = np.where(diagnosis.after > _BEYOND * diagnosis.stated, left, 0.0)
    if left.max() >= _WEIGHTY:
        return (f'No effect named, but the torque model does not fit {diagnosis.robot}: '
                f'look at joint {diagnosis.joints[int(left.argmax())]}')
    left_of = np.nan_to_num(diagnosis.after / diagnosis.before, nan=1.0)
    j = int(left_of.argmin())
    if left_of[j] < _ADAPTED:
        return (f'No effect named, but {diagnosis.robot} is no longer as its model says: at joint '
                f'{diagnosis.joints[j]} the model written has an error of '
                f'{diagnosis.after[j]:.3g} instead of {diagnosis.before[j]:.3g} Nm')
    if not np.isfinite(diagnosis.unexplained).all():
        return (f'No effect found; these recordings cannot tell whether the torque model fits '
                f'{diagnosis.robot}')
    if diagnosis.cannot_tell:
        return f'No missing effect found in {diagnosis.robot}, as far as these recordings tell'
    if structured:
        return (f'No missing effect found: the torque model fits {diagnosis.robot} as closely as '
                'it says')
    return f'No missing effect found: the torque model fits {diagnosis.robot}'


def headline(diagnosis):
    """Return the result in one plain-text sentence: the first of sentences()."""
    return sentences(diagnosis)[0]


def sentences(diagnosis):
    """
    Return a plain-text sentence per finding, confirmed ones first, or one that says none.

    Where the arm is rather another one than ailing, or a zero moved, that comes first.
    """
    findings = sorted(diagnosis.findings, key=lambda f: f.verdict != CONFIRMED)
    told = [_sentence(finding, diagnosis) for finding in findings] or [_nothing(diagnosis)]
    if diagnosis.moved_zero:
        told.insert(0, diagnosis.moved_zero)
    if diagnosis.another_state:
        told.insert(0, 'Rather another arm, or a model of another time, than so many defects: '
                       f'identify {diagnosis.robot} anew')
    return told


def _sentence(finding, diagnosis):
    """Return where, what, and the torque error before and after of its joint."""
    j = finding.main_joint(diagnosis.joints)
    of = '' if finding.joints == (diagnosis.joints[j],) else f' of {diagnosis.joints[j]}'
    named = _named(finding, diagnosis.joints)
    if not math.isfinite(diagnosis.after[j]):
        return f'{named}; torque error{of} not known, because no joint slid in the test'
    before, after = number_text(diagnosis.before[j]), number_text(diagnosis.after[j])
    error = f'stays {after}' if before == after else f'{before} → {after}'
    worse = ': worse on the test, so do not use the model before you know why' \
        if diagnosis.after[j] > _WORSE * diagnosis.before[j] else ''
    return f'{named}, torque error{of} {error} Nm{worse}'


def _named(finding, joints):
    """Return where and what, and what the recordings do not tell from it."""
    others = dict.fromkeys(
        name_words(other.name) + f' of {", ".join(other.joints)}' * (other.name == finding.name)
        for other in finding.alternatives)
    untold = f' (or {" or ".join(others)}: not told apart)' if others else ''
    return f'{where(finding, joints)}: {what(finding)}{untold}'


def _summary(diagnosis):
    """Return the findings in short, each linked to its section."""
    return items_html(f'{badges_html(f)} <a href="#effect-{k}">'
                      f'{escape(_named(f, diagnosis.joints))}</a>'
                      for k, f in enumerate(diagnosis.findings, 1))


def _tested(diagnosis):
    """Return what the errors were measured on, and what of it the old model knew already."""
    text = (f'Measured on <strong>{escape(diagnosis.tested_on)}</strong>, '
            if diagnosis.tested_on else 'Measured on data ')
    text += 'never used for fitting or choosing'
    if diagnosis.seen:
        text += (' what was found. But <strong>the model was identified from '
                 f'{escape(", ".join(diagnosis.seen))}</strong>: expect larger errors on other '
                 'recordings')
    elif diagnosis.refitted:
        text += (' what was found. The model was identified from all of these recordings; so '
                 'before and after are those of fits without this part, the one without and the '
                 'other with what was found')
    if diagnosis.left_out:
        text += (f'. Left out of it are {number_text(diagnosis.left_out)} s in which something '
                 'acted from outside, as told below')
    # Recordings that set a verdict are no test of it.
    return (f'{text}. Verdicts look at it once: what made its joint worse there is suspected, not '
            'confirmed.')


def _errors(diagnosis):
    most = diagnosis.noise_floor if diagnosis.noise_most is None else diagnosis.noise_most
    rows = [[label_html(name), number_text(before), number_text(after),
             range_text(*floor, number_text), range_text(*left, share_text)]
            for name, before, after, floor, left in zip(
                diagnosis.joints, diagnosis.before, diagnosis.after,
                zip(diagnosis.noise_floor, most),
                zip(diagnosis.unexplained, diagnosis.unexplained_most))]
    same = '' if diagnosis.findings or not np.array_equal(
        diagnosis.before, diagnosis.after, equal_nan=True) else \
        ' Nothing was added, so before and after are the same.'
    return (
        '<h2>Torque error per joint</h2>'
        f'<p>{_tested(diagnosis)}{same}</p>'
        + html_image(errors_svg(diagnosis), 'Torque error per joint before and after, with its '
                     'noise; the figures are in the table below')
        + html_table(['joint', 'before<br>[Nm]', 'after<br>[Nm]', 'noise<br>[Nm]',
                      'unex&shy;plained'], rows)
        + '<p class="quiet">Before and after: root mean square of measured less modelled torque '
        'while the joint surely slides; what it does at rest and while friction turns after a '
        'reversal is in neither. Unexplained: share of the remaining error\'s variance that no '
        'effect explains and that is no noise. The smaller figure is what still resembles itself '
        '0.1 to 0.5 s later, which neither noise of torque nor of acceleration does behind the '
        'motion filter; the larger '
        'one is all but white noise as large as samples differ from one to the next. Noise: the '
        'rest, so that structure or vibration as quick as noise counts as noise at its larger '
        'figure, and noise smoothed before it was recorded as structure at its smaller one. Not '
        'known: what was tested on is too short, or its error too uneven, to tell.</p>')


def _load(diagnosis):
    before, after = diagnosis.load_before, diagnosis.load_after
    top = '<h2>Error of the load estimate</h2>'
    if before is None or after is None:
        reason = f': {diagnosis.load_reason.rstrip(".")}' if diagnosis.load_reason else ''
        return f'{top}<p>Not known{escape(reason)}.</p>'
    count = f'{after.n} loaded recording{"s" * (after.n != 1)}'
    return (f'{top}<p>Root mean square over {count} with known loads; method bayes, which has '
            'nothing learned.</p>' + _load_table(['', 'before', 'after'], before, after))


def _load_table(head, before, after):
    rows = [['mass [kg]', number_text(before.mass_rmse), number_text(after.mass_rmse)]]
    if before.com_rmse is not None and after.com_rmse is not None:
        rows.append(['centre of mass [mm]', number_text(1e3 * before.com_rmse),
                     number_text(1e3 * after.com_rmse)])
    return html_table(head, rows)


def _not_asked(error):
    """Return in how many recordings a network was not asked, nothing where it was in all."""
    if not error.not_asked:
        return ''
    return (f'<p>In {error.not_asked} of {error.n} the network was not asked: it was trained '
            'beside temperatures, and not of every joint one is known. There lstm is bayes.</p>')


def _kept(kept):
    """Return the errors with the artefact shipped for the arm, nothing without one."""
    if kept is None:
        return ''
    return (f'<p>The same by method lstm, the default, with the artefact '
            f'<em>{escape(kept.name)}</em> as it is:</p>'
            + _load_table(['', 'before', 'after'], kept.load_before, kept.load_after)
            + _not_asked(kept.load_after))


def _learned(fine_tuning):
    """Return what became of the learned artefact, nothing where it was left as it is."""
    if fine_tuning is None:
        return ''
    text = (f'<h3>With the learned artefact</h3><p>The artefact <em>'
            f'{escape(fine_tuning.started_from)}</em> was fine-tuned from the better model into '
            '<code>learned</code>. ')
    before, after = fine_tuning.load_before, fine_tuning.load_after
    if before is None or after is None:
        return f'{text}What that did to the load estimate is not known.</p>'
    return (f'{text}Error of method lstm with the better model on the same recordings:</p>'
            + _load_table(['', 'artefact<br>as it was', 'fine-<br>tuned'], before, after)
            + _not_asked(after))


def _left(name, least, most):
    if not math.isfinite(least):
        return f'{label_html(name)}: not known.'
    return (f'{label_html(name)}: {range_text(least, most, share_text)} of the remaining error\'s '
            'variance is structure that no effect explains.')


def _remains(diagnosis):
    left = [_left(name, least, most) for name, least, most in zip(
        diagnosis.joints, diagnosis.unexplained, diagnosis.unexplained_most)
        if not least < _WEIGHTY]
    left += [escape(sentence) for sentence in diagnosis.remains]
    none = (f'<p>Nothing of weight: less than {100 * _WEIGHTY:.0f} % at every joint is surely '
            'structure.</p>')
    text = '<h2>What remains unexplained</h2>' + (items_html(left) if left else none)
    if diagnosis.cannot_tell:
        text += '<h3>What these recordings cannot tell</h3>' + items_html(
            escape(as_sentence(sentence)) for sentence in diagnosis.cannot_tell)
    return text


def _origin(diagnosis):
    recordings = items_html(map(label_html, diagnosis.recordings)) if diagnosis.recordings else ''
    kept = '' if diagnosis.fine_tuning else (
        '<p>When this was written the learned artefact was still being fine-tuned.</p>'
        if diagnosis.training else
        '<p>Learned artefacts (method lstm) were left as they are and run with the better model.'
        '</p>')
    return (
        '<h2>Recordings and method</h2>' + recordings
        + f'<p>Tested on: {escape(diagnosis.tested_on) or "not stated"}.</p>'
        '<p>The measured torque less the model\'s is compared with every physical effect the tool '
        'knows. An effect enters the model only if it predicts blocks of data that its fit has '
        'not seen better than without it, by more than chance would give over all hypotheses '
        'tried. It is <em>confirmed</em> where that still holds beside all others; it is '
        '<em>suspected</em> where it does not surely, where its joint has something unknown too, '
        'or where its joint got worse in the test. What is suspected is in the model as well, and '
        'in every error above: its torque was found, only its name is in doubt. A gain '
        f'of one nat means that the data are 2.7 times as likely.</p>{kept}'
        f'<p class="quiet">hand_load_estimator {__version__}, {datetime.date.today()}, '
        f'{number_text(diagnosis.seconds)} s of computing.</p>')


def page(diagnosis):
    """Return a Diagnosis as one HTML text that needs no other file."""
    head = escape(headline(diagnosis))
    effects = ''.join(effect_section(k, finding, diagnosis.joints)
                      for k, finding in enumerate(diagnosis.findings, 1))
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{head}</title><style>{STYLE}</style></head><body>'
        f'<p class="quiet">{MARK} {escape(diagnosis.robot)}</p>'
        f'<h1>{head}</h1>' + (_summary(diagnosis) if diagnosis.findings else '')
        + _errors(diagnosis) + _load(diagnosis) + _kept(diagnosis.kept)
        + _learned(diagnosis.fine_tuning)
        + structure_section(diagnosis) + effects + _remains(diagnosis) + _origin(diagnosis)
        + '</body></html>\n')


def write_page(path, diagnosis):
    """Write a Diagnosis as one self-contained HTML file."""
    Path(path).write_text(page(diagnosis), encoding='utf-8')
