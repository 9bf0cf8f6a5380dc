"""
Two causes of one joint that no single one shows.

Viscous and Coulomb friction together look like a lubricant that thins; a spring and Coulomb
friction look like nothing that has a name. Where what was to be chosen leaves more than chance,
or has no name, every cause of its joint is tried with the two that gain most beside it.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...effects import LATE
from ..diagnosis import UNKNOWN
from ..doubts.unfounded import EXACT
from .candidate import ahead, Candidate, joined, significant, single, Step, tied
from .choice import chosen_step
from .delay_among_others import delay_among, delayed
from .finer_shape import best_of_each, finer, search_around
from .hypotheses import of_joint
from .hypothesis import beside_delays

# Of each cause so many others beside it make a pair; the shapes of so many pairs are searched.
PARTNERS, FINISHED = 2, 4
# Of a gap all shapes take longer than those of all else: beside another the likeliest is asked.
LIKELIEST_ONLY = 'backlash'
# In place of what has no name a pair explains at least this share of what that explains together
# with the next.
CLOSE = 0.97


@dataclass(frozen=True)
class Pair:
    """
    Two Candidates of one joint: first, evaluated alone; second, evaluated beside the first.

    Nuisances are each joint's own: only one that moves a single joint may stand first, or both
    would gain what they do not together.
    """

    first: Candidate
    second: Candidate

    @property
    def names(self):
        """The names of both."""
        return {self.first.name, self.second.name}

    @property
    def both(self):
        """The Candidate of both together."""
        return joined('both', (*self.first.parts, *self.second.parts))


class Together:
    """
    The search for two causes at joint j, beside all that was found before.

    model, residual, warmed: as of Trace; blocks: Blocks with what was found; taken: keys of that;
    singles: Candidates of the joint's other named effects, alone;
    allowed(hypothesis, score): whether physics allows what was fitted.
    """

    def __init__(self, model, residual, warmed, blocks, j, taken, singles, allowed):
        self._model, self._residual, self._warmed = model, residual, warmed
        self._blocks, self._j, self._taken = blocks, j, taken
        self._singles = singles
        self._gap = next((c for c in singles if c.name == LIKELIEST_ONLY), None)
        self._allowed = allowed

    def instead_of(self, chosen, needed, matters):
        """
        Return the Steps of two effects that explain better what a Candidate does, or ().

        needed [nats]; matters: tells whether a Candidate's torque is worth a place.
        """
        next_best = self._beside(chosen)
        late = self._with_its_delay(chosen)
        steps = self._delayed(late, chosen, next_best, needed) if late else ()
        # What has no name may leave nothing, and two with names explain as much.
        if steps or chosen.name != UNKNOWN and (
                not next_best or next_best[0].gain < needed):
            return steps
        pairs = [Pair(c, other) for c in self._singles
                 if c.name != chosen.name and len(c.touched) == 1
                 for other in self._named(c)[:PARTNERS] if other.name != chosen.name]
        if late:
            pairs.append(late)
        if not pairs:
            return ()
        best = self._best(pairs)
        # Every pair is a trial, too.
        least = needed + np.log(len(pairs))
        if best is None or not self._better(best.both, chosen, next_best, least) \
                or not self._beyond_form(best.both, chosen, least):
            return ()
        steps = self._steps(best, chosen.name, needed)
        return steps if all(s.chosen.gain > needed and significant(s.chosen) and matters(s.chosen)
                            and self._allowed(*s.chosen.parts[0]) for s in steps) else ()

    def _with_its_delay(self, chosen):
        """Return the Pair of the joint's delay and a Candidate that it delays, or None."""
        delay = next((c for c in self._singles if c.name == LATE), None)
        if delay is None or chosen.name in (LATE, UNKNOWN):
            return None
        pair = self._finished(Pair(delay, chosen))
        return pair if self._possible(pair) else None

    def _delayed(self, pair, chosen, next_best, needed):
        """
        Return the Steps of a delay and what it delays, or ().

        Beside what it delays, undelayed, a delay may gain nothing: it counts with all that is
        lost without it, which must be more than anything else gains beside the Candidate.
        """
        least = needed + max([0.0] + [c.gain for c in next_best if c.name != LATE])
        if not _surely(pair.both, chosen, least):
            return ()
        second = _step(pair.second, self._named(pair.first), {LATE}, needed)
        pair = Pair(pair.first, second.chosen)
        if not self._possible(pair) or not _surely(pair.both, chosen, least):
            return ()
        delay, lost = self._beside_other(pair.first, pair.second), ahead(pair.both, chosen)
        worth = replace(delay, gain=lost.gain, std=lost.std, by_block=lost.by_block)
        rival = next((c for c in next_best if c.name not in (LATE, UNKNOWN)), None)
        return Step(worth, (), rival, needed), second

    def _better(self, both, chosen, next_best, needed):
        if chosen.name == UNKNOWN:
            left = max([0.0] + [c.gain for c in next_best[:1]])
            return both.gain > CLOSE * (chosen.gain + left)
        named = next((c for c in next_best if c.name != UNKNOWN), None)
        if named is None:
            return False
        rival = self._finished(Pair(*sorted((chosen, named), key=lambda c: len(c.touched)))).both
        # Fewer parameters need not gain more by what chance and trials ask for.
        return _surely(both, rival, needed) or (
            both.size < rival.size and both.gain > rival.gain)

    def _beyond_form(self, both, chosen, needed):
        """Tell whether two explain more than the finer form of one does, never exact itself."""
        if chosen.name == UNKNOWN:
            return True
        alone = finer(chosen, self._blocks, self._model, self._residual, self._warmed)
        # How friction turns is fitted to reversals, which these blocks leave out.
        alone = max((alone, chosen), key=lambda one: one.gain)
        return _surely(both, alone, max(needed, EXACT ** 2 * alone.gain))

    def _best(self, pairs):
        """Return the best of Pairs, the best few with their shapes searched, or None."""
        ranked = sorted(pairs, key=lambda pair: -pair.both.gain)
        # The same two in the other order are no other pair.
        kept = [pair for k, pair in enumerate(ranked)
                if pair.names not in [other.names for other in ranked[:k]]]
        finished = [pair for pair in map(self._finished, kept[:FINISHED])
                    if self._possible(pair)]
        best = max(finished, key=lambda pair: pair.both.gain, default=None)
        return best and min((pair for pair in finished if pair is best
                             or tied(best.both, pair.both)),
                            key=lambda pair: (pair.both.size, -pair.both.gain))

    def _finished(self, pair):
        """Return a Pair with the shapes of both searched, each beside the other."""
        first = self._searched(pair.first, pair.second)
        second = self._searched(pair.second, first)
        hypothesis = beside_delays(first.parts[0][0], self._late(second))
        return Pair(single(hypothesis, self._blocks.evaluate(hypothesis.columns)), second)

    def _searched(self, candidate, beside):
        hypothesis, other = candidate.parts[0][0], beside.parts[0][0]
        if hypothesis.name == LATE:
            moved = delay_among(hypothesis, [other], self._blocks, self._model, self._residual)
            other = beside_delays(other, delayed(self._residual, moved))
            return single(moved, self._blocks.beside(other.columns).evaluate(moved.columns))
        blocks, residual = self._blocks_beside(beside), self._late(beside)
        hypothesis = beside_delays(hypothesis, residual)
        return single(*search_around((hypothesis, blocks.evaluate(hypothesis.columns)), blocks,
                                     self._model, residual)[0])

    def _late(self, candidate):
        """Return the Residual beside a Candidate, which may be a delay."""
        return delayed(self._residual, candidate.parts[0][0]) if candidate.name == LATE \
            else self._residual

    def _possible(self, pair):
        """Tell whether physics allows either of two beside the other: two may make up for each."""
        first = self._beside_other(pair.first, pair.second)
        return self._allowed(*first.parts[0]) and self._allowed(*pair.second.parts[0])

    def _beside_other(self, candidate, other):
        hypothesis = candidate.parts[0][0]
        return single(hypothesis, self._blocks_beside(other).evaluate(hypothesis.columns))

    def _steps(self, pair, instead_of, needed):
        """Return the Steps of both, each with what else there is beside the other."""
        second = _step(pair.second, self._named(pair.first), {pair.first.name, instead_of}, needed)
        first = _step(self._beside_other(pair.first, second.chosen), self._named(second.chosen),
                      {second.chosen.name, instead_of}, needed)
        return first, replace(second, chosen=self._beside_other(second.chosen, first.chosen))

    def _named(self, beside):
        """Return Candidates of named effects beside one, the best first."""
        return [c for c in self._beside(beside) if c.name != UNKNOWN]

    def _beside(self, beside):
        """Return Candidates of this joint beside one that is not taken yet, the best first."""
        blocks = self._blocks_beside(beside)
        done = {*self._taken, *(h.key for h, _ in beside.parts)}
        residual = self._late(beside)
        asked = list(of_joint(self._model, residual, blocks, self._warmed, self._j,
                              {*done, (LIKELIEST_ONLY, self._j, '')}))
        if self._gap is not None and self._gap.parts[0][0].key not in done:
            asked.append(beside_delays(self._gap.parts[0][0], residual))
        found, _ = best_of_each(asked, blocks)
        return sorted((single(*pair) for pair in found.values() if self._allowed(*pair)),
                      key=lambda c: -c.gain)

    def _blocks_beside(self, candidate):
        return self._blocks.beside(candidate.columns)


def _surely(both, alone, least):
    """Tell whether two gain surely as much more [nats] than one Candidate."""
    beyond = ahead(both, alone)
    return beyond.gain > least and significant(beyond)


def _step(one, rivals, taken, needed):
    """Return the Step of one of a pair, or of a simpler Candidate as good whose name is free."""
    step = chosen_step(one, [one, *rivals], needed, rivals)
    if step.chosen is one or step.chosen.name not in taken:
        return step
    beside = tuple(c for c in (step.chosen, *step.alternatives) if c.name != one.name)
    return Step(one, beside, step.chosen, needed)
