"""
Is one joint of a recording told wrongly: its effort, its sign, its place among the others?

A cable in another socket, a sign in a driver's settings, a sensor that tells nothing: each is
explained by a gain or an offset that no drive has, and would be written into the model.
"""

from functools import cached_property
from itertools import combinations

import numpy as np

# Rows looked at: what is wrong here is wrong all the time.
MOST, FEWEST = 200, 20
MOVES = 0.05           # [rad/s]
# A joint shows its torque where the model's varies by so many times its noise, and its gain from
# the second on.
SHOWN, LOADED = 2.0, 5.0
# Shares of a joint's variance left from which on it is odd, and from which on wrong.
ODD, WRONG = 0.1, 0.5
# What tells nothing has no more than this share of the variance that there should be. An effort
# is not the joint's where it shares less than the second with its torque, and surely has another
# gain, not another effect, where it shares more than the last.
DEAD, UNLIKE, ALIKE = 0.01, 0.1, 0.5
# No torque constant, and no gear that was exchanged, is off by so much.
LEAST_GAIN, MOST_GAIN = 0.2, 5.0
# A mistake is one when undoing it leaves less than this share of the squared error of the joints
# that err by more than noise, and no more than so many times the noise's square per joint: then
# the model fits.
UNDONE, FITS = 0.25, 10.0
# The worst rows may be a push's.
USUAL = 0.9


def wrong_joint(model, parts):
    """Return a sentence on what the parts (Evidence) of one recording tell wrongly, or ''."""
    rows = _Rows(model, parts)
    if len(rows) < FEWEST:
        return ''
    torques = rows.torques()
    joints = [_Joint(name, *rows.of_joint(j, *torques), noise)
              for j, (name, noise) in enumerate(zip(model.robot.joints, model.noise))
              if rows.moves(j).sum() >= FEWEST]
    shown = [joint for joint in joints if joint.load > SHOWN]
    dead = [joint.name for joint in shown if joint.dead]
    if dead:
        return (f'the effort of {", ".join(dead)} tells nothing: it does not change with the '
                'motion; try `hand_load check`')
    mistake = _mistake(model, rows, any(joint.left > ODD for joint in shown))
    if mistake:
        return (f'fits the model once {mistake}, so it was recorded wrongly; correct the driver '
                'or the robot file, and try `hand_load check`')
    wrong = [f'{joint.gain:.2g} times at {joint.name}' for joint in shown if joint.impossible]
    if not wrong:
        return ''
    return (f'the torque recorded is not the model\'s but {", ".join(wrong)}; no torque constant '
            'is off by so much; the effort has another unit or belongs to another joint; try '
            '`hand_load check`')


class _Joint:
    """One moving joint: its torque measured and modelled (M,) [Nm], its noise [Nm]."""

    def __init__(self, name, measured, modelled, noise):
        self.name = name
        error = np.abs(measured - modelled)
        usual = error <= np.quantile(error, USUAL)
        own = np.maximum(modelled[usual].var(), 1e-12)
        self.load = np.sqrt(own) / noise
        self.left = np.mean(error[usual] ** 2) / own
        self._varies = measured[usual].var() / own
        self.gain = np.cov(measured[usual], modelled[usual], bias=True)[0, 1] / own
        self._shared = self.gain ** 2 / max(self._varies, 1e-12)

    @property
    def dead(self):
        """Whether hardly anything changes, and not as it should."""
        return self._varies < DEAD and self._shared <= UNLIKE

    @property
    def impossible(self):
        """Whether no drive has such a gain."""
        return self.load > LOADED and self.left > WRONG and self._shared > ALIKE \
            and not LEAST_GAIN < self.gain < MOST_GAIN


