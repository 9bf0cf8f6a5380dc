"""The section of a diagnosis page on one finding: what, where, how large, why it is believed."""

import math
from html import escape

from ..effects import DESCRIBED, EFFECTS
from ..effects.knee import KNEE
from ..residual.diagnosis import CONFIRMED, UNKNOWN
from ..residual.tracing.confusable import NO_KNOWN_MOTION, NO_MOTION
from .diagnosis_figures import effect_svg
from .page_parts import html_image, html_table
from .words import (as_sentence, behind_text, items_html, label_html, list_text, name_words,
                    number_text, quantity_html, share_text)

_UNKNOWN = ('None of the effects in this tool\'s vocabulary fits, and the torque error is not '
            'noise. A person who knows the drive should look at the picture before anything is '
            'added to the model.')


def where(finding, joints):
    """Return the joints of a finding as the subject of a sentence."""
    if len(finding.joints) == 1:
        return f'Joint {finding.joints[0]}'
    if set(finding.joints) == set(joints):
        return 'All joints'
    return f'Joints {list_text(finding.joints)}' if len(finding.joints) < 4 else \
        f'{len(finding.joints)} joints'


def what(finding):
    """Return what a finding says of its joints, to stand behind them."""
    name = 'an effect of unknown kind' if finding.name == UNKNOWN else name_words(finding.name)
    sure = finding.verdict == CONFIRMED
    if finding.changed:
        return f'{name} {"has" if sure else "may have"} changed'
    return f'{name} {"found" if sure else "suspected"}'


def badges_html(finding):
    """Return the verdict on a finding as HTML."""
    badges = [finding.verdict] + ['changed'] * finding.changed
    return ' '.join(f'<span class="badge {escape(b)}">{escape(b)}</span>' for b in badges)


def _physics(finding):
    """Return what the effect is and where its formula comes from."""
    effect = EFFECTS.get(finding.name) or DESCRIBED.get(finding.name)
    if effect is not None:
        text = (f'{escape(as_sentence(effect.physics))}. '
                f'<span class="quiet">Source: {escape(effect.source)}.</span>')
    else:
        text = escape(_UNKNOWN) if finding.name == UNKNOWN else ''
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
        return f'It depends on {escape(list_text(finding.variables))}.'
    text = ('It follows none of position, velocity, acceleration and gear torque of its joints, '
            'nor a neighbour\'s velocity, closely')
    return f'{text}; it rings with one frequency.' if 'frequency' in finding.parameters else \
        f'{text}.'


def _parameters(finding):
    rows = [[label_html(name_words(name)), quantity_html(*figures)]
            for name, figures in finding.parameters.items()]
    return html_table(['parameter', 'value ± 2 standard deviations'], rows) + _searched(finding) \
        if rows else ''


def _searched(finding):
    """Return where the intervals of searched parameters come from."""
    shapes = EFFECTS[finding.name].shapes if finding.name in EFFECTS else ()
    told = {name.partition(' (')[0] for name, (_, std, _) in finding.parameters.items()
            if std is not None and math.isfinite(std)}
    names = [name_words(shape.name) for shape in shapes
             if shape is not KNEE and shape.name in told]
    if not names:
        return ''
    return (f'<p class="quiet">Interval of {escape(list_text(names))}: from how fast the gain '
            'falls around the value, the effect\'s other parameters fitted again, and as far as '
            'its formula holds; those of its other parameters count it.</p>')


def _pictures(finding):
    images = [html_image(effect_svg(p), f'Residual torque of {p.joint} in Nm against '
                         f'{p.variable}, {_drawn(p)}') for p in finding.pictures]
    return f'<div class="pictures">{"".join(images)}</div>' if images else ''


def _drawn(picture):
    return 'with the fitted effect and its 95 % band' if picture.fitted else 'nothing fitted'


def _gain(finding):
    """Return why a finding is believed, in nats."""
    e = finding.evidence
    if finding.recording:
        return ('The samples of that time are more likely with it by '
                f'<strong>{number_text(e.gain)} nats</strong>, all that the arm usually does '
                'fitted beside it. Needed: '
                f'{number_text(e.needed)} nats, with {e.hypotheses} intervals tried.')
    return (
        'On data not used for its fit the model with it gains '
        f'<strong>{number_text(e.gain)} ± {number_text(2.0 * e.gain_std)} nats</strong> of '
        f'log-likelihood (± 2 standard errors over {e.blocks} blocks'
        f'{_shape_chosen(finding)}). Needed: '
        f'{number_text(e.needed)} nats, with {e.hypotheses} hypotheses tried.')


