"""Mean and covariance of one estimate, which arrive on topics of their own."""

import numpy as np

_KEPT = 10  # of each kind, as many as the topics keep
_SAME = 1e-6  # relative: the numbers went through no computation but a root and a square


class LoadPairing:
    """
    Joins mean, variance and covariance of one estimate, whatever order they come in.

    The covariance message has no stamp: it belongs to the mean whose stamp has the variance
    that is its diagonal. mean(), variance() and covariance() return (mean (10,), covariance
    (10, 10)) when an estimate is complete, else None. unpaired: covariances without a mean.
    """

    def __init__(self):
        self._means, self._variances, self._covariances = {}, {}, []
        self.unpaired = 0

    def mean(self, stamp, vector):
        """Take a mean (10,) in message order; stamp: anything that tells messages apart."""
        return self._note(self._means, stamp, vector)

    def variance(self, stamp, vector):
        """Take the variance (10,) of a stamp."""
        return self._note(self._variances, stamp, vector)

    def covariance(self, matrix):
        """Take a covariance (10, 10)."""
        self._covariances.append(matrix)
        if len(self._covariances) > _KEPT:
            del self._covariances[0]
            self.unpaired += 1
        return self._complete()

    def _note(self, kept, stamp, vector):
        kept.pop(stamp, None)
        kept[stamp] = np.asarray(vector, dtype=float)
        if len(kept) > _KEPT:
            del kept[next(iter(kept))]
        return self._complete()

    def _complete(self):
        for stamp in reversed([s for s in self._means if s in self._variances]):
            for k in reversed(range(len(self._covariances))):
                covariance = self._covariances[k]
                if np.allclose(np.diag(covariance), self._variances[stamp], _SAME, 0.0):
                    mean = self._means[stamp]
                    self.unpaired += k
                    del self._covariances[:k + 1]
                    _forget(self._means, stamp)
                    _forget(self._variances, stamp)
                    return mean, covariance
        return None


def _forget(kept, stamp):
    """Drop what came up to a stamp."""
    for each in list(kept):
        del kept[each]
        if each == stamp:
            return
