"""
Trace the residual: forward selection of effects on held-out data, with a backward check.

Each round tries every effect on every joint, and beside them plain functions of one variable. An
effect is taken when it gains likelihood on blocks it was not fitted to, more than chance and the
number of trials allow, and moves torque that matters. A plain function that explains much more
than any effect is taken as `unknown`.
"""

from dataclasses import replace

import numpy as np

from ...effects import LATE
from ..diagnosis import UNKNOWN
from ..doubts.limits import true_delay
from .candidate import ahead, in_common, joined, significant, single
from .choice import chosen_step
from .finer_shape import best_of_each, search_around
from .found import Found
from .hypotheses import hypotheses, ONE_CAUSE
from .hypothesis import physical
from .leaning_base import all_links, turned
from .plain_functions import TORQUES
from .saturating import GAIN, gain_beside, saturating
from .soft_end import may_be_soft_end, own_gains, soft_ends
from .superseded import take_back
from .together import Together

ROUNDS = 10
# Nats to be gained beyond the logarithm of the number of trials, and the effect's torque in units
# of the model's noise.
LEAST_GAIN, LEAST_RMS = 25.0, 0.5
# What one joint must gain to count as showing a cause of the whole arm.
PART_GAIN = 8.0
# What has no name must gain so many times more, and move as much torque as the noise.
UNKNOWN_FACTOR, UNKNOWN_RMS = 4.0, 1.0
# A declared effect has changed when its torque is so many times what the model expects.
UNEXPECTED = 3.0
# An effect that explains less than this share of what a plain function of its variable does is
# not the explanation.
ADEQUATE = 0.6
# What has no name and gains less than this share of what named effects gained at its joint is the
# rest that their formulas leave, and speaks against none of them.
REST = 0.1


