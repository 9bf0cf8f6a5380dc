"""Which recordings was a torque model identified from? Told by their content, never by a name."""


def known_names(model, evidence):
    """Return the names of those recordings, Evidence each, that a TorqueModel came from."""
    contents = {mark.content for mark in model.recordings} - {''}
    return tuple(e.name for e in evidence if e.mark.content in contents)


def made_from(model, evidence):
    """
    Tell whether a TorqueModel was identified from these recordings, and from no others.

    From some of its own it is not made again: what only the others told would be forgotten.
    """
    others = {mark.content for mark in model.recordings} - {e.mark.content for e in evidence}
    return len(known_names(model, evidence)) == len(evidence) and not others


def known_by_name_only(model, evidence):
    """
    Return a sentence for each recording whose name is all that a TorqueModel has kept of one.

    It counts as another one: taken for the model's own, an error that the model has on it would
    pass for what the model was made with.
    """
    named = {m.name for m in model.recordings if not m.content}
    known = known_names(model, evidence)
    return [f'cannot tell whether the model was identified from {e.name} because its file keeps '
            'only the name of such a recording (files from before have no content of theirs); it '
            'counts as another recording' for e in evidence
            if e.name in named and e.name not in known]
