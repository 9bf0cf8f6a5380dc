"""What every page of the package is made of: its style, tables and pictures in the page."""

import base64
from html import escape

STYLE = '''
:root { color-scheme: light }
body { font: 1.0625rem/1.5 system-ui, sans-serif; max-width: 44rem; margin: 0 auto;
       padding: 1rem; color: #1a1a1a; background: #fff; overflow-wrap: break-word }
h1 { font-size: 1.55rem; line-height: 1.25; margin: .2em 0 .5em }
h2 { font-size: 1.3rem; line-height: 1.3; margin: 1.8em 0 .4em; padding-top: .5em;
     border-top: 1px solid #bbb }
h3 { font-size: 1.0625rem; margin: 1.2em 0 .2em }
h1, h2, h3 { break-after: avoid }
.scroll { overflow-x: auto }
table { border-collapse: collapse; font-size: 1rem; line-height: 1.3;
        font-variant-numeric: tabular-nums }
th, td { padding: .35em .5em; border-bottom: 1px solid #ddd; text-align: right;
         overflow-wrap: normal; vertical-align: bottom }
th { font-weight: 600 }
th:first-child, td:first-child { text-align: left; padding-left: 0 }
tr, figure, .note { break-inside: avoid }
figure { margin: 1em 0 }
figure img { display: block; width: 100%; max-width: 28rem; height: auto }
.pictures { display: grid; gap: 0 1.5rem;
            grid-template-columns: repeat(auto-fit, minmax(min(100%, 19rem), 1fr)) }
.badge { display: inline-block; font-size: 1rem; font-weight: 600; line-height: 1.4;
         padding: 0 .5em; border: 2px solid; border-radius: .3em; white-space: nowrap }
.confirmed { color: #17652f } .suspected { color: #8a5300 } .changed { color: #1f4f8a }
.note { border-left: 4px solid #8a5300; padding: .1em 0 .1em .8em; margin: 1em 0 }
ul { padding-left: 1.2em } li { margin: .3em 0 }
.quiet { color: #555; font-size: 1rem }
a { color: #1f4f8a }
@media (max-width: 30rem) { table { font-size: .95rem } th, td { padding: .35em .28em } }
@media print {
  @page { margin: 16mm }
  body { font-size: 10.5pt; max-width: none; padding: 0 }
  table, .badge, .quiet { font-size: 10pt }
  a { color: inherit; text-decoration: none }
  .scroll { overflow: visible }
  figure img { max-width: 100mm }
}
'''


def html_table(head, rows):
    """Return an HTML table that scrolls on its own; head and rows are HTML cells."""
    top = ''.join(f'<th scope="col">{cell}</th>' for cell in head)
    body = ''.join('<tr>' + ''.join(f'<td>{cell}</td>' for cell in row) + '</tr>'
                   for row in rows)
    return (f'<div class="scroll"><table><thead><tr>{top}</tr></thead>'
            f'<tbody>{body}</tbody></table></div>')


def html_image(svg, text):
    """Return a figure with its SVG inside; as an image, so that ids of figures never meet."""
    data = base64.b64encode(svg.encode()).decode()
    return (f'<figure><img src="data:image/svg+xml;base64,{data}" '
            f'alt="{escape(text)}"></figure>')
