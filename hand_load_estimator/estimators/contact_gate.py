"""
Keep contact out of the estimate: a sudden torque that no load explains.

The innovation e (n,) of a sample is judged by c = e^T (D + N N^T + K P K^T)^-1 e, where D holds
noise and held friction, N the model's own uncertainty and K P K^T whatever load may be held
instead of the believed one. A push on the hand makes torques no load could; another load does
not. What is unexplained all the time is no contact but the model's misfit (mismatch.py).
"""

import numpy as np

# A sample is left out above this c for six joints (chance: 1e-7) and this share of the c that
# is left without K P K^T: another load that the model gets wrong by a tenth is still a load.
LIMIT_PER_JOINT, SHARE = 7.0, 0.05
# The usual c is a mean over this memory [s]; more than usual is sudden.
MEMORY = 5.0
# So many seconds in a row are a contact. It is over after so many with the believed load, or
# after so many that another load explains: a push may look like one for a while.
SHORTEST, OVER, OVER_WITH_ANOTHER = 0.05, 0.1, 1.0
# After so long [s] it is not sudden any more: let through, or a misread load is never found.
LONGEST = 8.0
# Static friction may exceed the Coulomb level by this factor.
STATIC = 1.3


class ContactGate:
    """
    Tell which samples to leave out of the estimate.

    joints: names; rmse (n,) [Nm]: residual of the torque model; level (n,) [Nm]: its friction;
    change (10, 10): covariance of what the products may change by with the load; gain_doubt:
    relative standard deviation of torque constants. reason: why, in words, while in contact.
    """

    def __init__(self, joints, rmse, level, change, gain_doubt=0.0):
        self._joints, self._variance = joints, rmse ** 2
        self._held, self._doubt = (STATIC * level) ** 2, gain_doubt ** 2
        values, vectors = np.linalg.eigh(change)
        self._root = vectors * np.sqrt(np.maximum(values, 0.0))
        self._limit = LIMIT_PER_JOINT * len(joints)
        self._usual = 0.0
        self.clear()

    def clear(self):
        """Forget a contact; what is usual stays."""
        self._beyond, self._calm, self._lasting, self.reason = 0.0, OVER, 0.0, ''

    def update(self, prediction, innovation, load_torque, dt):
        """
        Take a Prediction, innovation and believed load torque (n,) [Nm]; dt [s].

        Return whether to leave the sample out.
        """
        unexplained, left, alone = self._unexplained(prediction, innovation, load_torque)
        limit = self._limit * max(self._usual, 1.0)
        over = unexplained > limit and unexplained > SHARE * alone
        if not over:
            self._usual += min(dt / MEMORY, 1.0) * (unexplained / len(left) - self._usual)
        self._beyond = self._beyond + dt if over else 0.0
        calm = dt if alone < limit else dt * OVER / OVER_WITH_ANOTHER
        self._calm = 0.0 if over else self._calm + calm
        contact = self._beyond >= SHORTEST or bool(self.reason and self._calm < OVER)
        self._lasting = self._lasting + dt if contact or over else 0.0
        if self._lasting > LONGEST:
            self._usual = max(self._usual, unexplained / self._limit)
            self.reason = ''
            return False
        if not contact:
            self.reason = ''
        elif over:
            worst = int(np.argmax(np.abs(left) / np.sqrt(self._variance)))
            self.reason = (f'contact: sudden {abs(left[worst]):.1f} Nm on {self._joints[worst]} '
                           'that no load explains; kept out of the estimate')
        return over or contact

    def _unexplained(self, prediction, innovation, load_torque):
        """Return c, the torque (n,) [Nm] that is noise at best, and c without another load."""
        own = self._variance + np.minimum(prediction.stuck, self._held)
        own = own + self._doubt * (load_torque + innovation) ** 2
        known = prediction.model_columns @ prediction.model_columns.T
        known[np.diag_indices(len(own))] += own
        free = prediction.load_columns @ self._root
        solved = np.linalg.solve(np.stack([known + free @ free.T, known]), innovation[:, None])
        weighed = solved[0, :, 0]
        return innovation @ weighed, own * weighed, innovation @ solved[1, :, 0]
