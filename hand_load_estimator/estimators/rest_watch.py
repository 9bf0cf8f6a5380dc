"""
Notice a load change while the arm stands.

At rest friction hides small changes, but not large ones: a joint's friction lies between its two
Coulomb levels, so a torque beyond that from what model and believed load explain has another
cause. Where another load would show in other joints as well and does not, that is a joint which
holds more than the model says. What stays hidden is found when the arm moves (change.py).
"""

import numpy as np

# Faster or harder than this [rad/s], [rad/s^2] the arm does not stand: the load's inertia shows.
STILL, UNFORCED = 0.02, 0.3
# The torque must be beyond for so long [s], or it is a knock or the arm settling; and within, or
# it is noise.
LASTING = 0.1
# Of what may hide in a joint, what shows: in development arms a joint that sticks leaves others
# below 0.4, a changed load one above 0.5.
SHOWS = 0.5
# Static friction exceeds the Coulomb level; noise and belief count in standard deviations.
MARGIN, SIGMAS = 1.3, 4.0

NOTHING, STICKS, ANOTHER_LOAD = range(3)


class RestWatch:
    """
    Compare a standing arm's innovation with what friction and belief can explain.

    joints: names; noise (n,) [Nm]: residual RMS of the torque model; change (10, 10): covariance
    of what the products may change by with the load. reason: which joint sticks, or an empty
    string.
    """

    def __init__(self, joints, noise, change):
        self._joints, self._variance, self._change = joints, noise ** 2, change
        self.restart()

    def restart(self):
        """Begin anew, as after a change."""
        self._beyond, self._within, self.reason = 0.0, 0.0, ''

    def update(self, sample, innovation, spread, prediction):
        """
        Take a MotionSample, its innovation (n,) [Nm], the belief's variance of it [Nm^2] and the
        Prediction, whose friction [Nm] is the level that joints can hold.

        Return NOTHING, or what has been beyond that for as long as it takes: STICKS, which may be
        a contact instead, or ANOTHER_LOAD, which may be one, too.
        """
        if np.abs(sample.v).max() > STILL or np.abs(sample.a).max() > UNFORCED:
            self.restart()
            return NOTHING
        limit = MARGIN * prediction.friction + SIGMAS * np.sqrt(self._variance + spread)
        beyond = (np.abs(innovation) > limit).any()
        self._beyond = self._beyond + sample.dt if beyond else 0.0
        self._within = 0.0 if beyond else self._within + sample.dt
        if self._within >= LASTING:
            self.reason = ''
        if self._beyond < LASTING:
            return NOTHING
        self._beyond = 0.0
        joint = int(np.argmax(np.abs(innovation) / limit))
        if self._may_be_a_load(joint, np.abs(innovation), limit, prediction.load_columns):
            self.restart()
            return ANOTHER_LOAD
        self.reason = (f'{self._joints[joint]} holds {np.abs(innovation[joint]):.1f} Nm more than '
                       'load and friction explain, and no other joint does: it sticks, or another '
                       'load is held; it shows when the arm moves')
        return STICKS

    def _may_be_a_load(self, joint, innovation, limit, load_columns):
        """Tell whether another load may make innovations of such sizes (n,) [Nm]."""
        # What loads usually make of torque; of one that shows so much there, of what may hide.
        usual = np.sqrt(((load_columns @ self._change) * load_columns).sum(axis=1))
        if innovation[joint] > SIGMAS * usual[joint]:
            return False
        would = usual * (innovation[joint] / usual[joint]) / limit
        others = np.arange(len(limit)) != joint
        return bool((innovation > SHOWS * limit)[others].any()
                    or (would <= SHOWS)[others].all())
