"""What is measured: plants, their recordings for identification, and cases with unknown loads."""

from dataclasses import dataclass, replace

import numpy as np

from ..estimators.pipeline import MOTION_START
from ..identification.evidence import prepare
from ..load import LoadParameters
from ..motion import Motion
from ..plant import TemperatureEvent, simulate_motion
from ..plant.effects_file import parse_effects
from ..simulation.simulate_motions import named_motion
from ..stream.input_guard import InputGuard
from ..stream.joint_stream import JointStream
from .wrist_swing import wrist_swing, WRIST_SWING

# No-load recordings every model is identified from: motion, temperature [degC], seconds.
IDENTIFICATION = (('excite', 15.0, 40.0), ('pick_place', 25.0, 40.0), ('excite', 36.0, 40.0),
                  ('pick_place', 50.0, 40.0))
DURATION = 13.0          # [s] of a case
HEAVIEST = 10.0          # [kg] for a rated load of 12.5 kg; scaled for other robots
TEMPERATURES = (15.0, 50.0)
SPEEDS = (0.3, 1.0)


@dataclass(frozen=True)
class Recorded:
    """
    How a plant's recordings were made, from which its models are identified.

    motions: (motion, start temperature [degC], seconds) of each; told: whether temperatures are;
    room: temperature around the arm [degC], None where it is as warm as the arm.
    """

    motions: tuple = IDENTIFICATION
    told: bool = True
    room: float | None = None


@dataclass(frozen=True)
class Case:
    """
    One run: plant seed, case seed, load, start temperature [degC], speed (share), motion.

    hidden: entries of an effects file, what happened to the arm after its identification; room:
    as of Recorded.
    """

    plant: int
    seed: int
    load: LoadParameters
    temperature: float
    speed: float
    motion: str = 'pick_place'
    hidden: tuple = ()
    room: float | None = None


def draw_load(robot, rng, masses=(0.0, HEAVIEST), radii=(0.03, 0.2), off=0.1):
    """
    Return an ellipsoid around the rated place as LoadParameters.

    masses [kg], half axes and distance from the rated place along each axis [m] are those of a
    rated load of 12.5 kg; other robots' are scaled.
    """
    scale = robot.rated_load.mass / 12.5
    size = scale ** (1.0 / 3.0)
    mass = rng.uniform(masses[0] * scale, masses[1] * scale)
    half = rng.uniform(*radii, 3) * size
    moments = mass / 5.0 * (np.sum(half ** 2) - half ** 2)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    com = robot.rated_load.com + rng.uniform(-off, off, 3) * size
    return LoadParameters(mass, com, axes @ np.diag(moments) @ axes.T)


def draw_case(robot, plant, seed, temperatures=TEMPERATURES, speeds=SPEEDS):
    """
    Return the Case of a seed: an ellipsoid of mass anywhere around the rated place.

    The same seed draws the same load, and the same place within other ranges.
    """
    rng = np.random.default_rng(seed)
    load = draw_load(robot, rng)
    return Case(plant, seed, load, rng.uniform(*temperatures), rng.uniform(*speeds))


def stream_samples(robot, events, stream=None):
    """Yield the MotionSamples of a plant's events, but for those right after a gap."""
    stream = stream or JointStream(robot)
    for event in events:
        if isinstance(event, TemperatureEvent):
            for joint, celsius in zip(robot.joints, event.celsius):
                stream.temperature_reading(joint, celsius)
            continue
        sample = stream.joint_state(event.stamp, robot.joints, event.position, event.velocity,
                                    event.effort)
        if sample is not None and not sample.fresh:
            yield sample


def motion_events(robot, motion, **arguments):
    """Yield the events of a plant that follows a motion; arguments: as of Plant."""
    return simulate_motion(robot, motion.time, motion.position, motion.velocity,
                           motion.acceleration, **arguments)


def simulated(robot, motion, **arguments):
    """Return the MotionSamples of a motion; arguments: as of Plant."""
    return list(stream_samples(robot, motion_events(robot, motion, **arguments)))


def untold(motion):
    """Return a MotionSample, or a Motion, of joints without sensors of temperature."""
    return replace(motion, temperature=np.full_like(motion.temperature, np.nan))


def identification_evidence(robot, plant, load=LoadParameters(), recorded=Recorded()):
    """Return the Evidence of a plant's recordings with a known load, none by default."""
    out = []
    for k, (name, temperature, seconds) in enumerate(recorded.motions):
        motion = named_motion(name, robot, seconds, 1.0, 10 * plant + k)
        samples = simulated(robot, motion, seed=plant, run=k + 1,
                            start_temperature=temperature, ambient_temperature=recorded.room,
                            load=load)
        samples = samples if recorded.told else [untold(sample) for sample in samples]
        label = f'plant {plant}, {name} at {temperature:g} degC'
        out.append(prepare(robot, label, Motion.of(samples), load))
    return out


def case_motion(robot, case):
    """Return the Trajectory of a Case."""
    if case.motion == WRIST_SWING:
        return wrist_swing(robot, DURATION, np.random.default_rng([case.seed, 7]))
    return named_motion(case.motion, robot, DURATION, case.speed, case.seed)


def case_arguments(case):
    """Return the Plant's arguments of a Case but for what is hidden."""
    return {'seed': case.plant, 'run': case.seed, 'start_temperature': case.temperature,
            'ambient_temperature': case.room, 'load': case.load}


def hidden_effects(robot, case):
    """Return the EffectRequests that a Case hides."""
    return tuple(parse_effects(list(case.hidden), robot, f'case {case.seed}'))


def case_events(robot, case, effects=()):
    """Yield the plant's events of a Case; effects: EffectRequests beside the case's own."""
    return motion_events(robot, case_motion(robot, case), **case_arguments(case),
                         effects=(*effects, *hidden_effects(robot, case)))


@dataclass(frozen=True)
class CaseRun:
    """What a Case gives: its MotionSamples, and the stamp [s] of motion start or None."""

    samples: list
    start: float | None

    @staticmethod
    def of(robot, events):
        """Return the CaseRun of a list of a plant's events."""
        return CaseRun(list(stream_samples(robot, events)), motion_start(robot, events))


def case_run(robot, case, effects=()):
    """Return the CaseRun of a Case; effects: as of case_events."""
    return CaseRun.of(robot, list(case_events(robot, case, effects)))


def motion_start(robot, states):
    """
    Return the stamp [s] at which a gravity-loaded joint first moves, or None (DESIGN section 6).

    states: JointEvents or JointSamples as measured, others are passed over. No filter comes
    before the clock: its delay would give every method as much more data than the time says.
    """
    guard = InputGuard(robot)
    for state in states:
        if not hasattr(state, 'velocity'):
            continue
        accepted = guard.accept(state.stamp, getattr(state, 'names', robot.joints),
                                state.position, state.velocity, state.effort)
        # Where a message has no velocity it is NaN, which is above nothing.
        moving = accepted is not None and np.abs(accepted[1]) > MOTION_START
        if np.any(moving) and (moving & _starts_clock(robot, accepted[0])).any():
            return state.stamp
    return None


def _starts_clock(robot, q):
    """Return (n,) bool: joints 2 to 4 of six; of other arms those that carry the load at q."""
    if robot.n != 6:
        return robot.gravity_loaded(q)
    return np.array([False, True, True, True, False, False])
