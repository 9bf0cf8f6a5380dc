"""Look at a report in a browser: python -m report_check OUT [REPORT.html]."""

from pathlib import Path
import subprocess
import sys

from .browser import Browser, BrowserError, find_browser
from .look import look, VIEWS
from .made_report import made_report


def main(out, report=None):
    """Write pictures to a folder; 0, or 1 where the page has faults, or 2 without a browser."""
    out = Path(out)
    try:
        browser_path = find_browser()
        if report is not None and not Path(report).is_file():
            raise BrowserError(f'{report} is not there; give a report.html')
        out.mkdir(parents=True, exist_ok=True)
        page = Path(report) if report is not None else made_report(out)
        with Browser(browser_path) as browser:
            faults = sum(_told(view, browser, page, out) for view in VIEWS)
    except (BrowserError, subprocess.CalledProcessError) as error:
        print(f'error: {error}', file=sys.stderr)
        return 2
    print(f'{faults} faults; look at {out}/*.png')
    return int(faults > 0)


def _told(view, browser, page, out):
    """Look once, say what is seen; return the number of faults."""
    faults = look(browser, page.resolve().as_uri(), view, out)
    print(f'{view.name}, {view.width} pixels: {len(faults)} faults')
    for fault in faults:
        print(f'  {fault}')
    return len(faults)


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
