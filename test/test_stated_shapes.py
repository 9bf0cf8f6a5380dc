"""The better model says how well its searched shapes are known, as the report does."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import declared_model, diagnosed, on, peak, ripple

from hand_load_estimator.residual.stated_shapes import with_stated_shapes
from hand_load_estimator.torque.columns import EffectUse, parameter_count
from hand_load_estimator.torque.model_file import read_model, write_model


def test_shapes_of_what_was_found_have_the_report_s_interval_in_the_model(tmp_path):
    diagnosis, better = diagnosed(on(2, 4.0, ripple), on(1, 4.0, peak))
    write_model(tmp_path / 'model.yaml', better)
    uses = {use.name: use for use in read_model(tmp_path / 'model.yaml').uses if use.shape_std}
    assert {'torque_ripple', 'stribeck_friction'} <= set(uses)
    for finding in diagnosis.findings:
        told = uses[finding.name].shape_std
        assert told and all(std == finding.parameters[name][1] > 0.0
                            for name, std in told.items())
    period = uses['torque_ripple']
    assert abs(period.shape['periods'] - 23.4) < 4.0 * period.shape_std['periods']


def test_what_is_not_known_is_not_stated():
    diagnosis, better = diagnosed(on(2, 4.0, ripple))
    (finding,), plain = diagnosis.findings, replace(better, uses=tuple(
        replace(use, shape_std={}) for use in better.uses))
    assert with_stated_shapes(plain, ()) is plain
    unknown = replace(finding, parameters={
        name: (mean, np.nan, unit) for name, (mean, _, unit) in finding.parameters.items()})
    assert with_stated_shapes(plain, (unknown,)) is plain
    assert with_stated_shapes(plain, (finding,)).uses == better.uses != plain.uses


@pytest.mark.parametrize('name, shape, known', [
    ('backlash', {'travel': 0.004, 'lag': 0.01, 'pose_share': 0.1, 'impact': 0.009}, 'travel'),
    ('presliding_hysteresis', {'presliding_distance': 2e-3, 'plastic': 0.8}, 'plastic')])
def test_a_model_that_knows_some_of_its_shapes_is_read_back(tmp_path, name, shape, known):
    model = declared_model(names=('torque_offset',))
    uses = (EffectUse(name, 0, shape, {known: 1e-3}),)
    count = parameter_count(model.robot.n, uses)
    made = replace(model, uses=uses, mean=np.zeros(count), covariance=np.zeros((count, count)))
    write_model(tmp_path / 'model.yaml', made)
    assert read_model(tmp_path / 'model.yaml').uses == uses
