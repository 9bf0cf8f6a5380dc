"""Effects of one joint that ask for the same torque, whatever the arm does in its mounting."""

import numpy as np

from ...effects import EFFECTS

# Of a link's ten products some turn it about the axis of its own joint only: these are no others.
OF_A_LINK = ('rotor_inertia', 'gravity_spring')
_SAME = 1e-6  # [-] of an effect's torque that its link's may leave
_POSES, _ROWS = 12, 200


def is_its_link(name, joint, robot, x):
    """
    Tell whether an effect of OF_A_LINK can do nothing but what the link of its joint can, too.

    x: the EffectInput of a motion that shows it. The second link of an upright arm is such a case:
    where its weight sits across its axis is a spring of one period per turn to every joint, and
    its inertia about that axis a rotor's.
    """
    some = slice(None, None, max(1, len(x.q) // _ROWS))
    own = EFFECTS[name].columns(x, joint, {})[some]
    count, n = len(own), robot.n
    columns = np.zeros((count, n, own.shape[1]))
    columns[:, joint] = own
    # As they are: what the motion filter makes of a link it makes of its equal, too.
    links = np.array([robot.link_regressor(*row)[:, 10 * joint:10 * joint + 10]
                      for row in zip(x.q[some], x.v[some], x.a[some])]).reshape(count * n, 10)
    size = np.linalg.norm(links, axis=0)
    links, columns = links / np.where(size > 0.0, size, 1.0), columns.reshape(count * n, -1)
    left = columns - links @ np.linalg.lstsq(links, columns, rcond=1e-10)[0]
    return bool(np.linalg.norm(left) < _SAME * np.linalg.norm(columns))


def weight_is_its_own(robot, joint):
    """
    Tell whether gravity's torque on a joint does not change with the joints before it.

    So it is of the first and the second joint of an upright arm.
    """
    rng, zero = np.random.default_rng(0), np.zeros(robot.n)
    rows = []
    for _ in range(_POSES):
        poses = np.tile(rng.uniform(-2.0, 2.0, robot.n), (3, 1))
        poses[:, :joint] = rng.uniform(-2.0, 2.0, (3, joint))
        rows.append([robot.rigid_torque(q, zero, zero)[joint] for q in poses])
    rows = np.array(rows)
    return bool(np.ptp(rows, axis=1).max() <= _SAME * max(np.abs(rows).max(), _SAME))
