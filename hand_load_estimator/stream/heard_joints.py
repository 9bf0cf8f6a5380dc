"""Which joints joint states name, where none of them is usable: what is heard, what is wanted."""

# Names of others that are told; a driver that invents names must not fill the memory.
_MOST_NAMES = 10


class HeardJoints:
    """What the joint states named so far; joints: the names wanted."""

    def __init__(self, joints):
        self._joints, self._names = joints, {}
        self._heard = self._some = self._all = False

    def note(self, names, places):
        """Note the names of a message; places: what arm_names.places says of them."""
        self._heard = True
        if places is not None and not isinstance(places, str):
            self._all = True
            return
        # Joints of two arms are all there, too: what is wrong is told as a rejection.
        self._all |= places == 'ambiguous_joint'
        self._some |= places == 'missing_joint'
        for name in names:
            if len(self._names) <= _MOST_NAMES:
                self._names[name] = None

    def why_none(self, rejected):
        """Return in words why no joint state was usable; rejected: reason -> count."""
        if not self._heard:
            return 'no joint states yet'
        if self._all:
            counts = ', '.join(f'{n} {kind.replace("_", " ")}' for kind, n in rejected.items())
            return f'joint states arrive, but none is usable; rejected: {counts}'
        wanted, names = ', '.join(self._joints), list(self._names)
        if not names:
            return f'joint states name no joint; wanted: {wanted}'
        more = ' and others' if len(names) > _MOST_NAMES else ''
        return (f'joint states name {", ".join(names[:_MOST_NAMES])}{more}, but '
                f'{"never all" if self._some else "none"} of {wanted}')