class Trace:
    """
    Forward selection on a Residual of a TorqueModel.

    root: what Residual.blocks takes, for recordings that the model itself was made from;
    steps: what was found; drifted: changes of declared effects no larger than the model says to
    expect; trials: hypotheses tried in the first round; nearly: Candidates of the last round that
    gained surely, but less than `needed` [nats]; unfinished: whether the last of ROUNDS found
    something still; maybe_soft_ends: steps that an effort which ends softly may have made.
    """

    def __init__(self, model, residual, warmed, root=None,
                 progress=lambda text: None):
        self._model, self._warmed, self._progress = model, warmed, progress
        self._found = Found(model, residual, warmed, root, self._possible)
        self.blocks, self.trials = residual.blocks(root), 0
        self.nearly, self.needed, self.unfinished = [], 0.0, False
        self.maybe_soft_ends = ()
        std = np.sqrt(np.diag(model.covariance))
        self._declared = {(use.name, use.joint): (model.mean[where], std[where])
                          for use, where in model.slices()}
        self._scores = {}

    @property
    def steps(self):
        """Steps found."""
        return self._found.steps

    @property
    def drifted(self):
        """Steps of changes that the model says to expect."""
        return self._found.drifted

    @property
    def residual(self):
        """The Residual with the delays found."""
        return self._found.residual

    @property
    def _taken(self):
        return self._found.taken

    def run(self):
        """Select effects until none is worth it; return the steps."""
        for turn in range(ROUNDS):
            self._progress(f'tracing, round {turn + 1}: {len(self._scores) or "all"} hypotheses')
            steps = list(self._round())
            if not steps:
                break
            steps = self._found.with_finer_shapes(steps)
            for step in steps:
                self._found.add(replace(step, expected=self._expected(step.chosen)))
            changed = self._found.settle()
            changed |= take_back(self._found, self._model, self._warmed, self._possible)
            self.blocks = self._found.blocks()
            self._forget(changed.union(*(step.chosen.touched for step in steps)))
        else:
            self.unfinished = True
        return self.steps

    def keep_what_still_gains(self):
        """
        Backward check: drop steps, and joints of them, that gain no more beside the others.

        What is kept has its evidence, and that of what else it may be, beside all the others.
        """
        kept = 0
        while kept < len(self.steps):
            step = self.steps[kept]
            again = self.still_gains(step)
            if again.gain < step.needed or not self._weighs(again):
                self._found.drop(step)
                # What else it delayed is to be asked again.
                kept = 0 if step.chosen.name == LATE else kept
                continue
            shown = self._where_it_shows(step, again)
            if shown is not step:
                self._found.put(shown, step)
                shown = self.steps[kept]
                if self.still_gains(shown).gain < step.needed:
                    self._found.drop(shown)
                    continue
            kept += 1
        odd = saturating(self.steps, self._model.robot.n)
        ends = soft_ends(self._found, odd)
        self._part_gains(odd, ends)
        self._found.weigh_again()
        self.maybe_soft_ends = tuple(step for step in self.steps
                                     if may_be_soft_end(step, ends, self._found))
        # What was dropped must not count as explained.
        self.blocks = self._found.blocks()

    def _part_gains(self, *groups):
        """Make a gain of several joints two steps where some of them are of one of the groups."""
        for group in groups:
            # What is put in the place of one step makes others of all.
            while mixed := [s for s in own_gains(self.steps)
                            if len({j in group for j in s.chosen.joints}) == 2]:
                step = mixed[0]
                parts = [[pair for pair in step.chosen.parts if (pair[0].joint in group) == which]
                         for which in (False, True)]
                own, other = (replace(step, chosen=joined(GAIN, tuple(p))) for p in parts)
                self._found.put(own, step)
                self._found.add(other)

    def still_gains(self, step):
        """Return the Candidate of a step against all other steps as they are without it."""
        return self._found.evidence(step)

    def _where_it_shows(self, step, again):
        """Return the step without joints that were taken along and show it no more."""
        if again.common or len(again.parts) == 1:
            return step
        shows = {h.joint for h, score in again.parts
                 if self._gains(score) and self._weighs(single(h, score))}
        kept = tuple(pair for pair in step.chosen.parts if pair[0].joint in shows)
        if len(kept) in (0, len(step.chosen.parts)):
            return step
        return replace(step, chosen=joined(step.chosen.name, kept))

    def beside(self, *steps):
        """Return Blocks with all other steps for nuisances."""
        return self._found.beside(*steps)

    def without(self, step):
        """Return Blocks with all other steps as they are without a step."""
        return self._found.without(step)

    def unexplained(self):
        """Return the indices of joints where what has no name is more than a rest."""
        found = set()
        for step in self.steps:
            if step.chosen.name == UNKNOWN:
                found |= {j for j in step.chosen.joints
                          if step.chosen.gain >= REST * self._named(j)}
        return tuple(sorted(found | saturating(self.steps, self._model.robot.n)))

    def _has_no_rival(self, candidate):
        """Tell whether a candidate is an `unknown`, and of no torque that a gain should tell."""
        return candidate.name == UNKNOWN and gain_beside(candidate, self.steps) is None

    def _named(self, joint):
        """Return what named effects gained at a joint [nats]."""
        return sum(self._share(step.chosen, joint) for step in self.steps
                   if step.chosen.name != UNKNOWN)

    def declared(self, candidate):
        """Tell whether the model has the effect already, with other figures."""
        return all(h.name == 'link_inertia' or (h.name, h.joint) in self._declared
                   for h, _ in candidate.parts)

    def _expected(self, candidate):
        """Tell whether a change is within what the model says of its own uncertainty."""
        if not self.declared(candidate):
            return False
        rms = np.sqrt(np.mean(candidate.torque(self._model.robot.n) ** 2, axis=0))
        return bool((rms < UNEXPECTED * self.residual.expected).all())

    def matters(self, candidate):
        """Tell whether a candidate's torque is worth a place in a model."""
        torque = candidate.torque(self._model.robot.n)
        times = np.sqrt(np.mean(torque ** 2, axis=0)) / self.residual.noise
        least = UNKNOWN_RMS if self._has_no_rival(candidate) else LEAST_RMS
        # What joints have in common they show together.
        return bool((np.linalg.norm(times) if candidate.common else times.max()) >= least)

    def _round(self):
        self._evaluate()
        # Every shape tried counts as a trial, not only every cause.
        self.needed = needed = LEAST_GAIN + np.log(self.trials)
        ranked = sorted(self._candidates(), key=lambda c: -c.gain)
        self.nearly = [c for c in ranked if 0.0 < c.gain < needed and c.name != UNKNOWN
                       and significant(c) and self.matters(c)]
        for best in ranked:
            if best.gain < needed:
                return ()
            if not significant(best) or not self.matters(best) or (
                    self._has_no_rival(best) and best.gain < UNKNOWN_FACTOR * needed):
                continue
            step = self._step(best, ranked, needed)
            return self._two_instead(step.chosen, needed) or (step,)
        return ()

    def _two_instead(self, chosen, needed):
        """Return the Steps of two effects that explain a joint better than a Candidate, or ()."""
        if len(chosen.joints) != 1 or chosen.common or chosen.name == 'base_tilt':
            return ()
        j, = chosen.joints
        singles = [c for c in self._singles() if c.joints == [j] and c.name != 'base_tilt']
        together = Together(self._model, self.residual, self._warmed, self.blocks, j,
                            self._taken, singles, self._allowed)
        return together.instead_of(chosen, needed, self.matters)

    def _possible(self, candidate):
        """Tell whether physics allows a Candidate as it was fitted, and it matters."""
        return self.matters(candidate) and all(self._allowed(*pair) for pair in candidate.parts)

    def _allowed(self, hypothesis, score):
        if hypothesis.name == LATE and not true_delay(self.residual, score.theta[0] * float(
                hypothesis.scale[0]) * hypothesis.shape['shift']):
            return False
        return physical(hypothesis, score, self._declared.get((hypothesis.name, hypothesis.joint)))

    def _step(self, best, ranked, needed):
        if best.name == 'base_tilt':
            # It moves all joints: what might do the same is all links, not one of them.
            links = all_links(self._model, self.residual)
            ranked = [*ranked, in_common(links, self.blocks.evaluate(links.columns))]
        return chosen_step(best, ranked, needed, self._singles())

    def _singles(self):
        """Return the Candidates of one named effect that is not taken yet, likely or not."""
        return [single(*pair) for key, pair in self._scores.items() if key not in self._taken
                and pair[0].joint is not None and pair[0].name != UNKNOWN]

    def _candidates(self):
        """Return the named candidates that are adequate, and the unknowns nothing explains."""
        # Where an unknown effect is, anything else would only imitate it.
        unknown = {j for name, j, _ in self._taken if name == UNKNOWN}
        scores = [pair for key, pair in self._scores.items()
                  if key not in self._taken and not unknown & set(pair[0].columns)
                  and self._allowed(*pair)]
        singles = [single(*pair) for pair in scores if pair[0].joint is not None]
        unknown = [c for c in singles if c.name == UNKNOWN]
        named = [c for c in singles if c.name != UNKNOWN and c.name not in ONE_CAUSE]
        for name in ONE_CAUSE:
            named += self._of_the_arm([pair for pair in scores if pair[0].name == name], named)
        best = {j: max((c for c in unknown if c.joints == [j]), key=lambda c: c.gain,
                       default=None) for j in range(self._model.robot.n)}
        adequate = [c for c in named if self._adequate(c, best)]
        orphans = [c for j, c in best.items() if c is not None and self._explained(named, c, j)
                   < (ADEQUATE if self._has_no_rival(c) else 1.0) * c.gain]
        return adequate + orphans

    def _explained(self, named, unknown, joint):
        """Return what the best of named candidates gains in an unknown one's place [nats]."""
        # A gain is not sure where a drive saturates, and must not stand in the way of that.
        return max((self._share(c, joint) for c in named if joint in c.touched and (
            unknown.variable not in TORQUES or significant(c))), default=0.0)

    def _of_the_arm(self, pairs, others):
        """
        Return the Candidates of one cause: on joints that show it, and the same on all.

        others: Candidates of other causes, each of one joint. Where one of them surely explains
        its joint better, the cause is none of that joint, however much all joints together gain.
        """
        strong = [pair for pair in pairs if pair[0].joint is not None and self._strong(*pair)]
        own = tuple(pair for pair in strong if not any(
            c.joints == [pair[0].joint] and significant(ahead(c, single(*pair))) for c in others))
        found = [joined(own[0][0].name, own)] if own else []
        if len(own) < len(strong):
            return found
        # Where a joint has it already, the others do not have the same.
        taken = {name for name, _, _ in self._taken}
        return found + [in_common(*pair) for pair in pairs
                        if pair[0].joint is None and pair[0].name not in taken]

    @staticmethod
    def _share(candidate, joint):
        return sum(score.by_joint.get(joint, 0.0) for _, score in candidate.parts)

    def _strong(self, hypothesis, score):
        """Tell whether one joint shows a cause of the whole arm by itself."""
        return self._gains(score) and self.matters(single(hypothesis, score))

    def _gains(self, score):
        return score.gain > PART_GAIN + np.log(self.trials)

    def _weighs(self, candidate):
        """Tell whether what is found already matters: a delay by all that it delays."""
        return candidate.name == LATE or self.matters(candidate)

    def _adequate(self, candidate, best):
        """Tell whether no plain function explains much more where the candidate acts."""
        joint = max(candidate.touched, key=lambda j: self._share(candidate, j))
        function = best[joint]
        return function is None or self._share(candidate, joint) >= ADEQUATE * function.gain

    def _evaluate(self):
        """Evaluate what is not up to date, the best shape of each cause."""
        fresh, tried = best_of_each(hypotheses(self._model, self.residual, self.blocks,
                                               self._warmed, self._scores), self.blocks)
        for key, pair in fresh.items():
            fresh[key], more = self._refined(*pair)
            tried += more
        self._scores |= fresh
        self.trials = max(self.trials, tried)

    def _refined(self, hypothesis, score):
        """Return the pair with its shape searched between the grid's values, number of trials."""
        if score.gain >= LEAST_GAIN and hypothesis.name == 'base_tilt':
            exact = turned(hypothesis, score, self._model, self.residual)
            return max([(hypothesis, score), (exact, self.blocks.evaluate(exact.columns))],
                       key=lambda pair: pair[1].gain), 1
        if score.gain < LEAST_GAIN:
            return (hypothesis, score), 0
        return search_around((hypothesis, score), self.blocks, self._model, self.residual)

    def _forget(self, joints):
        """Drop what was evaluated beside other things at some joints than are there now."""
        self._scores = {key: pair for key, pair in self._scores.items()
                        if not joints & set(pair[0].columns)}
