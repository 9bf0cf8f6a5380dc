"""A diagnosis as one self-contained HTML page, for a phone, a desk and a printer."""

import datetime
import math
import re
from html import escape
from pathlib import Path

import numpy as np

from .. import __version__
from ..effects import EFFECTS
from ..residual.confusable import NO_MOTION
from ..residual.diagnosis import CONFIRMED, UNKNOWN
from .diagnosis_figures import effect_svg, errors_svg
from .page_parts import html_image as _image, html_table as _table, STYLE

# Structure below this share of the residual variance is told as nothing of weight.
_WEIGHTY = 0.05
# Findings that are no entry of the vocabulary of joint effects.
_PHYSICS = {
    UNKNOWN: 'None of the effects in this tool\'s vocabulary fits. The torque error is not noise: '
             'it repeats with the variables shown below. A person who knows the drive should '
             'look at the picture before anything is added to the model.',
    'link_inertia': 'Mass, centre of mass or inertia of a link differ from the model\'s.',
    'external_contact': 'Something outside pushed the hand for a limited time, with one force in '
                        'the axes of the base.',
    'load_change': 'For a time another load hung on the hand than the recording declares. The '
                   'mass is the change: negative where the declared load, or part of it, is gone.'}


def _figure(number):
    """Return a number to three significant digits, `not known` for None and NaN."""
    if number is None or not math.isfinite(number):
        return 'not known'
    if abs(number) >= 999.5:
        return f'{number:.0f}'.replace('-', '−')
    text = f'{number:#.3g}'.rstrip('.') if abs(number) >= 1e-3 else f'{number:.2g}'
    return text.replace('-', '−')


def _share(fraction):
    if not math.isfinite(fraction):
        return 'not known'
    if 0.0 < fraction < 0.01:
        return '&lt; 1 %'
    return f'{round(100.0 * fraction)} %'.replace('-', '−')


def _rounded(mean, width):
    """Return mean ± width to the digits the width leaves, scaled where zeros would crowd it."""
    largest = max(abs(mean), width)
    power = math.floor(math.log10(largest)) if largest > 0.0 else 0
    power = 0 if -3 <= power < 5 else power
    mean, width = mean / 10.0 ** power, width / 10.0 ** power
    size, wanted = (width, 1) if width > 0.0 else (abs(mean), 3)
    digits = max(0, wanted - math.floor(math.log10(size))) if size > 0.0 else 0
    text = f'{mean:.{digits}f}' + (f' ± {width:.{digits}f}' if width > 0.0 else '')
    text = text.replace('-', '−')
    return f'({text})·10<sup>{power}</sup>'.replace('-', '−') if power else text


def _quantity(mean, std, unit):
    """Return HTML for mean ± 2 std and unit; angles also in degrees."""
    if not math.isfinite(mean):
        return 'not known'
    width = 2.0 * std if std is not None and math.isfinite(std) else 0.0
    unit_html = re.sub(r'\^(-?\d+)', r'<sup>\1</sup>', escape(unit)) if unit != '-' else ''
    text = f'{_rounded(mean, width)} {unit_html}'
    if unit == 'rad':
        text += f' ({_rounded(math.degrees(mean), math.degrees(width))}°)'
    return text if width else text + ', no interval'


def _name(name):
    """Return an effect's or parameter's name as words; a joint in brackets keeps its name."""
    words, bracket, joint = name.partition(' (')
    return words.replace('_', ' ') + bracket + joint


def _sentence(text):
    """Return a text with its first letter large."""
    return text[:1].upper() + text[1:]


def _label(name):
    """Return a joint's name as HTML that a narrow column may break."""
    return escape(name).replace('_', '_<wbr>')


def _list(names):
    names = list(names)
    return ', '.join(names[:-1]) + ' and ' + names[-1] if len(names) > 1 else ''.join(names)


