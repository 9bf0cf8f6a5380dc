"""
Keep contact out of the estimate: a sudden torque that no load explains.

The innovation e (n,) of a sample is judged by c = e^T (D + N N^T + K P K^T)^-1 e, where D holds
noise and held friction, N what the model is unsure of and K P K^T whatever load may be held
instead of the believed one. A push on the hand makes torques no load could; another load does
not. What is unexplained all the time is no contact but the model's misfit (mismatch.py).
"""

import numpy as np

from .positive_solve import positive_solve

# A sample is left out above this c for six joints (chance: 1e-7) and this share of the c that
# is left without K P K^T: another load that the model gets wrong by a tenth is still a load.
LIMIT_PER_JOINT, SHARE = 7.0, 0.05
# The usual c is a mean over this memory [s]; more than usual is sudden. Nothing is, before a joint
# has slid for so long [s]: a wrong model shows from the start, when friction is known.
MEMORY, ARMED, KNOWN = 5.0, 1.0, 0.05
# So many seconds in a row are a contact. It is over after so many with the believed load, or
# after so many that another load explains: a push may look like one for a while.
SHORTEST, OVER, OVER_WITH_ANOTHER = 0.05, 0.1, 0.5
# What is found while the arm stands holds for so long [s], until it is looked at again.
STANDING_HOLD = 0.3
# After so long [s] it is not sudden any more: let through, or a misread load is never found.
LONGEST = 8.0
# Static friction may exceed the Coulomb level by this factor, and a model misread a load's torque
# by this share.
STATIC, MISREAD = 1.3, 0.03
# Sweeps over the joints in search of the friction that explains most.
_SWEEPS = 30


class ContactGate:
    """
    Tell which samples to leave out of the estimate.

    joints: names; rmse (n,) [Nm]: residual of the torque model; change (10, 10): covariance of
    what the products may change by with the load; gain_doubt: relative standard deviation of
    torque constants. reason: why, in words, while in contact; explained: whether the believed
    load alone explains the last sample.
    """

    def __init__(self, joints, rmse, change, gain_doubt=0.0):
        self._joints, self._variance = joints, rmse ** 2
        self._doubt = max(gain_doubt, MISREAD) ** 2
        values, vectors = np.linalg.eigh(change)
        self._root = vectors * np.sqrt(np.maximum(values, 0.0))
        self._limit = LIMIT_PER_JOINT * len(joints)
        self._usual = self._seen = 0.0
        self.clear()

    def clear(self):
        """Forget a contact; what is usual stays."""
        self._beyond, self._calm, self.reason = 0.0, OVER, ''
        self._lasting, self._peak, self.explained = 0.0, 0.0, True

    def hold(self):
        """Be in contact: a push was told that at any one moment another load explains, too."""
        self.clear()
        self._calm, self.reason = 0.0, (
            'contact: a push on the hand explains the torques, no load does for long; kept out of '
            'the estimate')

    def update(self, prediction, innovation, load_torque, dt, pushed=False):
        """
        Take a Prediction, innovation and believed load torque (n,) [Nm]; dt [s].

        pushed: whether a push is known to go on. Return whether to leave the sample out.
        """
        unexplained, left, alone = self._unexplained(prediction, innovation, load_torque)
        if prediction.doubt.min() < KNOWN:
            self._seen += dt
        limit = self._sudden()
        over = self._seen > ARMED and unexplained > max(limit, SHARE * alone)
        if not over:
            # A plain mean until there is as much as the memory holds.
            memory = max(min(self._seen, MEMORY), dt)
            self._usual += dt / memory * (unexplained / len(left) - self._usual)
        self._beyond = self._beyond + dt if over else 0.0
        self.explained = alone < limit
        calm = dt if self.explained else 0.0 if pushed else dt * OVER / OVER_WITH_ANOTHER
        self._calm = 0.0 if over else self._calm + calm
        contact = self._beyond >= SHORTEST or bool(self.reason and self._calm < OVER)
        if not contact:
            self._lasting, self._peak, self.reason = 0.0, 0.0, ''
            return over
        self._lasting, self._peak = self._lasting + dt, max(self._peak, unexplained)
        if self._lasting > LONGEST:
            # From here on this is what is usual, and twice as much is not sudden.
            self._usual = 2.0 * self._peak / self._limit
            self.clear()
            return False
        if over:
            self._say(left)
        return True

    def explains(self, prediction, innovation, load_torque):
        """Tell whether a load alone explains a sample; arguments as of update, of that load."""
        _, _, alone = self._unexplained(prediction, innovation, load_torque)
        return alone < self._sudden()

    def _sudden(self):
        """Return the c beyond which a sample is more than usual."""
        return self._limit * max(self._usual, 1.0)

    def refuses(self, prediction, innovation, load_torque):
        """
        Tell whether a standing arm's innovation (n,) [Nm] is a contact and not another load.

        It is when no load explains it with any friction that joints at rest may hold; for update()
        that friction is only a wide doubt.
        """
        own = self._variance + self._doubt * (load_torque + innovation) ** 2
        known, free = self._covariances(prediction, own)
        inverse = np.linalg.inv(known + free)
        left = innovation - _friction(inverse, innovation, STATIC * prediction.friction)
        unexplained = left @ inverse @ left
        if unexplained < max(self._sudden(), SHARE * (innovation ** 2 / own).sum()):
            return False
        self._peak = max(self._peak, unexplained)
        self._calm = OVER - STANDING_HOLD
        self._say(own * (inverse @ left))
        return True

    def _say(self, left):
        worst = int(np.argmax(np.abs(left) / np.sqrt(self._variance)))
        self.reason = (f'contact: sudden {abs(left[worst]):.1f} Nm on {self._joints[worst]} '
                       'that no load explains; kept out of the estimate')

    def _covariances(self, prediction, own):
        """Return (n, n) [Nm^2]: of all but another load, with own (n,) noise, and of that."""
        known = prediction.model_columns.dot(prediction.model_columns.T)
        known.ravel()[::len(own) + 1] += own
        free = prediction.load_columns.dot(self._root)
        return known, free.dot(free.T)

    def _unexplained(self, prediction, innovation, load_torque):
        """Return c, the torque (n,) [Nm] that is noise at best, and c without another load."""
        own = self._variance + np.minimum(prediction.stuck, (STATIC * prediction.friction) ** 2)
        own = own + self._doubt * (load_torque + innovation) ** 2
        known, free = self._covariances(prediction, own)
        weighed = positive_solve(known + free, innovation)
        alone = innovation @ positive_solve(known, innovation)
        return innovation @ weighed, own * weighed, alone


def _friction(inverse, innovation, held):
    """Return the friction (n,) [Nm] within bounds `held` that leaves least of an innovation."""
    friction = np.zeros(len(innovation))
    for _ in range(_SWEEPS):
        for j, bound in enumerate(held):
            pull = inverse[j] @ (innovation - friction) / inverse[j, j]
            friction[j] = min(max(friction[j] + pull, -bound), bound)
    return friction