def _shape_chosen(finding):
    """Return that the gain is a little too high, where it was itself what chose a shape."""
    effect = EFFECTS.get(finding.name)
    # A knee is estimated with the parameters.
    shaped = effect is not None and any(shape is not KNEE for shape in effect.shapes)
    return '; the shape of the formula was chosen by the same gain' if shaped else ''


def _evidence(finding, joints):
    e = finding.evidence
    if not math.isfinite(e.gain) and finding.recording:
        return '<h3>Evidence</h3>' + items_html([
            'While the arm stood, its torques were beyond what friction can hold. Its torque: '
            f'{number_text(e.rms)} Nm RMS at the strongest joint.'])
    if not math.isfinite(e.gain):
        return '<h3>Evidence</h3>' + items_html([
            f'Nothing was fitted: this is what is left after {e.hypotheses} hypotheses tried.',
            f'Its torque: {number_text(e.rms)} Nm RMS at the strongest joint.'])
    shares = [f'{share_text(s)} at {label_html(name)}'
              for name, s in zip(joints, finding.explained) if name in finding.joints]
    if 'frequency' in finding.parameters and finding.variables == ('time',):
        return '<h3>Evidence</h3>' + items_html([
            f'It rings: windows of ten seconds gain {number_text(e.gain)} '
            f'± {number_text(e.gain_std)} nats from the frequency that the others show; '
            f'{number_text(e.needed)} were needed. No effect was fitted.',
            f'Share of what is left that rings: {list_text(shares)}. '
            f'What is left: {number_text(e.rms)} Nm RMS at the strongest joint.'])
    rival = 'Nothing that it was compared with explains anything beside what was found.'
    if e.next_best is not None:
        behind = f', {behind_text(e.margin)}' if e.margin is not None else ''
        refused = '' if e.next_possible else \
            '; with the figures that fit it is impossible or too small to matter'
        rival = f'Next best explanation: {escape(name_words(e.next_best))}{behind}{refused}.'
    return '<h3>Evidence</h3>' + items_html([
        _gain(finding), rival,
        f'Share of the residual\'s variance it explains: {list_text(shares)}. '
        f'Its torque: {number_text(e.rms)} Nm RMS at the strongest joint.'])


def _doubt(finding):
    """Return what these recordings cannot tell from the finding, and the motion that would."""
    if not finding.alternatives and not finding.advice:
        return ''
    names = list_text(_other_html(other, finding) for other in finding.alternatives)
    text = f'These recordings cannot tell it from {names}. ' if names else ''
    return f'<p class="note">{text}{_advice(finding)}</p>'


def _other_html(other, finding):
    """Return an Alternative with what is not as in the finding: its joints, and its gain."""
    text = f'<strong>{escape(name_words(other.name))}</strong>'
    if set(other.joints) != set(finding.joints):
        text += f' of {list_text(map(label_html, other.joints))}'
    if not math.isfinite(other.std) or other.std == 0.0:
        return text
    return f'{text} ({behind_text(other.behind, other.std)})'


def _advice(finding):
    """Return the advice as a sentence; that of `unknown` is one, others name a motion or none."""
    if not finding.advice:
        return ''
    text = f'{escape(finding.advice.rstrip("."))}.'
    if finding.name == UNKNOWN or finding.advice.startswith((NO_MOTION, NO_KNOWN_MOTION)):
        return as_sentence(text)
    return f'A motion that would: {text}'


def effect_section(number, finding, joints):
    """Return the HTML section of the finding of a number; joints: names of all of the arm's."""
    name = 'unknown effect' if finding.name == UNKNOWN else name_words(finding.name)
    title = f'{as_sentence(name)} – {where(finding, joints)}'
    return (f'<section id="effect-{number}"><h2>{label_html(title)}</h2>'
            f'<p>{badges_html(finding)}</p>' + _physics(finding) + _pictures(finding)
            + _parameters(finding) + _doubt(finding)
            + _evidence(finding, joints) + '</section>')
