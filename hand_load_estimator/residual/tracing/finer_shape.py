"""
Give an effect that was chosen the finer shape that a large one tells.

Its form, and the way it turns after a reversal, are no hypotheses of their own: they are asked of
what was found, and each must pay for itself to the end.
"""

from itertools import product

from ...effects import EFFECTS, LATE
from ..measured.blocks import Blocks
from .candidate import ahead, evaluated, hypotheses_of, in_common, joined, significant, single
from .hypotheses import FORMS, of_shapes, other_forms, other_ways, released, reshaped
from .hypothesis import physical, price, searched, turns
from .shape_fit import settled

# Asked of effects that gain so much [nats].
PLENTY = 200.0
# So many parameters at most are tried in all combinations of steps; more only settle together.
COMBINED = 4
# [nats] that are no reason to prefer one shape to another.
SAME = 2.0


def rank(hypothesis, score, more=0.0):
    """Return what the better of two shapes has more of: sense, then nats."""
    # Of a short delay only its product with the share shows: the share is to be a whole.
    return hypothesis.name != LATE or physical(hypothesis, score, None), score.gain + more


def best_of_each(hypotheses, blocks):
    """Return {key: (Hypothesis, Score)} with the best shape of each cause, number of trials."""
    found, tried = {}, 0
    for hypothesis in hypotheses:
        score = blocks.evaluate(hypothesis.columns)
        tried += hypothesis.trials
        known = found.get(hypothesis.key)
        if known is None or rank(hypothesis, score) > rank(*known, price(hypothesis, known[0])):
            found[hypothesis.key] = hypothesis, score
    return found, tried


def search_around(best, blocks, model, residual):
    """
    Search the shape of a (Hypothesis, Score) around what it is.

    Returns the best pair and the number of trials.
    """
    count, there = 0, searched(best[0])
    if not there:
        return best, 0
    size = len(there)
    # The spectrum has told the period of a ripple better than such steps do.
    for step in (1.25, 1.12) if size <= COMBINED and 'periods' not in there else ():
        # Parameters that make up for one another are found together only.
        factors = [those for those in product((1.0 / step, 1.0, step), repeat=size)
                   if set(those) != {1.0}]
        tried = [(trial, blocks.evaluate(trial.columns))
                 for trial in reshaped(best[0], factors, model, residual)]
        best = max([best, *tried], key=lambda pair: rank(*pair))
        count += len(tried)
    best, more = settled(*best, blocks, model, residual, rank)
    if best[0].name == LATE:
        return _whole(best, blocks, model, residual), count + more + 1
    return best, count + more


def _whole(best, blocks, model, residual):
    """Return the pair with the shift at which a delay's share is a whole, if it costs nothing."""
    hypothesis, score = best
    # Of a short delay only its product with the share shows.
    share = float(score.theta[0] * hypothesis.scale[0])
    if share <= 0.0:
        return best
    (whole,) = reshaped(hypothesis, [(share,)], model, residual)
    pair = whole, blocks.evaluate(whole.columns)
    return pair if pair[1].gain > score.gain - SAME else best


def finer(candidate, blocks, model, residual, warmed):
    """
    Return a chosen Candidate with its finer shape, where it is large enough to tell one.

    blocks: Blocks with everything else that was found; warmed: joints whose temperature changed.
    How friction turns shows in reversals, which all other comparisons leave out. Its form and the
    way it turns make up for one another: the one is asked again with the other, and in the end all
    figures are searched together.
    """
    plain, r = candidate.parts[0][0], residual
    forms = [lambda here: other_forms(here, model, r, plain.joint in warmed)] \
        if plain.name in FORMS else []
    asked = [*forms, lambda here: other_ways(here, model, r), *forms] if turns(plain) else forms
    if candidate.gain < PLENTY or not asked:
        return candidate
    own = _telling(candidate, blocks, r)
    best = plain, own.evaluate(plain.columns)
    for others in asked:
        pairs = [best, *((trial, own.evaluate(trial.columns)) for trial in others(best[0]))]
        best = max(pairs, key=lambda pair: rank(*pair, -price(pair[0], plain)))
        best, _ = search_around(best, own, model, r)
    # Figures that make up for one another gain together what none of them does alone.
    for free in released(best[0], model, r, plain.joint in warmed):
        pair, _ = settled(free, own.evaluate(free.columns), own, model, r, rank)
        best = max((best, pair), key=lambda pair: rank(*pair, -price(pair[0], plain)))
    best = _without_what_does_not_pay(best, plain, own, model, r)
    return single(best[0], blocks.evaluate(best[0].columns))


def _telling(candidate, blocks, residual):
    """Return Blocks that tell the shape of an effect: as `blocks`, or with reversals."""
    r = residual
    if candidate.gain < PLENTY or not turns(candidate.parts[0][0]):
        return blocks
    return Blocks(r.residual, r.turning, blocks.nuisances, r.starts, r.folds, r.cut.groups)


def searched_again(candidate, blocks, model, residual, warmed):
    """
    Return a chosen Candidate with its shapes searched again, beside what has been found since.

    blocks, warmed: as of finer. A shape that was found while another effect was still in the
    residual has taken some of it.
    """
    if not any(searched(h) for h, _ in candidate.parts):
        return evaluated(candidate, blocks)
    alone = not candidate.common and len(candidate.parts) == 1
    own = _telling(candidate, blocks, residual) if alone else blocks
    pairs = [search_around((h, own.evaluate(h.columns)), own, model, residual)[0]
             for h in hypotheses_of(candidate)]
    if candidate.common:
        return in_common(*pairs[0])
    if not alone:
        return joined(candidate.name, tuple(pairs))
    plain = _plain(candidate.parts[0][0], model, residual)
    start, _ = search_around((plain, blocks.evaluate(plain.columns)), blocks, model, residual)
    anew = finer(single(*start), blocks, model, residual, warmed).parts[0][0]
    best, _ = max((pairs[0], (anew, own.evaluate(anew.columns))),
                  key=lambda pair: rank(*pair, -price(pair[0], plain)))
    return single(best, blocks.evaluate(best.columns))


def _plain(hypothesis, model, residual):
    """Return the Hypothesis with every shape that has a price at its default."""
    there = {s.name: s.default for s in EFFECTS[hypothesis.name].shapes if s.gain}
    return of_shapes(hypothesis, [hypothesis.shape | there], model, residual)[0]


def _without_what_does_not_pay(best, plain, blocks, model, residual):
    """Return the pair with every figure at its default that does not surely gain its price."""
    for shape in EFFECTS[plain.name].shapes:
        if not shape.gain or best[0].shape[shape.name] == plain.shape[shape.name]:
            continue
        (less,) = of_shapes(best[0], [{**best[0].shape, shape.name: plain.shape[shape.name]}],
                          model, residual)
        # A figure beside it may have taken its place.
        less, _ = settled(less, blocks.evaluate(less.columns), blocks, model, residual, rank)
        if rank(*less, shape.gain) > rank(*best) or not significant(
                ahead(single(*best), single(*less))):
            best = less
    return best
