"""
The commands of `hand_load`, one module each.

A module has EXAMPLE (shown by --help), add_arguments(parser) and run(args) -> exit status.
"""