class _Rows:
    """Some rows of the parts of one recording, in which something moves, for a TorqueModel."""

    def __init__(self, model, parts):
        self._model, self._load = model, parts[0].load
        motion = [np.concatenate([getattr(e.motion, name) for e in parts])
                  for name in ('q', 'v', 'a', 'temperature')]
        tells = np.concatenate([e.tells for e in parts]).all(axis=1)
        moving = np.flatnonzero((np.abs(motion[1]) > MOVES).any(axis=1) & tells)
        some = moving[::max(1, len(moving) // MOST)]
        *self._motion, self._temperature = (values[some] for values in motion)
        torque = np.concatenate([e.torque for e in parts])[some]
        self._constants = model.robot.effort.torque_constants
        self._reported = (torque + self._taken_off(self._motion)) / self._constants

    def __len__(self):
        return len(self._reported)

    def moves(self, j):
        """Tell in which rows (M,) a joint moves."""
        return np.abs(self._motion[1][:, j]) > MOVES

    def of_joint(self, j, *torques):
        """Return the torques (m,) of a joint, of (M, n) each, while it moves."""
        return [torque[self.moves(j), j] for torque in torques]

    def torques(self, signs=None, order=None, only_efforts=False, unsigned=None):
        """
        Return torques (M, n) measured less the load's, and modelled.

        signs (n,): of the efforts or of the angles; order (n,): of the efforts or of everything;
        unsigned: index of a joint of which the effort's size was recorded, and is modelled.
        """
        n = self._model.robot.n
        signs = np.ones(n) if signs is None else signs
        order = np.arange(n) if order is None else order
        reported = self._reported[:, order]
        if only_efforts:
            taken_off, modelled = self._as_told
            measured = reported * signs * self._constants - taken_off
            if unsigned is not None:
                one, modelled = self._constants[unsigned], modelled.copy()
                whole = (taken_off + modelled)[:, unsigned]
                modelled[:, unsigned] = one * np.abs(whole / one) - taken_off[:, unsigned]
            return measured, modelled
        motion = [(values * signs)[:, order] for values in self._motion]
        taken_off, modelled = self._of_motion(motion)
        return reported * self._constants - taken_off, modelled

    @cached_property
    def _as_told(self):
        return self._of_motion(self._motion)

    def _of_motion(self, motion):
        """Return torques (M, n): what is taken off what efforts say, and modelled."""
        return self._taken_off(motion), self._model.torques(*motion, self._temperature)

    def _taken_off(self, motion):
        """Return the torque (M, n) that is taken off what the efforts say, at this motion."""
        robot, out = self._model.robot, np.zeros(motion[0].shape)
        if self._load.mass > 0.0:
            out += np.reshape([robot.load_regressor(*row) @ self._load.to_products()
                               for row in zip(*motion)], out.shape)
        # The controller took its gravity off already: real_torque puts it back.
        return out - np.reshape([robot.configured_torque(q) for q in motion[0]], out.shape)


def _mistake(model, rows, odd):
    """
    Return in words what undone makes the recording fit the model, or ''.

    odd: whether a joint is. Of one that is not, an offset that changed its sign looks like an
    angle that counts the other way; little that an arm has looks like exchanged joints.
    """
    told = _errors(model, *rows.torques())
    erring = told > 1.0
    if not erring.any():
        return ''
    tried = _exchanges(model.robot.joints) + (
        _signs(model.robot.joints) + _lost_signs(model.robot.joints) if odd else [])
    errors, words = min(((_errors(model, *rows.torques(**how)), words)
                         for how, words in tried), key=lambda pair: pair[0].sum())
    # An error that has only gone to the other joint is not undone.
    erring |= errors > 1.0
    undone = (errors[erring].sum() < UNDONE * told[erring].sum()
              and errors.sum() < FITS * len(told))
    return words if undone else ''


def _signs(joints):
    """Return [(arguments of torques() that undo it, words)] of every joint's other sign."""
    out = []
    for i, joint in enumerate(joints):
        signs = np.where(np.arange(len(joints)) == i, -1.0, 1.0)
        out += [({'signs': signs}, f'the angle of {joint} counts the other way'),
                ({'signs': signs, 'only_efforts': True},
                 f'the effort of {joint} has the other sign')]
    return out


def _lost_signs(joints):
    """Return [(arguments of torques() that undo it, words)] of every joint's size of effort."""
    return [({'unsigned': j, 'only_efforts': True},
             f'the effort of {joint} is taken for its size without a sign')
            for j, joint in enumerate(joints)]


def _exchanges(joints):
    """Return [(arguments of torques() that undo it, words)] of every two joints exchanged."""
    out = []
    for i, j in combinations(range(len(joints)), 2):
        order = np.arange(len(joints))
        order[[i, j]] = j, i
        both = f'of {joints[i]} and {joints[j]} are exchanged'
        out += [({'order': order, 'only_efforts': True}, f'the efforts {both}'),
                ({'order': order}, f'angles and efforts {both}')]
    return out


def _errors(model, measured, modelled):
    """Return squared errors (n,) in units of the noise, without the worst rows."""
    squares = np.sort((measured - modelled) ** 2, axis=0)[:int(USUAL * len(measured))]
    return squares.mean(axis=0) / model.noise ** 2
