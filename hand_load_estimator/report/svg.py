"""Figures as SVG text or PNG files, the same in every run."""

import io

# Drawn about as wide as a phone's screen, so that the text keeps its size there.
_WIDTH = 3.9  # [inch]
# A salt and no date: the same diagnosis gives the same picture.
_STYLE = {'font.size': 11.0, 'axes.spines.top': False, 'axes.spines.right': False,
          'svg.hashsalt': 'hand_load'}


def _drawn(draw, height, width):
    # Here, so that commands that draw nothing do not wait for it.
    from matplotlib.figure import Figure
    figure = Figure(figsize=(width, height), layout='constrained')
    draw(figure)
    return figure


def svg_of(height, draw, width=_WIDTH):
    """Return as SVG text a figure of some height, width [inch], filled by draw(figure)."""
    import matplotlib
    text = io.StringIO()
    with matplotlib.rc_context(_STYLE):
        _drawn(draw, height, width).savefig(text, format='svg', metadata={'Date': None})
    return text.getvalue()


def write_png(path, height, draw, width=_WIDTH):
    """Write the same figure as a PNG file."""
    import matplotlib
    with matplotlib.rc_context(_STYLE):
        _drawn(draw, height, width).savefig(path, dpi=130)
