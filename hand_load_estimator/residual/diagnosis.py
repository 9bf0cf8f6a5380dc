"""What a diagnosis says: effects with their evidence, errors before and after, what remains."""

from dataclasses import dataclass, field

import numpy as np

CONFIRMED, SUSPECTED = 'confirmed', 'suspected'
UNKNOWN = 'unknown'


@dataclass(frozen=True)
class Picture:
    """
    An effect as a mechanical engineer would draw it: residual torque against its variable.

    joint; variable: what is on the x axis, with its unit; x (B,): middles of bins; mean, std (B,)
    [Nm]: what is left in the bins beside the effect with its own torque in it, and the standard
    error of its mean;
    curve, low, high (B,) [Nm]: fitted effect with its 95 % interval.
    """

    joint: str
    variable: str
    x: np.ndarray
    mean: np.ndarray
    std: np.ndarray
    curve: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def fitted(self):
        """Whether there is a fitted effect to draw."""
        return bool(np.any(self.curve))


@dataclass(frozen=True)
class Evidence:
    """
    Why an effect is believed, all from data not used for its fit.

    gain, gain_std [nats]: held-out log-likelihood gained and its standard error over blocks;
    needed [nats]: what had to be gained, corrected for the hypotheses tried; blocks; hypotheses;
    rms [Nm]: torque of the effect at its strongest joint; next_best: the runner-up's name (or
    None) and margin [nats] over it; by_joint {name: nats}: gain at each joint that it moves;
    next_possible: physics allows the runner-up with the figures that fit, and it matters.
    """

    gain: float
    gain_std: float
    needed: float
    blocks: int
    hypotheses: int
    rms: float
    next_best: str | None = None
    margin: float | None = None
    by_joint: dict = field(default_factory=dict)
    next_possible: bool = True


@dataclass(frozen=True)
class Alternative:
    """
    Another explanation that the recordings cannot tell from a Finding: name, joints (names).

    behind, std [nats]: how much less it gains on held-out data (less than nothing where it gains
    more and is no simpler), and the standard error of that difference over blocks; NaN where there
    is but one.
    """

    name: str
    joints: tuple
    behind: float
    std: float


@dataclass(frozen=True)
class Finding:
    """
    One effect found: name, joints (names), parameters {name: (mean, std, unit)}.

    With several joints the parameters' names end in ` (joint)`. explained (n,): share of the
    variance that is left of each joint without the effect, everything else fitted again, that goes
    with it; alternatives: each an Alternative; advice: the motion that would
    tell, or an empty string; changed: the model had it already, with other figures;
    verdict: CONFIRMED or SUSPECTED; variables: what an `unknown` effect depends on; recording:
    the one in which it happened, times counting from its first sample and explained being the
    share of that time; empty for what is always there.
    """

    name: str
    joints: tuple
    parameters: dict
    explained: np.ndarray
    evidence: Evidence
    alternatives: tuple
    advice: str
    changed: bool
    verdict: str
    pictures: tuple = ()
    variables: tuple = ()
    recording: str = ''

    def main_joint(self, joints):
        """Return the index, among names of all joints, of the one that shows it most."""
        shown = self.evidence.by_joint
        if shown:
            return joints.index(max(shown, key=shown.get))
        own = np.array([name in self.joints for name in joints])
        return int(np.argmax(np.where(own, np.nan_to_num(self.explained), -1.0)))


@dataclass(frozen=True)
class Correction:
    """
    A TorqueModel with learned functions for what is unknown; after (n,) [Nm]: its error.

    sliding (n,) [Nm]: what it leaves while joints slide, as of Residuals.
    """

    model: object
    after: np.ndarray
    sliding: np.ndarray


@dataclass(frozen=True)
class LoadError:
    """
    Error of load estimates on n loaded recordings: mass_rmse [kg], com_rmse [m] or None.

    not_asked: recordings in which a network was not asked for want of temperatures.
    """

    mass_rmse: float
    com_rmse: float | None
    n: int
    not_asked: int = 0


