"""A result page as blocks, told as Markdown and as one self-contained HTML page."""

from dataclasses import dataclass
from html import escape
from pathlib import Path
import re

from ..report.page_parts import html_image, html_table, STYLE
from ..report.svg import svg_of, write_png

_WIDTH = 7.0  # [inch] of pictures
# Tables here are wide: a page as wide as the window, pictures as wide as they are drawn.
_WIDER = 'body { max-width: 72rem } figure img { max-width: 44rem }'


@dataclass(frozen=True)
class Heading:
    """A heading of a level, 1 for the page's."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Text:
    """A paragraph, or lines that each begin a list's item with `- `; Markdown's inline marks."""

    text: str


@dataclass(frozen=True)
class Table:
    """A table: head and rows of text cells."""

    head: tuple
    rows: tuple


@dataclass(frozen=True)
class Picture:
    """A picture: file name without ending, draw(figure), what it shows, height [inch]."""

    name: str
    draw: object
    shows: str
    height: float = 5.0


def _row(cells):
    return '| ' + ' | '.join(cells) + ' |'


def markdown_table(head, rows):
    """Return head and rows of text cells as a Markdown table."""
    return '\n'.join([_row(head), _row(['---'] * len(head)), *map(_row, rows)])


def _markdown(block):
    if isinstance(block, Heading):
        return f'{"#" * block.level} {block.text}'
    if isinstance(block, Table):
        return markdown_table(block.head, block.rows)
    if isinstance(block, Picture):
        return f'![{block.shows}]({block.name}.png)'
    return block.text


def _inline(text):
    """Return text as HTML with its code, strong parts and links."""
    text = re.sub(r'`([^`]+)`', _code, escape(text))
    text = re.sub(r'\[([^]]+)\]\(([^()\s]+)\)', _link, text)
    return re.sub(r'\*\*([^*]+)\*\*', r'<strong>\1</strong>', text)


def _code(found):
    # What stands in code is neither strong nor a link.
    return f'<code>{found[1].replace("*", "&#42;").replace("[", "&#91;")}</code>'


def _link(found):
    """Return an HTML link of escaped text; another address than a page or file stays text."""
    text, address = found.groups()
    if re.match(r'[\w+.-]+:', address) and not re.match(r'https?://', address):
        return found.group(0)
    # A page's HTML twin lies beside its README.md.
    return f'<a href="{re.sub("README[.]md$", "index.html", address)}">{text}</a>'


def _html(block):
    if isinstance(block, Heading):
        return f'<h{block.level}>{_inline(block.text)}</h{block.level}>'
    if isinstance(block, Table):
        return html_table(list(map(_inline, block.head)),
                          [list(map(_inline, row)) for row in block.rows])
    if isinstance(block, Picture):
        return html_image(svg_of(block.height, block.draw, _WIDTH), block.shows)
    lines = block.text.split('\n')
    if all(line.startswith('- ') for line in lines):
        return '<ul>' + ''.join(f'<li>{_inline(line[2:])}</li>' for line in lines) + '</ul>'
    return f'<p>{_inline(block.text)}</p>'


def blocks_of(markdown):
    """Return the blocks of a page of headings, tables and paragraphs; to_markdown's inverse."""
    return [_block(part) for part in markdown.strip('\n').split('\n\n')]


def _block(text):
    if heading := re.match(r'(#+) (.*)', text):
        return Heading(heading[2], len(heading[1]))
    if text.startswith('| '):
        head, _, *rows = [tuple(line.removeprefix('| ').removesuffix(' |').split(' | '))
                          for line in text.split('\n')]
        return Table(head, tuple(rows))
    return Text(text)


def to_markdown(blocks):
    """Return blocks as Markdown; pictures are files beside it."""
    return '\n\n'.join(map(_markdown, blocks)) + '\n'


def to_html(blocks):
    """Return blocks as one self-contained HTML page."""
    title = next((b.text for b in blocks if isinstance(b, Heading)), 'Benchmark')
    return ('<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f'<title>{escape(title)}</title><style>{STYLE}{_WIDER}</style></head><body>'
            + ''.join(map(_html, blocks)) + '</body></html>\n')


def write_pages(folder, blocks):
    """Write README.md with its pictures and index.html; return the Markdown."""
    folder = Path(folder)
    for block in blocks:
        if isinstance(block, Picture):
            write_png(folder / f'{block.name}.png', block.height, block.draw, _WIDTH)
    text = to_markdown(blocks)
    (folder / 'README.md').write_text(text, encoding='utf-8')
    (folder / 'index.html').write_text(to_html(blocks), encoding='utf-8')
    return text