def _where(finding, joints):
    """Return the joints of a finding as the subject of a sentence."""
    if len(finding.joints) == 1:
        return f'Joint {finding.joints[0]}'
    if set(finding.joints) == set(joints):
        return 'All joints'
    return f'Joints {_list(finding.joints)}' if len(finding.joints) < 4 else \
        f'{len(finding.joints)} joints'


def _what(finding):
    name = 'an effect of unknown kind' if finding.name == UNKNOWN else _name(finding.name)
    sure = finding.verdict == CONFIRMED
    if finding.changed:
        return f'{name} {"has" if sure else "may have"} changed'
    return f'{name} {"found" if sure else "suspected"}'


def _strongest(finding, joints):
    """Return the index of the joint whose residual the finding explains best."""
    own = np.array([name in finding.joints for name in joints])
    return int(np.argmax(np.where(own, np.nan_to_num(finding.explained), -1.0)))


def _nothing(diagnosis):
    """Return the headline of a diagnosis without findings."""
    left = np.nan_to_num(diagnosis.unexplained)
    if left.max() >= _WEIGHTY:
        return (f'No effect named, but the torque model does not fit {diagnosis.robot}: '
                f'look at joint {diagnosis.joints[int(left.argmax())]}')
    if not np.isfinite(diagnosis.unexplained).all():
        return (f'No effect found; these recordings cannot tell whether the torque model fits '
                f'{diagnosis.robot}')
    return f'No missing effect found: the torque model fits {diagnosis.robot}'


def headline(diagnosis):
    """Return the result in one plain-text sentence: where, what, torque error before, after."""
    findings = sorted(diagnosis.findings, key=lambda f: f.verdict != CONFIRMED)
    if not findings:
        return _nothing(diagnosis)
    first = findings[0]
    j = _strongest(first, diagnosis.joints)
    of = '' if len(first.joints) == 1 else f' of {diagnosis.joints[j]}'
    before, after = _figure(diagnosis.before[j]), _figure(diagnosis.after[j])
    error = f'stays {after}' if before == after else f'{before} → {after}'
    return f'{_where(first, diagnosis.joints)}: {_what(first)}, torque error{of} {error} Nm'


def _badges(finding):
    badges = [finding.verdict] + ['changed'] * finding.changed
    return ' '.join(f'<span class="badge {escape(b)}">{escape(b)}</span>' for b in badges)


def _list_of(items):
    return '<ul>' + ''.join(f'<li>{item}</li>' for item in items) + '</ul>'


def _summary(diagnosis):
    """Return the findings in short, each linked to its section."""
    return _list_of(f'{_badges(f)} <a href="#effect-{k}">'
                    f'{escape(_where(f, diagnosis.joints))}: {escape(_what(f))}</a>'
                    for k, f in enumerate(diagnosis.findings, 1))


def _errors(diagnosis):
    rows = [[_label(name), _figure(before), _figure(after), _figure(floor), _share(left)]
            for name, before, after, floor, left in zip(
                diagnosis.joints, diagnosis.before, diagnosis.after, diagnosis.noise_floor,
                diagnosis.unexplained)]
    same = '' if diagnosis.findings else ' Nothing was added, so before and after are the same.'
    tested = (f'Measured on <strong>{escape(diagnosis.tested_on)}</strong>, '
              if diagnosis.tested_on else 'Measured on data ')
    return (
        '<h2>Torque error per joint</h2>'
        f'<p>{tested}never used for fitting or choosing.{same}</p>'
        + _image(errors_svg(diagnosis), 'Torque error per joint before and after, with its noise '
                 'floor; the figures are in the table below')
        + _table(['joint', 'before<br>[Nm]', 'after<br>[Nm]', 'noise floor<br>[Nm]',
                  'unex&shy;plained'], rows)
        + '<p class="quiet">Before and after: root mean square of measured less modelled torque. '
        'Noise floor: what a perfect model would leave. Unexplained: share of the remaining '
        'error\'s variance that repeats, so is no noise, and that no effect explains.</p>')


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
    rows = [['mass [kg]', _figure(before.mass_rmse), _figure(after.mass_rmse)]]
    if before.com_rmse is not None and after.com_rmse is not None:
        rows.append(['centre of mass [mm]', _figure(1e3 * before.com_rmse),
                     _figure(1e3 * after.com_rmse)])
    return _table(head, rows)


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
            + _load_table(['', 'artefact<br>as it was', 'fine-<br>tuned'], before, after))


