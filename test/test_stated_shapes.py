"""The better model says how well its searched shapes are known, as the report does."""

from dataclasses import replace

import numpy as np
from residual_helpers import declared_model, diagnosed, on, peak, ripple

from hand_load_estimator.residual.stated_shapes import with_stated_shapes
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
    model = declared_model()
    assert with_stated_shapes(model, ()) is model
    diagnosis, _ = diagnosed(on(2, 4.0, ripple))
    (finding,) = diagnosis.findings
    unknown = replace(finding, parameters={
        name: (mean, np.nan, unit) for name, (mean, _, unit) in finding.parameters.items()})
    assert with_stated_shapes(model, (unknown,)) is model
