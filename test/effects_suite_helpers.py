"""Results of the effects suite made by hand: hidden effects and what was found of them."""

from hand_load_estimator import seeds
from hand_load_estimator.residual.diagnosis import CONFIRMED

PLANT = seeds.DEVELOPMENT_PLANTS[95]
JOINT, OTHER = 'elbow_joint', 'wrist_1_joint'
SWING = [{'effect': 'swinging_load', 'parameter': 'frequency', 'truth': 1.0, 'estimate': 1.0,
          'std': None}]


def finding(name, joints=(JOINT,), verdict=CONFIRMED, alternatives=(), advice='', variables=(),
            frequency=None):
    """Return a finding as report.json has it, as far as it is judged."""
    return {'name': name, 'joints': list(joints), 'verdict': verdict,
            'alternatives_detail': list(alternatives), 'advice': advice,
            'variables': list(variables), 'parameters': {} if frequency is None else {
                'frequency': {'mean': frequency, 'std': None, 'unit': 'Hz'}}}


def other(name, joints=(JOINT,), behind=5.0, std=2.0):
    """Return an alternative as report.json has it."""
    return {'effect': name, 'joints': list(joints), 'behind': behind, 'std': std}


def result(hidden, findings, kind='single', strength=2.0, torque=(2.0, 1.0), mass=(0.4, 0.2),
           **more):
    """Return the result of hidden effects [(name, joints)], errors over those without of 1."""
    return {'label': f'{kind} {hidden}', 'kind': kind, 'plant': PLANT,
            'effects': [{'name': name, 'strength': strength, 'joints': list(joints)}
                        for name, joints in hidden],
            'findings': findings, 'parameters': [], 'seconds': 100.0,
            'torque': {'before': [torque[0], 1.0], 'after': [torque[1], 1.0],
                       'without': [1.0, 1.0]},
            'seen': {'joints': [JOINT, OTHER], 'share': [1.0, 0.1], 'known': [0.5, 0.0],
                     'before': [torque[0], 0.0], 'after': [torque[1], 0.0]},
            'mass': {key: {'3 s': [value, -value], 'end': [0.5 * value]} for key, value in
                     zip(('before', 'after', 'without'), (*mass, 0.2))}, **more}


def results():
    """Return a small suite with known figures."""
    delay = [('time_delay', (JOINT,))]
    figure = [{'effect': 'time_delay', 'parameter': 'delay', 'truth': 0.02, 'estimate': 0.015,
               'std': 0.002}]
    return [
        result(delay, [finding('time_delay')], torque=(4.0, 1.1), parameters=figure),
        result(delay, [finding('backlash')], torque=(3.0, 2.0), mass=(0.8, 0.4)),
        result(delay, [], strength=0.5),
        result([('time_delay', (JOINT,)), ('torque_scale', (OTHER,))], [finding('time_delay')],
               'pair'),
        result([], [finding('torque_offset'), finding('backlash', verdict='suspected')], 'clean'),
        result([('swinging_load', ())], [finding('unknown', variables=['time'], frequency=1.0)],
               'outside', parameters=SWING),
        {'label': 'f', 'kind': 'single', 'plant': PLANT, 'failed': 'ValueError: broke',
         'effects': [{'name': 'cable_drag', 'strength': 5.0, 'joints': []}]},
        {'label': 's', 'kind': 'single', 'plant': PLANT, 'skipped': 'not so strong',
         'effects': [{'name': 'backlash', 'strength': 5.0, 'joints': []}]}]
