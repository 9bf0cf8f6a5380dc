"""A page at the width of a phone, a desk and paper: a picture of each, what is wrong with it."""

import base64
from dataclasses import dataclass


@dataclass(frozen=True)
class View:
    """A way to look at a page: width and height [CSS pixel], pixels of each, media, touch."""

    name: str
    width: int
    height: int
    pixels: float = 1.0
    media: str = 'screen'
    mobile: bool = False


# Paper: A4 less margins of 16 mm, at the 96 pixels per inch that browsers print with.
VIEWS = (View('phone', 390, 844, 2.0, mobile=True), View('desk', 1280, 800),
         View('print', 673, 1000, media='print'))
# Text below this size [CSS pixel] is hard to read on a phone.
SMALLEST = 12.0
# What reaches beyond the page and is in no box that scrolls by itself; pictures that do not
# show; what comes from elsewhere; text too small; tables of which a part is out of sight.
_FAULTS = '''(() => {
  const width = document.documentElement.clientWidth, out = [];
  const name = e => e.tagName.toLowerCase() + ' "' +
      (e.innerText || e.alt || '').trim().slice(0, 40).replace(/\\s+/g, ' ') + '"';
  const wide = document.documentElement.scrollWidth;
  if (wide > width) out.push(`the page is ${wide} pixels wide in a window of ${width}`);
  for (const e of document.body.querySelectorAll('*')) {
    const box = e.getBoundingClientRect(), style = getComputedStyle(e);
    const scrolls = e.closest('.scroll') &&
        getComputedStyle(e.closest('.scroll')).overflowX === 'auto';
    if (!scrolls && box.width && (box.right > width + 1 || box.left < -1))
      out.push(`${name(e)} reaches from ${box.left.toFixed()} to ${box.right.toFixed()}`);
    const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
    if (MOBILE && own && parseFloat(style.fontSize) < SMALLEST && !e.closest('sup'))
      out.push(`${name(e)} is written in ${style.fontSize}`);
  }
  for (const e of document.images)
    if (!e.naturalWidth) out.push(`${name(e)}: the picture does not show`);
  for (const e of document.querySelectorAll('[src], link[href]'))
    if (!(e.src || e.href).startsWith('data:')) out.push(`${name(e)} comes from elsewhere`);
  for (const e of document.querySelectorAll('.scroll'))
    if (e.scrollWidth > e.clientWidth + 1)
      out.push(`${name(e)}: ${e.clientWidth} of ${e.scrollWidth} pixels of a table are in sight`);
  return out;
})()'''


def look(browser, url, view, folder):
    """
    Return the faults of a page in a View, a sentence each.

    Writes folder/<view>.png of the whole page, and print.pdf where it is on paper.
    """
    browser.call('Emulation.setDeviceMetricsOverride', width=view.width, height=view.height,
                 deviceScaleFactor=view.pixels, mobile=view.mobile)
    browser.call('Emulation.setEmulatedMedia', media=view.media)
    browser.open(url)
    faults = browser.value(_FAULTS.replace('MOBILE', str(view.mobile).lower())
                           .replace('SMALLEST', str(SMALLEST)))
    picture = browser.call('Page.captureScreenshot', format='png', captureBeyondViewport=True)
    (folder / f'{view.name}.png').write_bytes(base64.b64decode(picture['data']))
    if view.media == 'print':
        pdf = browser.call('Page.printToPDF', printBackground=True, preferCSSPageSize=True,
                           paperWidth=8.27, paperHeight=11.69)
        (folder / f'{view.name}.pdf').write_bytes(base64.b64decode(pdf['data']))
    return faults
