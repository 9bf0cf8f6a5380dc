"""Does a torque model belong to the arm that was recorded, and to the load it is said to carry?"""

from functools import cached_property

import numpy as np

from ...errors import RecordingError
from ..outside.load_change import looks_loaded, OVERLOAD
from ..outside.standing import is_held
from .wrong_joint import wrong_joint

# Every so many rows are looked at: what is wrong here is wrong all the time.
EVERY, FEWEST_ROWS = 10, 20
STRANGE = 0.5          # share of a torque's variance that a model of this arm leaves at most
PUSHED = 0.1           # share of the time in which something may act on the arm from outside
# A joint carries load where the model's torque varies by so many times its noise.
LOADED = 5.0
# Published torque constants of one arm differ by 13 %, those of arms of a family and others by
# more than half. One joint's may be wrong by anything.
GAIN, FEWEST = 1.5, 2
# A joint moves that is so fast [rad/s] for such a share of the busiest joint's time.
MOVES, OFTEN = 0.05, 0.1
SLIDES = 0.01          # [rad/s] from which on friction has the sign of the velocity
# What is said to be wrong must explain this share of what the model leaves; a load, more of it
# than gains do.
EXPLAINED = 0.7


def refuse_another_robot(model, evidence):
    """
    Raise RecordingError where a model does not belong to the arm, unit or mounting at all.

    Nor where one joint was recorded wrongly (wrong_joint.py).
    An arm that carries much more than is declared looks like a heavier one, and is told apart.
    """
    for mark in dict.fromkeys(e.mark for e in evidence):
        # The parts of a recording together: in a short one alone hardly a joint may have moved,
        # and at rest friction hides what the model explains.
        parts = [e for e in evidence if e.mark == mark]
        if all(map(is_held, parts)):
            continue    # What a pose alone tells is judged by standing.py.
        rows = _Rows(model, parts)
        little, size = rows.little_explained(), rows.of_another_size()
        wrong = little or size or wrong_joint(model, parts)
        load = rows.another_load() if wrong else ''
        # What another load explains the diagnosis finds, if the model explains anything at all.
        if little or wrong and not load:
            raise RecordingError(f'{mark.name}: {load or wrong}')


class _Rows:
    """Some rows of the parts of one recording (Evidence) beside what a TorqueModel says."""

    def __init__(self, model, parts):
        self._model, self._load = model, parts[0].load
        tells = np.flatnonzero(np.concatenate([e.tells.all(axis=1) for e in parts]))
        # Where an effort is cut off nearly always, better those rows than none.
        some = tells[::EVERY] if len(tells) > EVERY * FEWEST_ROWS else slice(None, None, EVERY)
        self._q, self._v, self._a, warmth = (
            np.concatenate([getattr(e.motion, name) for e in parts])[some]
            for name in ('q', 'v', 'a', 'temperature'))
        self._measured = np.concatenate([e.torque for e in parts])[some]
        self._modelled = model.torques(self._q, self._v, self._a, warmth)

    @cached_property
    def _links(self):
        """Columns (N, n, 10 n) of the links' products."""
        robot = self._model.robot
        return np.array([robot.link_regressor(*row) for row in zip(self._q, self._v, self._a)])

    @cached_property
    def _moved(self):
        """Torques (N, n) measured and modelled, less friction and offset."""
        return tuple(self._without_friction(torque) for torque in (self._measured, self._modelled))

    @cached_property
    def _gains(self):
        measured, modelled = self._moved
        return (measured * modelled).sum(axis=0) / np.maximum((modelled ** 2).sum(axis=0), 1e-12)

    def little_explained(self):
        """Return a sentence where the model explains next to nothing, else ''."""
        # A joint that others shake while it is held shows friction's torque.
        moves = np.mean(np.abs(self._v) > MOVES, axis=0)
        moves = moves >= OFTEN * max(moves.max(), 1e-12)
        loaded = moves & (self._modelled.std(axis=0) > LOADED * self._model.noise)
        if not loaded.any() or np.median([self._left_moving(j) for j in np.flatnonzero(loaded)]) \
                <= STRANGE:
            return ''
        return ('the model explains less than half of the torque of half the joints that carry '
                'load; it belongs to another robot, unit, sign or mounting; try `hand_load check`')

    def _left_moving(self, j):
        """Return what left() says of joint j while it moves: standing, friction may hold it."""
        rows = np.abs(self._v[:, j]) > MOVES
        return left(self._measured[rows, j:j + 1], self._modelled[rows, j:j + 1])[0]

    def of_another_size(self):
        """Return a sentence where most joints have another gain than any mistake gives, or ''."""
        # By their links: what friction does beside its plain laws is no gain.
        links = self._links @ self._model.mean[:self._links.shape[2]]
        loaded = self._without_friction(links).std(axis=0) > LOADED * self._model.noise
        measured, modelled = self._moved
        gains = self._gains
        before, after = (np.sum((measured - gain * modelled) ** 2, axis=0)
                         for gain in (1.0, gains))
        off = loaded & ((gains > GAIN) | (gains < 1.0 / GAIN)) & (
            after < (1.0 - EXPLAINED) * before)
        if off.sum() < FEWEST or 2 * off.sum() <= loaded.sum():
            return ''
        told = ', '.join(f'{gains[j]:.2g} times at {self._model.robot.joints[j]}'
                         for j in np.flatnonzero(off))
        return (f'the torque recorded, less friction, is not the model\'s but {told}; torque '
                f'constants explain up to {GAIN:g} times, or one joint; the model belongs to '
                'another robot or unit; give the model of this arm, or try `hand_load check`')

    def another_load(self):
        """Return a sentence where another load explains what the model leaves, or ''."""
        robot, (measured, modelled) = self._model.robot, self._moved
        columns = np.stack([self._without_friction(column) for column in
                            np.moveaxis(robot.load_columns(self._links), 2, 0)], axis=2)
        unit = robot.limits.torque
        error = ((measured - modelled) / unit).ravel()
        scaled = (columns / unit[:, None]).reshape(len(error), -1)
        products = np.linalg.lstsq(scaled, error, rcond=1e-6)[0]
        mass = self._load.mass + products[0]
        of_load = np.sum((error - scaled @ products) ** 2)
        of_gains = np.sum(((measured - self._gains * modelled) / unit) ** 2)
        if of_load > min((1.0 - EXPLAINED) * (error @ error), of_gains) \
                or not 0.0 <= mass <= OVERLOAD * robot.rated_load.mass:
            return ''
        return looks_loaded(mass, self._load.mass)

    def _without_friction(self, torque):
        """Return torque (N, n) less the offset and friction that fit it best, joint by joint."""
        out = np.empty_like(torque)
        for j, v in enumerate(self._v.T):
            own = np.column_stack([np.ones_like(v), v, np.sign(v) * (np.abs(v) > SLIDES)])
            out[:, j] = torque[:, j] - own @ np.linalg.lstsq(own, torque[:, j], rcond=None)[0]
        return out


def left(measured, modelled):
    """
    Return the share (n,) of measured torques' variance (M, n) that a model of them leaves.

    Without each joint's worst rows: a hard push has more squares than minutes of the arm's own
    torque, while another robot's model is wrong all the time.
    """
    error = measured - modelled
    usual = np.abs(error) <= np.quantile(np.abs(error), 1.0 - PUSHED, axis=0)
    count = usual.sum(axis=0)
    off = measured - (usual * measured).sum(axis=0) / count
    return (usual * error ** 2).sum(axis=0) / np.maximum((usual * off ** 2).sum(axis=0), 1e-12)