def _physics(finding):
    """Return what the effect is and where its formula comes from."""
    effect = EFFECTS.get(finding.name)
    if effect is not None:
        text = (f'{escape(_sentence(effect.physics))}. '
                f'<span class="quiet">Source: {escape(effect.source)}.</span>')
    else:
        text = escape(_PHYSICS.get(finding.name, ''))
    if finding.changed:
        text += ' The model had this effect already; the figures below replace its former ones.'
    if finding.recording:
        text += (f' It happened in <strong>{escape(finding.recording)}</strong>; times count from '
                 'its first sample. Those samples are left out of everything else in this report.')
    if finding.variables:
        text += f' {_dependence(finding)}'
    return f'<p>{text}</p>' if text else ''


def _dependence(finding):
    """Return the variables of a finding as a sentence; time alone is the lack of any other."""
    if finding.variables != ('time',):
        return f'It depends on {escape(_list(finding.variables))}.'
    text = ('It follows none of position, velocity, acceleration and gear torque of its joints, '
            'nor a neighbour\'s velocity, closely')
    return f'{text}; it rings with one frequency.' if 'frequency' in finding.parameters else \
        f'{text}.'


def _parameters(finding):
    rows = [[_label(_name(name)), _quantity(*figures)]
            for name, figures in finding.parameters.items()]
    return _table(['parameter', 'value ± 2 standard deviations'], rows) if rows else ''


def _pictures(finding):
    images = [_image(effect_svg(p), f'Residual torque of {p.joint} in Nm against {p.variable}, '
                     'with the fitted effect and its 95 % band') for p in finding.pictures]
    return f'<div class="pictures">{"".join(images)}</div>' if images else ''


def _gain(finding):
    """Return why a finding is believed, in nats."""
    e = finding.evidence
    if finding.recording:
        return (f'The samples of that time are more likely with it by <strong>{_figure(e.gain)} '
                f'nats</strong>, all that the arm usually does fitted beside it. Needed: '
                f'{_figure(e.needed)} nats, with {e.hypotheses} intervals tried.')
    return (
        f'On data not used for its fit the model with it gains <strong>{_figure(e.gain)} ± '
        f'{_figure(2.0 * e.gain_std)} nats</strong> of log-likelihood (± 2 standard errors over '
        f'{e.blocks} blocks). Needed: {_figure(e.needed)} nats, with {e.hypotheses} hypotheses '
        'tried.')


def _evidence(finding, joints):
    e = finding.evidence
    if not math.isfinite(e.gain):
        return '<h3>Evidence</h3>' + _list_of([
            f'Nothing was fitted: this is what is left after {e.hypotheses} hypotheses tried.',
            f'Its torque: {_figure(e.rms)} Nm RMS at the strongest joint.'])
    shares = [f'{_share(s)} at {_label(name)}' for name, s in zip(joints, finding.explained)
              if name in finding.joints]
    rival = 'No other explanation came close enough to be named.'
    if e.next_best is not None:
        behind = f', {_figure(e.margin)} nats behind' if e.margin is not None else ''
        rival = f'Next best explanation: {escape(_name(e.next_best))}{behind}.'
    return '<h3>Evidence</h3>' + _list_of([
        _gain(finding), rival,
        f'Share of the residual\'s variance it explains: {_list(shares)}. '
        f'Its torque: {_figure(e.rms)} Nm RMS at the strongest joint.'])


