"""The section of a diagnosis page on where the residual lives, before and after."""

from ..residual.doubts.not_named import follows
from .page_parts import html_image, html_table
from .structure_figures import pairs_svg, variables_svg
from .words import items_html, label_html, list_text, number_text, share_text


def _follows(side, joints, j):
    """Return the variables and other joints that foretell joint j's residual, in words."""
    return list_text(f'{label_html(name)} ({share_text(share)})'
                     for name, share in follows(side, joints, j))


def _rows(joints, before, after):
    for j, name in enumerate(joints):
        sides = [before] if after is before else [before, after]
        yield [label_html(name), *(number_text(side.rms[j]) for side in (before, after)),
               number_text(before.noise[j]),
               ' → '.join(share_text(side.structured[j]) for side in sides)]


def _lives(joints, before, after):
    """Yield in words what each joint's residual follows, before and after."""
    quiet = []
    for j, name in enumerate(joints):
        then, now = (_follows(side, joints, j) for side in (before, after))
        if not then and not now:
            quiet.append(label_html(name))
            continue
        changed = '' if after is before else f'; after: {now or "nothing beyond chance"}'
        yield f'{label_html(name)}: {then or "nothing beyond chance"}{changed}.'
    if quiet:
        yield f'{list_text(quiet)}: nothing beyond chance.'


def structure_section(diagnosis):
    """Return the HTML of a Diagnosis with its Structures, nothing where it has none."""
    if diagnosis.structure is None:
        return ''
    joints, (before, after) = diagnosis.joints, diagnosis.structure
    cells = before.pairs.size + sum(map(len, before.share.values()))
    return (
        '<section><h2>Where the residual lives</h2>'
        '<p>On the recordings that were diagnosed: what may be noise, what is none, and what '
        'foretells that.</p>'
        + html_table(['joint', 'before<br>[Nm]', 'after<br>[Nm]', 'noise<br>[Nm]',
                      'structure'], _rows(joints, before, after))
        + '<h3>What it follows</h3>' + items_html(_lives(joints, before, after))
        + '<div class="pictures">'
        + html_image(variables_svg(joints, before, after), 'Map of joints and variables: percent '
                     'of each joint\'s structure that a function of the variable foretells')
        + html_image(pairs_svg(joints, before, after), 'Map of joint pairs: percent of the '
                     'structure of the joint of the row that the motion of the joint of the '
                     'column foretells')
        + '</div><p class="quiet">Structure: share of the residual\'s variance that is no white '
        'noise; noise that was smoothed before it was recorded counts in there. '
        'A cell: percent of the structure there was before that a function of this one variable '
        'foretells, on blocks of data it was not fitted to. Below: what the motion of the joint '
        'of the column adds to that of the joint of the row, and on the diagonal the joint\'s '
        f'own motion. A dot is no more than chance may give (of the {cells} cells one in a '
        'hundred exceeds it without cause), a question mark cannot be told from these '
        'recordings. Position, velocity, direction, acceleration and gear torque count beyond a '
        'constant; temperature and time as a change of offset and friction. Variables share '
        'what they have in common, so that a row may add up to more than 100.</p></section>')
