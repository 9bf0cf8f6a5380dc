"""Chromium without a window, driven over its DevTools pipe with the standard library only."""

import json
import os
import select
import shutil
import subprocess
import tempfile
import time

NAMES = ('chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable')
# No answer takes longer [s] unless the browser hangs.
LONGEST = 60.0


class BrowserError(Exception):
    """No browser, or one that does not do as told; says why in one sentence."""


def find_browser():
    """Return the path of a Chromium; HAND_LOAD_BROWSER names one. Raises BrowserError."""
    named = os.environ.get('HAND_LOAD_BROWSER')
    found = [path for name in ((named,) if named else NAMES) if (path := shutil.which(name))]
    if not found:
        raise BrowserError(f'{named or "chromium"} was not found; on Debian: apt install chromium')
    return found[0]


class Browser:
    """One page in a Chromium that ends with the `with` block."""

    def __init__(self, path):
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        ours, its_out = os.pipe()
        its_in, to_it = os.pipe()
        # Chromium reads commands from descriptor 3 and answers on 4; a shell puts them there.
        self._process = subprocess.Popen(
            ['sh', '-c', f'exec "$0" "$@" 3<&{its_in} 4>&{its_out}', path, '--headless=new',
             '--remote-debugging-pipe', '--no-sandbox', '--disable-gpu', '--hide-scrollbars',
             '--no-first-run', f'--user-data-dir={self._profile.name}'],
            pass_fds=(its_in, its_out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(its_in)
        os.close(its_out)
        self._ours, self._to_it, self._rest, self._number = ours, to_it, b'', 0
        self._session = None

    def __enter__(self):
        """Attach to a page."""
        try:
            page = self.call('Target.createTarget', url='about:blank')['targetId']
            self._session = self.call('Target.attachToTarget', targetId=page,
                                      flatten=True)['sessionId']
            self.call('Page.enable')
        except BrowserError:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        """End the browser."""
        self._process.terminate()
        self._process.wait(LONGEST)
        os.close(self._ours)
        os.close(self._to_it)
        self._profile.cleanup()

    def call(self, method, **parameters):
        """Return the result of a DevTools method; raises BrowserError."""
        self._number += 1
        message = {'id': self._number, 'method': method, 'params': parameters}
        if self._session:
            message['sessionId'] = self._session
        try:
            os.write(self._to_it, json.dumps(message).encode() + b'\0')
        except BrokenPipeError:
            raise BrowserError('the browser ended by itself') from None
        while (answer := self._next()).get('id') != self._number:
            pass
        if 'error' in answer:
            raise BrowserError(f'{method}: {answer["error"]["message"]}')
        return answer['result']

    def _next(self):
        end = time.monotonic() + LONGEST
        while b'\0' not in self._rest:
            ready, _, _ = select.select([self._ours], [], [], max(end - time.monotonic(), 0.0))
            part = os.read(self._ours, 1 << 20) if ready else b''
            if not part:
                raise BrowserError('the browser does not answer')
            self._rest += part
        text, _, self._rest = self._rest.partition(b'\0')
        return json.loads(text)

    def open(self, url):
        """Open a page and wait until all of it is there."""
        failed = self.call('Page.navigate', url=url).get('errorText')
        end = time.monotonic() + LONGEST
        while not failed and self.value('document.readyState') != 'complete':
            failed = time.monotonic() > end and 'it does not become complete'
            time.sleep(0.05)
        if failed:
            raise BrowserError(f'{url}: {failed}')

    def value(self, script):
        """Return the JSON value of a JavaScript expression in the page."""
        answer = self.call('Runtime.evaluate', expression=script, returnByValue=True,
                           awaitPromise=True)
        if 'exceptionDetails' in answer:
            raise BrowserError(answer['exceptionDetails']['text'])
        return answer['result'].get('value')
