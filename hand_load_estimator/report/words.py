"""Numbers, quantities and names as the words and HTML of a page."""

import math
import re
from html import escape


def number_text(number):
    """Return a number to three significant digits, `not known` for None and NaN."""
    if number is None or not math.isfinite(number):
        return 'not known'
    if abs(number) >= 999.5:
        return f'{number:.0f}'.replace('-', '−')
    text = f'{number:#.3g}'.rstrip('.') if abs(number) >= 1e-3 else f'{number:.2g}'
    return text.replace('-', '−')


def behind_text(nats, std=None):
    """Return how far another explanation is behind, in words; less than nothing is ahead."""
    band = '' if std is None else f' ± {number_text(2.0 * std)}'
    return f'{number_text(abs(nats))}{band} nats {"ahead" if nats < 0.0 else "behind"}'


def share_text(fraction):
    """Return a fraction as HTML in whole percent."""
    if not math.isfinite(fraction):
        return 'not known'
    if 0.0 < fraction < 0.01:
        return '&lt;&nbsp;1&nbsp;%'
    return f'{round(100.0 * fraction)}&nbsp;%'.replace('-', '−')


def range_text(low, high, form):
    """Return two numbers in the words of form(number), once where both have the same."""
    texts = [form(low), form(high)]
    unknown = form(math.nan)
    return unknown if unknown in texts else ' to '.join(dict.fromkeys(texts))


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


def quantity_html(mean, std, unit):
    """Return HTML for mean ± 2 std and unit; angles also in degrees."""
    if not math.isfinite(mean):
        return 'not known'
    width = 2.0 * std if std is not None and math.isfinite(std) else 0.0
    unit_html = re.sub(r'\^(-?\d+)', r'<sup>\1</sup>', escape(unit)) if unit != '-' else ''
    text = f'{_rounded(mean, width)} {unit_html}'
    if unit == 'rad':
        text += f' ({_rounded(math.degrees(mean), math.degrees(width))}°)'
    return text if width else text + ', no interval'


def name_words(name):
    """Return an effect's or parameter's name as words; a joint in brackets keeps its name."""
    words, bracket, joint = name.partition(' (')
    return words.replace('_', ' ') + bracket + joint


def as_sentence(text):
    """Return a text with its first letter large."""
    return text[:1].upper() + text[1:]


def label_html(name):
    """Return a joint's name as HTML that a narrow column may break."""
    return escape(name).replace('_', '_<wbr>')


def list_text(names):
    """Return names as `a, b and c`."""
    names = list(names)
    return ', '.join(names[:-1]) + ' and ' + names[-1] if len(names) > 1 else ''.join(names)


def items_html(items):
    """Return HTML items as a list."""
    return '<ul>' + ''.join(f'<li>{item}</li>' for item in items) + '</ul>'
