"""Effects through a model file: whole-arm effects and searched shapes are the same after it."""

from dataclasses import replace
import re

from core_helpers import effect_uses, four_axes
from effect_helpers import DT, inputs, model_with
import numpy as np

from hand_load_estimator.torque.columns import parameter_count, torque_columns
from hand_load_estimator.torque.model_file import model_content, read_model, write_model


def test_the_model_file_keeps_tilt_and_ripple(tmp_path):
    """An effect of the whole arm stands once, with all joints; a ripple keeps its period."""
    names = ('base_tilt', 'torque_ripple', 'backlash', 'time_delay')
    values = {'base_tilt': (0.01, -0.02), 'torque_ripple': (0.3, -0.2, 0.1, 0.05),
              'backlash': (0.1,), 'time_delay': (0.7,)}
    model = model_with(four_axes(), names, values, {'periods': 61.37, 'shift': 0.0171})
    entries = [e for e in model_content(model)['effects'] if e['name'] == 'base_tilt']
    assert [e['joints'] for e in entries] == [list(model.robot.joints)]
    write_model(tmp_path / 'model.yaml', model)
    back = read_model(tmp_path / 'model.yaml')
    assert back.uses == model.uses
    x = replace(inputs(), gear=None, gear_way=None, drive=None, rate=None, tilt=None,
                late=None, play=None)
    one, two = (torque_columns(m.robot, m.layout, x, m.mean, np.full(60, DT)) @ m.mean
                for m in (model, back))
    np.testing.assert_allclose(two, one, rtol=1e-6, atol=1e-6)
    without = replace(model, mean=np.where(np.arange(len(model.mean)) < parameter_count(
        4, effect_uses(model.robot)), model.mean, 0.0))
    assert np.abs(torque_columns(model.robot, model.layout, x, without.mean, np.full(60, DT))
                  @ without.mean - one).max() > 0.5


def test_a_file_from_before_impacts_had_a_length_is_read(tmp_path):
    model = model_with(four_axes(), ('backlash',), {'backlash': (0.9,)}, {'impact': 0.008})
    write_model(tmp_path / 'model.yaml', model)
    text = (tmp_path / 'model.yaml').read_text()
    assert 'impact: 0.008' in text
    (tmp_path / 'old.yaml').write_text(re.sub(r'\n *impact: .*', '', text))
    old = read_model(tmp_path / 'old.yaml')
    shapes = [use.shape for use in old.uses if use.name == 'backlash']
    assert shapes and all(shape['impact'] == 1e-4 for shape in shapes)
