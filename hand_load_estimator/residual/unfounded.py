"""
Effects that the model written holds with figures which are none of what they are called.

A hypothesis is asked what physics allows of it; estimated together with everything else its
figures may become others. A share of a delay is no delay, and a peak of friction below the slowest
motion that tells friction is known by its tail only.
"""

from dataclasses import replace

from ..effects import EFFECTS
from .diagnosis import CONFIRMED, SUSPECTED
from .hypothesis import whole


def of_another_kind(findings):
    """Return (Findings, sentences): suspected is what has figures of no such effect."""
    said = [_why(finding) for finding in findings]
    return (tuple(replace(f, verdict=SUSPECTED) if why else f for f, why in zip(findings, said)),
            tuple(why for why in said if why))


def _why(finding):
    """Return in words why a Finding is not what it is called, or an empty string."""
    if finding.verdict != CONFIRMED or finding.name not in EFFECTS:
        return ''
    joints = ', '.join(finding.joints)
    for name, (mean, std, unit) in finding.parameters.items():
        plain = name.split(' (')[0]
        if finding.name == 'time_delay' and plain == 'share' and not whole(mean, std):
            return (f'{joints}: time_delay is only suspected: all of the torque would come late, '
                    f'but the model written delays {mean:.3g} ± {2.0 * std:.2g} of it (two '
                    'standard deviations)')
        if any(s.name == plain and mean <= s.least for s in EFFECTS[finding.name].shapes
               if s.unit == 'rad/s'):
            return (f'{joints}: {finding.name} is only suspected: its {plain} is at or below '
                    f'{mean:.3g} {unit}, slower than any motion that tells friction')
    return ''

