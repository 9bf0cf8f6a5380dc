"""
What a trace has found so far, each beside all the rest.

A shape that was found while another effect was still in the residual has taken some of it: what is
found at a joint settles with what was found there before. A delay delays all of it.
"""

from dataclasses import replace

from ...effects import LATE
from ..diagnosis import UNKNOWN
from .candidate import alike, evaluated, hypotheses_of, with_hypotheses
from .choice import looks_like
from .delay_among_others import delay_among, delayed
from .finer_shape import finer, searched_again
from .hypothesis import beside_delays


class Found:
    """
    Steps found on a Residual, in their order.

    model, residual, warmed, root: as of Trace; possible(candidate): whether physics allows it and
    it matters; taken: keys of all Hypotheses ever found; residual: with the delays found.
    """

    def __init__(self, model, residual, warmed, root, possible):
        self._model, self._warmed, self._root = model, warmed, root
        self._possible = possible
        self.residual = residual
        self._all, self.taken = [], set()

    @property
    def steps(self):
        """What is new."""
        return [step for step in self._all if not step.expected]

    @property
    def drifted(self):
        """Changes of declared effects no larger than the model says to expect."""
        return [step for step in self._all if step.expected]

    @property
    def newest(self):
        """The Step added last, new or not."""
        return self._all[-1]

    def blocks(self):
        """Return Blocks with everything found for nuisances."""
        return self._blocks_of(self._all)

    def beside(self, *steps):
        """Return Blocks with all steps but these for nuisances."""
        return self._blocks_of(self._others(*steps))

    def evidence(self, step):
        """Return the Candidate of a Step against all other steps as they are without it."""
        late = step.chosen.name == LATE
        return evaluated(step.chosen, self.beside(step), self.without(step) if late else None)

    def without(self, step):
        """Return Blocks with all other steps as they are without a Step."""
        return self._blocks_of(*self._without(step))

    def _without(self, step):
        """Return the other steps, and the Residual, as they are without a Step."""
        others = self._others(step)
        if step.chosen.name != LATE:
            return others, self.residual
        # Nothing else is late then.
        residual = self._with_delays(others)
        return [_step_delayed(other, residual) for other in others], residual

    def weigh_again(self):
        """Weigh every Step, and what else it may be, beside all other steps."""
        self._all = [self._weighed(step) for step in self._all]

    def _weighed(self, step):
        """Return a Step, its rivals in its place, without what other steps have found since."""
        others, residual = self._without(step)
        blocks, chosen = self._blocks_of(others, residual), self.evidence(step)
        found = {h.key for other in others for h, _ in other.chosen.parts}
        rivals = [(evaluated(_delayed(c, residual), blocks),
                   any(c is other for other in step.alternatives))
                  for c in _rivals(step) if not found & {h.key for h, _ in c.parts}]
        best = max((c for c, _ in rivals if c.gain > 0.0), key=lambda c: c.gain, default=None)
        alternatives = tuple(c for c, named in rivals if named and alike(chosen, c))
        return replace(
            step, chosen=chosen, alternatives=alternatives, next_best=best,
            next_possible=best is None or any(c is best for c in alternatives)
            or self._possible(best))

    def with_finer_shapes(self, steps):
        """Return Steps found together, each with its finer shape beside the others."""
        self._tell_delays(steps)
        steps, before = list(steps), self.blocks()
        for k, step in enumerate(steps):
            blocks = before
            for other in steps[:k] + steps[k + 1:]:
                blocks = blocks.beside(other.chosen.columns)
            steps[k] = replace(step, chosen=finer(step.chosen, blocks, self._model,
                                                  self.residual, self._warmed))
        return steps

    def add(self, step):
        """Add a Step."""
        self._all.append(step)
        self.taken |= {h.key for h, _ in step.chosen.parts}

    def drop(self, step):
        """Drop a Step; what it delayed comes no longer late."""
        del self._all[self._place(step)]
        self._tell_delays()

    def put(self, step, other):
        """Put a Step in the place of another."""
        self._all[self._place(other)] = step
        self._tell_delays()

    def settle(self):
        """
        Search shapes again, of what was found at the joints of the last Step, then of that.

        Returns the indices of the joints where anything may have changed.
        """
        last = len(self._all) - 1
        new = self._all[last].chosen
        earlier = [k for k, step in enumerate(self._all[:last])
                   if not step.expected and step.chosen.name != UNKNOWN
                   and set(new.touched) & set(step.chosen.touched)]
        if new.name == UNKNOWN or not earlier:
            return set()
        places = [*earlier, last]
        # What a delay delays and the delay itself are told from one another by turns.
        delays = [k for k in places if self._all[k].chosen.name == LATE]
        others = [k for k in places if k not in delays]
        for _ in range(2 if delays else 1):
            for k in delays:
                self._search_delay(k, places)
            for k in others:
                self._search_again(k)
        return {j for k in places for j in (*new.touched, *self._all[k].chosen.touched)}

    def _search_again(self, k):
        """Search the shapes of the Step at k again, and what it looks like now."""
        step, blocks = self._all[k], self.beside(self._all[k])
        chosen = searched_again(step.chosen, blocks, self._model, self.residual, self._warmed)
        step = self._all[k] = replace(step, chosen=chosen)
        self.put(self._plainer(step, blocks), step)
        self.taken |= {h.key for h, _ in self._all[k].chosen.parts}

    def _search_delay(self, k, places):
        """Search the delay of the Step at k where it fits best with what is at other places."""
        delay = self._all[k].chosen
        blocks = self._blocks_of(step for i, step in enumerate(self._all)
                                 if i not in places and step.chosen.name != UNKNOWN)
        beside = [h for i in places if i != k for h, _ in self._all[i].chosen.parts]
        moved = with_hypotheses(delay, [delay_among(h, beside, blocks, self._model, self.residual)
                                        for h in hypotheses_of(delay)])
        self.put(replace(self._all[k], chosen=moved), self._all[k])
        step = self._all[k]
        self._all[k] = replace(step, chosen=evaluated(moved, self.beside(step)))

    def _plainer(self, step, blocks):
        """Return a Step of what its Candidate looks like beside what was found since: Blocks."""
        chosen = step.chosen
        others = [(evaluated(_delayed(c, self.residual), blocks), c) for c in _rivals(step)
                  if c.joints == chosen.joints and not self.taken & {h.key for h, _ in c.parts}]
        plainer, rival = max((pair for pair in others if looks_like(chosen, pair[0])
                              and self._possible(pair[0])),
                             key=lambda pair: pair[0].gain, default=(None, None))
        if plainer is None:
            return step
        rest = tuple(c for c in step.alternatives if c is not rival)
        return replace(step, chosen=plainer, alternatives=(chosen, *rest))

    def _others(self, *steps):
        # A plain function would take the place of any effect of its variable.
        return [other for other in self._all if other.chosen.name != UNKNOWN
                and not any(other is step for step in steps)]

    def _place(self, step):
        return next(k for k, own in enumerate(self._all) if own is step)

    def _tell_delays(self, new=()):
        """Take the delays of all steps and of new ones: all that was found is as late."""
        self.residual = self._with_delays([*self._all, *new])
        self._all = [_step_delayed(step, self.residual) for step in self._all]

    def _with_delays(self, steps):
        """Return the Residual with the delays of some steps."""
        residual = replace(self.residual, delays=self.residual.declared)
        for step in steps:
            for hypothesis, _ in step.chosen.parts if step.chosen.name == LATE else ():
                residual = delayed(residual, hypothesis)
        return residual

    def _blocks_of(self, steps, residual=None):
        """Return Blocks with the effects of some steps for nuisances."""
        blocks = (residual or self.residual).blocks(self._root)
        for step in steps:
            for hypothesis, _ in step.chosen.parts:
                blocks.add(hypothesis.columns)
        return blocks


def _rivals(step):
    """Return the Candidates of a Step beside its own, each once."""
    own = {h.key for h, _ in step.chosen.parts}
    rivals = {tuple(h.key for h, _ in c.parts): c for c in (step.next_best, *step.alternatives)
              if c is not None and {h.key for h, _ in c.parts} != own}
    return list(rivals.values())


def _delayed(candidate, residual):
    """Return a Candidate with the columns that it has beside the delays of a Residual."""
    return with_hypotheses(candidate, [beside_delays(h, residual)
                                       for h in hypotheses_of(candidate)])


def _step_delayed(step, residual):
    return replace(step, chosen=_delayed(step.chosen, residual))
