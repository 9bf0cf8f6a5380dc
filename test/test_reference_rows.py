"""Every row of reference 1 that estimating has to serve is named by a test: test_e2_3_... ."""

import ast
from pathlib import Path
import re

import pytest

HERE = Path(__file__).parent
ROWS = ('E1.1', 'E1.2', 'E1.3', 'E1.4', 'E1.5', 'E1.6', 'E1.7',
        'E2.1', 'E2.2', 'E2.3', 'E2.4', 'E2.5', 'E2.6', 'E2.7', 'E3.1', 'E4.1', 'E5.1', 'E5.2',
        'E6.1', 'E6.2', 'E6.3', 'E6.4', 'E7.1', 'E7.2', 'E7.3', 'E10.1')


def rows_of(source):
    """Return the row ids in the names and docstrings of the tests of a source text."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef) and node.name.startswith('test_'):
            text = f'{node.name} {ast.get_docstring(node) or ""}'
            found |= {f'E{row}.{part}' for row, part
                      in re.findall(r'(?<![a-z0-9])e(\d+)[._](\d+)(?!\d)', text.lower()
                                    .replace('test_', ' ').replace('_e', ' e'))}
    return found


NAMED = set().union(*(rows_of(path.read_text('utf-8')) for path in HERE.glob('test_*.py')
                      if path != Path(__file__)))


@pytest.mark.parametrize('row', ROWS)
def test_a_test_names_the_row(row):
    assert row in NAMED


def test_the_page_of_rows_names_every_row_and_tests_that_exist():
    page = (HERE.parent / 'doc' / 'reference_rows.md').read_text('utf-8')
    lines = [line.split('|') for line in page.splitlines() if line.startswith('| E')]
    assert tuple(re.findall(r'E\d+\.\d', ' '.join(line[1] for line in lines))) == ROWS
    for line in lines:
        named = re.findall(r'`(test_\w+)(\.py)?`', line[3])
        assert named and named[0][1], 'a file stands ahead of its tests'
        for name, is_file in named:
            if is_file:
                source = (HERE / f'{name}.py').read_text('utf-8')
            else:
                assert f'def {name}(' in source, name


def test_the_reader_sees_names_and_docstrings_of_tests_only():
    assert rows_of('def test_E1_3_x():\n    """As E10.1 says."""') == {'E1.3', 'E10.1'}
    assert rows_of('def test_e5_1_e5_2_x():\n    pass') == {'E5.1', 'E5.2'}
    assert rows_of('# E2.1\ndef help_e2_2():\n    """E2.3"""\n\ndef test_me2_4():\n    "E2.56"'
                   ) == {'E2.56'}
