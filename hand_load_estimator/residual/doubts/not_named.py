"""What structure without a name follows: variables and joints that foretell it beyond chance."""

import numpy as np

from ..measured.structure import LEAST

# Less than this share of the structure is not worth a mark on a map, and less than that share of
# all that is left not worth a sentence.
SMALLEST, WEIGHTY = 0.01, 0.05
MOTION_OF = 'the motion of '
# At most so many variables are named for a joint; the maps show all.
MOST = 3


def real(share, chance):
    """Tell which shares are no chance and worth a word."""
    return (share > chance) & (share >= SMALLEST)


def follows(structure, joints, j):
    """
    Return ((what, share), ...) that foretells joint j's residual, the largest first.

    joints: names; what: a variable, or `the motion of` another joint.
    """
    found = [(name, structure.share[name][j]) for name in structure.share
             if real(structure.share[name][j], structure.chance[name][j])]
    found += [(f'{MOTION_OF}{other}', structure.pairs[j, i]) for i, other in enumerate(joints)
              if i != j and real(structure.pairs[j, i], structure.pairs_chance[j, i])]
    return tuple((name, min(float(share), 1.0)) for name, share in
                 sorted(found, key=lambda pair: -pair[1])[:MOST])


def not_named(structure, joints):
    """
    Return for each joint what its residual follows that no effect explains, as of follows.

    structure: (Structure before, Structure after), as of structures; shares count of the structure
    that is left.
    """
    before, after = structure
    was, left = (np.maximum(side.structured, LEAST) for side in structure)
    # Those of a Structure count of what there was before.
    grown = was / left * (before.rms / after.rms) ** 2
    found = [[(what, min(share * grown[j], 1.0)) for what, share in follows(after, joints, j)]
             for j in range(len(joints))]
    return tuple(tuple(pair for pair in pairs if pair[1] * part >= WEIGHTY)
                 for pairs, part in zip(found, left))


def sentences_on(structure, joints):
    """Return a sentence for each joint with structure that is not named."""
    return tuple(f'{name}: structure not named: follows {_listed(found)}' for name, found in
                 zip(joints, not_named(structure, joints)) if found)


def _listed(found):
    return ', '.join(f'{name} ({100.0 * share:.0f} %)' for name, share in found)
