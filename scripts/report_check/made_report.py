"""A report to look at: a simulated arm with two hidden effects, diagnosed."""

from pathlib import Path
import shutil
import subprocess
import sys

# Of different kinds: a ripple whose period is searched, and one of a set that looks alike.
_EFFECTS = '''effects:
- {name: torque_ripple, joints: [elbow_joint], strength: 3}
- {name: gravity_spring, joints: [shoulder_lift_joint], strength: 3}
'''
_LOAD = 'mass: 4.0\ncom: [0.0, 0.03, 0.08]\n'
# The plant that the shipped torque model was identified on.
_ARM = ('--robot', 'ur10e', '--seed', '1')


def made_report(folder):
    """Return the path of a new report.html below a folder; raises CalledProcessError."""
    inputs = Path(folder) / 'inputs'
    shutil.rmtree(inputs, ignore_errors=True)
    inputs.mkdir(parents=True)
    effects, load = inputs / 'effects.yaml', inputs / 'load.yaml'
    effects.write_text(_EFFECTS, encoding='utf-8')
    load.write_text(_LOAD, encoding='utf-8')
    bags = [inputs / f'run_{k}' for k in (1, 2, 3)]
    for k, bag in enumerate(bags):
        _hand_load('simulate', *_ARM, '--out', bag, '--motion', 'excite', '--duration', 40,
                   '--motion-seed', k, '--effects', effects)
    loaded = inputs / 'loaded'
    _hand_load('simulate', *_ARM, '--out', loaded, '--duration', 15, '--motion-seed', len(bags),
               '--effects', effects, '--load', load)
    _hand_load('diagnose', *bags[:2], '--model', 'ur10e', '--out', inputs / 'diagnosis',
               '--test', bags[2], loaded)
    return inputs / 'diagnosis' / 'report.html'


def _hand_load(*arguments):
    subprocess.run([sys.executable, '-m', 'hand_load_estimator', *map(str, arguments)],
                   check=True)
