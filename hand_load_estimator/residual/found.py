"""
What a trace has found so far, each beside all the rest.

A shape that was found while another effect was still in the residual has taken some of it: what is
found at a joint settles with what was found there before. A delay delays all of it.
"""

from dataclasses import replace

import numpy as np

from .candidate import evaluated, hypotheses_of, with_hypotheses
from .choice import looks_like
from .delay_among_others import delay_among, delayed
from .diagnosis import UNKNOWN
from .finer_shape import finer, searched_again
from .hypothesis import beside_delays, LATE


class Found:
    """
    Steps found on a Residual, in their order.

    model, residual, warmed, root: as of Trace; steps: what is new; drifted: changes of declared
    effects no larger than the model says to expect; taken: keys of all Hypotheses of both;
    residual: with the delays that were found.
    """

    def __init__(self, model, residual, warmed, root):
        self._model, self._warmed, self._root = model, warmed, root
        self.residual = residual
        self.steps, self.drifted, self.taken = [], [], set()

    def blocks(self):
        """Return Blocks with everything found for nuisances."""
        return self._blocks_of(self.steps + self.drifted)

    def beside(self, step):
        """Return Blocks with all other steps for nuisances."""
        # A plain function would take the place of any effect of its variable.
        return self._blocks_of(other for other in self.steps + self.drifted
                               if other is not step and other.chosen.name != UNKNOWN)

    def with_finer_shapes(self, steps):
        """Return Steps found together, each with its finer shape beside the others."""
        self._note_delays(steps)
        steps, before = list(steps), self.blocks()
        for k, step in enumerate(steps):
            blocks = before
            for other in steps[:k] + steps[k + 1:]:
                blocks = blocks.beside(other.chosen.columns)
            steps[k] = replace(step, chosen=finer(step.chosen, blocks, self._model,
                                                  self.residual, self._warmed))
        return steps

    def add(self, step, drifted):
        """Add a Step, to those that the model says to expect or to the others."""
        (self.drifted if drifted else self.steps).append(step)
        self.taken |= {h.key for h, _ in step.chosen.parts}

    def settle_beside(self, new):
        """
        Search shapes again, of what was found at the same joints before, then of the new Step.

        Returns the indices of the joints where anything may have changed.
        """
        joints = set(new.chosen.touched)
        earlier = [step for step in self.steps if step is not new and step.chosen.name != UNKNOWN
                   and joints & set(step.chosen.touched)]
        if new.chosen.name == UNKNOWN or not earlier:
            return set()
        together = [*earlier, new]
        late = [step.chosen.name == LATE for step in together]
        # What a delay delays and the delay itself are told from one another by turns.
        for _ in range(2 if any(late) else 1):
            for k in np.argsort(np.logical_not(late), kind='stable'):
                if late[k]:
                    together = self._delay_among(together, k)
                else:
                    together[k] = self._plainer(self._searched_again(together[k]))
        return joints.union(*(step.chosen.touched for step in together))

    def _searched_again(self, step):
        return self._with(step, searched_again(step.chosen, self.beside(step), self._model,
                                               self.residual, self._warmed))

    def _delay_among(self, together, k):
        """Return Steps of the same joints with the one at k, a delay, where all fit best."""
        delay, others = together[k].chosen, together[:k] + together[k + 1:]
        blocks = self._blocks_of(
            step for step in self.steps + self.drifted if step.chosen.name != UNKNOWN
            and not any(step is one for one in together))
        beside = [h for step in others for h, _ in step.chosen.parts]
        moved = with_hypotheses(delay, [delay_among(h, beside, blocks, self._model, self.residual)
                                        for h in hypotheses_of(delay)])
        self._note_delays([replace(together[k], chosen=moved)])
        together = [self._with(step, self._delayed(moved if i == k else step.chosen))
                    for i, step in enumerate(together)]
        together[k] = self._with(together[k], evaluated(moved, self.beside(together[k])))
        return together

    def _plainer(self, step):
        """Return a Step of what its Candidate looks like beside what was found since."""
        chosen, blocks = step.chosen, self.beside(step)
        others = [evaluated(self._delayed(c), blocks) for c in (*step.alternatives, step.next_best)
                  if c is not None and c.joints == chosen.joints
                  and not self.taken & {h.key for h, _ in c.parts}]
        plainer = max((c for c in others if looks_like(chosen, c)), key=lambda c: c.gain,
                      default=None)
        if plainer is None:
            return step
        self.taken |= {h.key for h, _ in plainer.parts}
        rest = tuple(c for c in step.alternatives if c.name != plainer.name)
        return self._with(replace(step, alternatives=(chosen, *rest), next_best=chosen), plainer,
                          step)

    def _with(self, step, chosen, instead_of=None):
        """Put a Step with another Candidate in the place of it, or of another; return it."""
        old, new = step if instead_of is None else instead_of, replace(step, chosen=chosen)
        for found in (self.steps, self.drifted):
            found[:] = [new if s is old else s for s in found]
        return new

    def _delayed(self, candidate):
        """Return a Candidate with the columns that it has beside the delays known now."""
        return with_hypotheses(candidate, [beside_delays(h, self.residual)
                                           for h in hypotheses_of(candidate)])

    def _note_delays(self, steps):
        for step in steps:
            for hypothesis, _ in step.chosen.parts if step.chosen.name == LATE else ():
                self.residual = delayed(self.residual, hypothesis)

    def _blocks_of(self, steps):
        """Return Blocks with the effects of some steps for nuisances."""
        blocks = self.residual.blocks(self._root)
        for step in steps:
            for hypothesis, _ in step.chosen.parts:
                blocks.add(hypothesis.columns)
        return blocks
