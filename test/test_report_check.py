"""The look at a report in a browser: what it says where there is nothing to look with or at."""

from pathlib import Path
import sys

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / 'scripts'))

from report_check import __main__ as command  # noqa: E402
from report_check.browser import Browser, BrowserError  # noqa: E402


def test_without_a_browser_it_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv('HAND_LOAD_BROWSER', 'no_such_browser')
    assert command.main(tmp_path / 'out') == 2
    assert 'no_such_browser was not found' in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def test_a_report_that_is_not_there_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv('HAND_LOAD_BROWSER', 'sh')
    assert command.main(tmp_path / 'out', tmp_path / 'report.html') == 2
    assert 'report.html is not there' in capsys.readouterr().err


def test_a_browser_that_ends_is_no_success():
    with pytest.raises(BrowserError, match='ended by itself|does not answer'):
        with Browser('/bin/false'):
            pass
