"""Candidates for a cause of the residual, and whether held-out blocks tell two of them apart."""

from dataclasses import dataclass, replace

import numpy as np

from .confusable import named_together
from .hypothesis import searched

# Standard errors that a gain, or a difference of two, must be beyond chance.
SIGMAS = 3.0
# Or it gains in this share of the blocks in which it acts, that is moves the likelihood by more
# than ACTS nats; there are at least so many of them, and it gains so many nats in all.
CONSISTENT, ACTS, FEWEST, PLENTY = 0.8, 1.0, 4, 100.0
# Or so many blocks gain PLENTY each, and all that others lose is less than this share of it.
EACH, LOST = 3, 0.02
# Of two that nothing tells apart the simpler is taken if it gains at least this share.
EQUAL = 0.99


@dataclass(frozen=True)
class Candidate:
    """
    One cause with its evidence: parts (Hypothesis, Score) on one or more joints.

    gain, std, by_block [nats] of all parts together; common: they share their parameters.
    """

    name: str
    parts: tuple
    gain: float
    std: float
    by_block: np.ndarray
    common: bool = False

    @property
    def joints(self):
        """Indices of the joints it stands for."""
        return sorted({h.joint for h, _ in self.parts})

    @property
    def touched(self):
        """Indices of all joints it moves."""
        return sorted({j for h, _ in self.parts for j in h.columns})

    @property
    def columns(self):
        """Columns {joint: (N, k)} of all parts."""
        own = {}
        for hypothesis, _ in self.parts:
            for j, columns in hypothesis.columns.items():
                own[j] = np.hstack([own[j], columns]) if j in own else columns
        return own

    @property
    def size(self):
        """Number of parameters, those of its shapes included."""
        return sum(len(h.scale) + len(searched(h))
                   for h, _ in (self.parts[:1] if self.common else self.parts))

    @property
    def variable(self):
        """What an unknown effect is a function of."""
        return self.parts[0][0].variable

    def torque(self, n):
        """Return its torque (N, n) [Nm]."""
        first = next(iter(self.parts[0][0].columns.values()))
        out = np.zeros((len(first), n))
        for hypothesis, score in self.parts:
            for j, columns in hypothesis.columns.items():
                out[:, j] += columns @ score.theta
        return out


@dataclass(frozen=True)
class Step:
    """
    One accepted Candidate.

    alternatives: Candidates that the blocks cannot tell from it; next_best: the runner-up;
    needed [nats]; expected: the model says to expect as much, so that it is nothing new;
    next_possible: physics allows the runner-up as it was fitted, and it matters.
    """

    chosen: Candidate
    alternatives: tuple
    next_best: Candidate | None
    needed: float
    expected: bool = False
    next_possible: bool = True


def single(hypothesis, score):
    """Return the Candidate of one hypothesis."""
    return Candidate(hypothesis.name, ((hypothesis, score),), score.gain, score.std,
                     score.by_block)


def joined(name, parts):
    """Return the Candidate of parts (Hypothesis, Score) that have one cause."""
    by_block = sum(score.by_block for _, score in parts)
    return Candidate(name, parts, float(by_block.sum()), standard_error(by_block), by_block)


def in_common(hypothesis, score):
    """Return the Candidate of one hypothesis on several joints, in parts for each of them."""
    parts = tuple((hypothesis.at(j), replace(score, by_joint={j: score.by_joint[j]}))
                  for j in hypothesis.columns)
    return Candidate(hypothesis.name, parts, score.gain, score.std, score.by_block, True)


def hypotheses_of(candidate):
    """Return the Hypotheses of a Candidate: one where its joints share their parameters."""
    found = [hypothesis for hypothesis, _ in candidate.parts]
    if not candidate.common:
        return found
    columns = {j: own for hypothesis in found for j, own in hypothesis.columns.items()}
    prompt = {j: own for hypothesis in found for j, own in (hypothesis.prompt or {}).items()}
    return [replace(found[0], joint=None, columns=columns, prompt=prompt or None)]


def with_hypotheses(candidate, hypotheses):
    """Return the Candidate with other Hypotheses for hypotheses_of, the evidence as it was."""
    made = [h.at(j) for h in hypotheses for j in h.columns] if candidate.common else hypotheses
    parts = tuple((h, score) for h, (_, score) in zip(made, candidate.parts))
    return replace(candidate, parts=parts)


def evaluated(candidate, blocks, without=None):
    """
    Return the same Candidate with its evidence on Blocks.

    without: Blocks as they are without it, if it changes what else there is.
    """
    pairs = tuple((h, _against(blocks.evaluate(h.columns), h.columns, blocks, without or blocks))
                  for h in hypotheses_of(candidate))
    return in_common(*pairs[0]) if candidate.common else joined(candidate.name, pairs)


def _against(score, joints, blocks, without):
    """Return a Score on Blocks, against others."""
    if blocks is without:
        return score
    more = {j: without.misfit(j) - blocks.misfit(j) for j in joints}
    by_block = score.by_block + sum(more.values())
    return replace(score, gain=float(by_block.sum()), std=standard_error(by_block),
                   by_block=by_block, by_joint={j: score.by_joint[j] + float(more[j].sum())
                                                for j in joints})


def standard_error(by_block):
    """Return the standard error [nats] of the sum of nats by block (B,)."""
    return float(np.sqrt(len(by_block)) * by_block.std())


def ahead(best, other):
    """Return a Candidate that gains what the best of two gains more than the other."""
    by_block = best.by_block - other.by_block
    return Candidate(best.name, best.parts, float(by_block.sum()), standard_error(by_block),
                     by_block)


def significant(candidate):
    """
    Tell whether a gain is more than chance: by its standard error, or nearly wherever it acts.

    An effect that only warm recordings show, or play that only a few poses cross, gains very
    unequally and still surely. A gap that is crossed three times gains nothing in all other
    blocks: its standard error is as large as it is, but each time was foretold from the others.
    """
    by_block = candidate.by_block
    plain = candidate.gain > SIGMAS * candidate.std
    acting = by_block[np.abs(by_block) > ACTS]
    nearly_always = len(acting) >= FEWEST and (acting > 0.0).mean() > CONSISTENT
    rarely = (by_block > PLENTY).sum() >= EACH \
        and -by_block[by_block < 0.0].sum() < LOST * candidate.gain
    return bool(plain or (nearly_always and candidate.gain > PLENTY) or rarely)


def tied(best, other):
    """Tell whether held-out blocks do not prefer the better of two candidates."""
    difference = ahead(best, other)
    return difference.gain < 2.0 * difference.std and other.gain > EQUAL * best.gain


def alike(best, other):
    """
    Tell whether blocks cannot tell which of two candidates is the cause.

    The lesser of them must be more than chance itself.
    """
    return significant(other) and (not significant(ahead(best, other))
                                   or named_together(best, other))