def _doubt(finding):
    """Return what these recordings cannot tell from the finding, and the motion that would."""
    if not finding.alternatives and not finding.advice:
        return ''
    names = escape(_list(map(_name, finding.alternatives)))
    text = f'These recordings cannot tell it from <strong>{names}</strong>. ' if names else ''
    return f'<p class="note">{text}{_advice(finding)}</p>'


def _advice(finding):
    """Return the advice as a sentence; that of `unknown` is one, others name a motion or none."""
    if not finding.advice:
        return ''
    text = f'{escape(finding.advice.rstrip("."))}.'
    if finding.name == UNKNOWN or finding.advice.startswith(NO_MOTION):
        return _sentence(text)
    return f'A motion that would: {text}'


def _effect(number, finding, joints):
    name = 'unknown effect' if finding.name == UNKNOWN else _name(finding.name)
    title = f'{_sentence(name)} – {_where(finding, joints)}'
    return (f'<section id="effect-{number}"><h2>{_label(title)}</h2><p>{_badges(finding)}</p>'
            + _physics(finding) + _pictures(finding) + _parameters(finding) + _doubt(finding)
            + _evidence(finding, joints) + '</section>')


def _left(name, share):
    if not math.isfinite(share):
        return f'{_label(name)}: not known.'
    return (f'{_label(name)}: {_share(share)} of the remaining error\'s variance is structure '
            'that no effect explains.')


def _remains(diagnosis):
    left = [_left(name, share) for name, share in zip(diagnosis.joints, diagnosis.unexplained)
            if not share < _WEIGHTY]
    left += [escape(sentence) for sentence in diagnosis.remains]
    none = f'<p>Nothing of weight: less than {100 * _WEIGHTY:.0f} % at every joint.</p>'
    text = '<h2>What remains unexplained</h2>' + (_list_of(left) if left else none)
    if diagnosis.cannot_tell:
        text += '<h3>What these recordings cannot tell</h3>' + _list_of(
            escape(_sentence(sentence)) for sentence in diagnosis.cannot_tell)
    return text


def _origin(diagnosis):
    recordings = _list_of(map(_label, diagnosis.recordings)) if diagnosis.recordings else ''
    kept = '' if diagnosis.fine_tuning else (
        '<p>Learned artefacts (method lstm) were left as they are and run with the better model.'
        '</p>')
    return (
        '<h2>Recordings and method</h2>' + recordings
        + f'<p>Tested on: {escape(diagnosis.tested_on) or "not stated"}.</p>'
        '<p>The measured torque less the model\'s is compared with every physical effect the tool '
        'knows. An effect enters the model only if it predicts blocks of data that its fit has '
        'not seen better than without it, by more than chance would give over all hypotheses '
        'tried (<em>confirmed</em>); where that is not certain it is <em>suspected</em>. A gain '
        f'of one nat means that the data are 2.7 times as likely.</p>{kept}'
        f'<p class="quiet">hand_load_estimator {__version__}, {datetime.date.today()}, '
        f'{_figure(diagnosis.seconds)} s of computing.</p>')


def page(diagnosis):
    """Return a Diagnosis as one HTML text that needs no other file."""
    head = escape(headline(diagnosis))
    effects = ''.join(_effect(k, finding, diagnosis.joints)
                      for k, finding in enumerate(diagnosis.findings, 1))
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{head}</title><style>{STYLE}</style></head><body>'
        f'<p class="quiet">Diagnosis of the torque model of {escape(diagnosis.robot)}</p>'
        f'<h1>{head}</h1>' + (_summary(diagnosis) if diagnosis.findings else '')
        + _errors(diagnosis) + _load(diagnosis) + _learned(diagnosis.fine_tuning) + effects
        + _remains(diagnosis) + _origin(diagnosis) + '</body></html>\n')


def write_page(path, diagnosis):
    """Write a Diagnosis as one self-contained HTML file."""
    Path(path).write_text(page(diagnosis), encoding='utf-8')
