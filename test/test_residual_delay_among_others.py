"""A delay of a joint that does other things too: they come as late as its torque."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import (assert_repaired, clean_runs, constant_friction, declared_model,
                              diagnosed, noise_of, on, recorded, ripple, SECONDS, told)

from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.delay_among_others import delay_among, delayed
from hand_load_estimator.residual.tracing.hypotheses import hypotheses, of_shapes
from hand_load_estimator.residual.tracing.hypothesis import beside_delays
from hand_load_estimator.torque.columns import EffectUse
from hand_load_estimator.torque.model_file import read_model, write_model

JOINT, DELAY = 2, 0.045


def late_with(function, times, delay=DELAY):
    """Return an effect: joint JOINT has another effect, and all its torque comes late [s]."""
    other = on(JOINT, times, function)

    def effect(run):
        now, time = run.torque[:, JOINT], run.motion.stamp
        out = np.zeros_like(run.torque)
        out[:, JOINT] = np.interp(time - delay, time, now + other(run)[:, JOINT]) - now
        return out
    return effect


@pytest.mark.parametrize('messages, verdicts', [(10, [CONFIRMED]), (1, [])])
def test_how_short_a_delay_may_be_depends_on_the_rate_of_joint_states(messages, verdicts):
    """Not on the spacing of rows, which are means of several."""
    evidence = [replace(run, motion=replace(run.motion, messages=np.full(
        len(run.torque), messages))) for run in recorded(late_with(ripple, 30.0, 0.009))]
    diagnosis, _ = diagnose(declared_model(), evidence[:-1], evidence[-1:])
    found = [f for f in diagnosis.findings if f.name == 'time_delay']
    assert [f.verdict for f in found] == verdicts and all(len(f.joints) == 1 for f in found)
    assert all(f.parameters['delay'][0] == pytest.approx(0.009, rel=0.2) for f in found)


@pytest.mark.parametrize('function, name, parameter', [
    (ripple, 'torque_ripple', 'amplitude'),
    (lambda run: run.torque, 'torque_scale', 'gain'),
    (constant_friction, 'coulomb_friction', 'change_of_level')])
def test_both_are_found_with_their_figures(function, name, parameter, tmp_path):
    diagnosis, better = diagnosed(late_with(function, 6.0))
    joint = better.robot.joints[JOINT]
    assert told(diagnosis) == {'time_delay': (joint,), name: (joint,)}
    found = {f.name: f.parameters for f in diagnosis.findings}
    assert found['time_delay']['delay'][0] == pytest.approx(DELAY, rel=0.05)
    assert found['time_delay']['share'][0] == pytest.approx(1.0, abs=0.02)
    # RMS of a sine, of a constant, and of the joint's torque.
    rms = {'amplitude': np.sqrt(0.5), 'change_of_level': 1.0, 'gain': np.sqrt(np.mean(
        np.concatenate([torque[:, JOINT] for _, _, torque in clean_runs(SECONDS)]) ** 2))}
    size = 6.0 * noise_of(better.robot)[JOINT] / rms[parameter]
    assert found[name][parameter][0] == pytest.approx(size, rel=0.1)
    assert_repaired(diagnosis, JOINT)
    for finding in diagnosis.findings:
        # What else might have been, and how far behind it is. Nothing else makes waves.
        assert finding.evidence.next_best not in found
        if finding.name != 'torque_ripple':
            assert 0.0 < finding.evidence.margin <= finding.evidence.gain
    if function is ripple:
        # Beside the delay, as it was found.
        assert 0.003 < found[name]['periods'][1] < 0.03
    write_model(tmp_path / 'model.yaml', better)
    assert read_model(tmp_path / 'model.yaml').uses == better.uses


def test_a_delay_counts_with_all_that_is_lost_without_it():
    """Beside a ripple as it is undelayed, a short delay gains nothing."""
    delay = 0.03
    diagnosis, better = diagnosed(late_with(ripple, 6.0, delay))
    joint = better.robot.joints[JOINT]
    assert told(diagnosis) == {'time_delay': (joint,), 'torque_ripple': (joint,)}
    found = {f.name: f for f in diagnosis.findings}
    assert found['time_delay'].parameters['delay'][0] == pytest.approx(delay, rel=0.05)
    # What is left without the delay: the other effect fitted as it would be at once.
    assert found['time_delay'].explained[JOINT] > 0.5
    assert_repaired(diagnosis, JOINT)


def test_a_delay_is_not_small_beside_what_it_delays():
    """Of its own torque it explains little beside a ripple that is as late."""
    diagnosis, better = diagnosed(late_with(ripple, 30.0))
    joint = better.robot.joints[JOINT]
    assert told(diagnosis) == {'time_delay': (joint,), 'torque_ripple': (joint,)}
    for finding in diagnosis.findings:
        evidence = finding.evidence
        assert evidence.by_joint == {joint: pytest.approx(evidence.gain)}


def test_the_delay_fits_best_with_what_it_delays():
    model = declared_model()
    residual = find_residual(model, recorded(late_with(ripple, 6.0))[:-1])
    blocks = residual.blocks()
    own = [h for h in hypotheses(model, residual, blocks, ()) if h.joint == JOINT]
    delay = max((h for h in own if h.name == 'time_delay'),
                key=lambda h: blocks.evaluate(h.columns).gain)
    other = next(h for h in own if h.name == 'torque_ripple')
    (other,) = of_shapes(other, [{'periods': 23.4}], model, residual)
    moved = delay_among(delay, [other], blocks, model, residual)
    late = beside_delays(other, delayed(residual, moved))
    assert late.prompt is other.columns and late.shape == other.shape
    share = float(blocks.beside(late.columns).evaluate(moved.columns).theta[0] * moved.scale[0])
    # Of a delay this short beside so slow a ripple little more than the product shows.
    assert share * moved.shape['shift'] == pytest.approx(DELAY, rel=0.05)
    assert share == pytest.approx(1.0, abs=0.2)
    together = [blocks.beside(h.columns).evaluate(moved.columns).gain
                + blocks.evaluate(h.columns).gain for h in (other, late)]
    assert together[1] > together[0] + 100.0


@pytest.mark.parametrize('share', [1.0, 0.6])
@pytest.mark.parametrize('other, values', [
    (EffectUse('torque_ripple', JOINT, {'periods': 23.4}), [0.4, 0.1, 0.0, 0.2]),
    (EffectUse('load_dependent_friction', JOINT), [0.5])])
def test_the_columns_of_a_delay_are_how_the_torque_changes_with_every_parameter(share, other,
                                                                                values):
    model = declared_model()
    uses = (*model.uses, other, EffectUse('time_delay', JOINT, {'shift': DELAY}))
    evidence = recorded()
    mean = np.concatenate([model.mean, values, [share]])

    def torque(x):
        # What the model says, without the linear form.
        system = System(model.robot, uses, evidence, x)
        return np.concatenate([e.torque for e in evidence]) - system.residual(x)
    system = System(model.robot, uses, evidence, mean)
    rng = np.random.default_rng(3)
    step = 1e-4 * rng.normal(size=len(mean)) * np.maximum(np.abs(mean), 0.1)
    if other.effect.needs:
        # What the links change of it a delay does not tell.
        step[:10 * model.robot.n] = 0.0
    np.testing.assert_allclose(torque(mean + step) - torque(mean), system.columns @ step,
                               atol=1e-6 + 1e-3 * np.abs(system.columns @ step).max())