@dataclass(frozen=True)
class FineTuning:
    """
    The learned artefact was fine-tuned from the better model.

    started_from: name of the artefact before; load_before, load_after: LoadError of method `lstm`
    with the better model and the artefact as it was and as it is now, or None.
    """

    started_from: str
    load_before: LoadError | None
    load_after: LoadError | None


@dataclass(frozen=True)
class KeptArtefact:
    """
    The learned artefact that is shipped for the arm, left as it is.

    name; load_before, load_after: LoadError of method `lstm` with the old and the better model.
    """

    name: str
    load_before: LoadError
    load_after: LoadError


@dataclass(frozen=True)
class Structure:
    """
    Where a residual lives, joint by joint, on the recordings that were diagnosed.

    rms, noise (n,) [Nm]: while the joint slides, and what of it is noise; share, chance:
    {variable: (n,)}: what a function of the variable, fitted to other blocks, foretells of the
    variance that was structure before anything was added, and up to what share that may be
    chance; pairs, pairs_chance (n, n): the same of joint j (row) by what the motion of joint i
    (column) adds to j's own, and on the diagonal by j's own. NaN: not to be told.
    """

    rms: np.ndarray
    noise: np.ndarray
    share: dict
    chance: dict
    pairs: np.ndarray
    pairs_chance: np.ndarray

    @property
    def structured(self):
        """Share (n,) of the variance that is no noise."""
        return 1.0 - (self.noise / np.maximum(self.rms, 1e-12)) ** 2


@dataclass(frozen=True)
class Diagnosis:
    """
    The whole result; (n,) arrays are per joint.

    before, after [Nm]: torque RMSE of the model as it was and of the one written, on data not used
    for fitting or choosing what was found; noise_floor, noise_most [Nm]: what of `after` is noise
    at least, if it is white, and at most (rest.py); NaN where not known;
    findings: in the order they were found; unexplained (n,): share of the residual variance that
    is surely structure, which no effect explains; cannot_tell: sentences `cannot tell X because
    Y`; load_before, load_after: LoadError, or None with load_reason; recordings, tested_on: names;
    seconds spent; remains: sentences on structure that is left; correction: what is offered for
    it; fine_tuning: what became of the learned artefact, None where it was left as it is; kept:
    a KeptArtefact where it was and loads are known, else None; training: it is being fine-tuned
    meanwhile, and the diagnosis is not the last word on it;
    structure: (Structure before, Structure after), or None; sliding (n,) [Nm]: what the model
    leaves now while joints slide, as of Residuals, or None; seen: names of recordings tested on
    that the model itself was identified from; refitted: it was identified from all of them, and
    before and after are of fits without the part kept for the test; left_out [s]: of that part,
    in which something acted from outside; another_state: most joints differ, each by its own
    cause, so that the arm is rather another one than ailing (another_state.py); stated (n,) [Nm]:
    the error that the model diagnosed states of itself, or None; moved_zero: the first
    sentence of moved_zero.py, or an empty string.
    """

    robot: str
    joints: tuple
    before: np.ndarray
    after: np.ndarray
    noise_floor: np.ndarray
    findings: tuple
    unexplained: np.ndarray
    cannot_tell: tuple = ()
    load_before: LoadError | None = None
    load_after: LoadError | None = None
    load_reason: str = ''
    recordings: tuple = ()
    tested_on: str = ''
    seconds: float = 0.0
    remains: tuple = ()
    correction: Correction | None = None
    fine_tuning: FineTuning | None = None
    kept: KeptArtefact | None = None
    training: bool = False
    structure: tuple | None = None
    sliding: np.ndarray | None = None
    seen: tuple = ()
    refitted: bool = False
    left_out: float = 0.0
    noise_most: np.ndarray | None = None
    another_state: bool = False
    stated: np.ndarray | None = None
    moved_zero: str = ''

    @property
    def unexplained_most(self):
        """Share (n,) of the residual variance that may be structure: all but white noise."""
        return 1.0 - (self.noise_floor / np.maximum(self.after, 1e-12)) ** 2
