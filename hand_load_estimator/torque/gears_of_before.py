"""Models from before gears carried what pulls on the links: their figures mean something else."""

# [ISO 8601] The first model files that count springs, cables and a leaning base into gears, and
# all that a drive gives into its gain.
COUNTED = '2026-11-29T15:00'


def told_of_gears_of_before(model):
    """Return a sentence where a TorqueModel's gears or gains were found without these, else ''."""
    layout = model.layout
    pulled = layout.pulls or any(use.name == 'base_tilt' for use in model.uses)
    bound = layout.needs & {'gear', 'play', 'drive'}
    if not (pulled and bound) or (model.diagnosed or '') >= COUNTED:
        return ''
    return ('the model file is from before gears carried balancers, cables and the lean of a '
            'base: its gear friction, play or gain were found beside other torques; identify '
            'again')
