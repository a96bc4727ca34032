"""The page in a real browser: Chromium of this machine, without a screen."""

import os
import shutil
import time
from urllib.parse import urlsplit

import pytest

PATIENCE_MS = 60_000
#: CHROMIUM_BIN names another.
NAMES = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"]
# In a container there is no sandbox to be had, and the processor may draw WebGL. Without a GPU Chromium puts its pages
# together by the processor; `--use-angle=swiftshader` would pretend a GPU, and cost up to eight times as much a frame.
OPTIONS = ["--no-sandbox", "--disable-dev-shm-usage", "--enable-unsafe-swiftshader"]


@pytest.fixture(scope="module")
def browser():
    path = os.environ.get("CHROMIUM_BIN") or next(filter(None, map(shutil.which, NAMES)), None)
    if not path:
        pytest.skip("no browser: install chromium, or set CHROMIUM_BIN")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=OPTIONS)
        yield browser
        browser.close()


@pytest.fixture
def open_page(browser):
    """Opens an address; that the page has no error, and asks nobody but the program, is part of the test."""
    contexts, faults = [], []

    def open_page(address, width=1400, height=900, **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        own = urlsplit(address).netloc
        page.on("pageerror", lambda error: faults.append(f"error: {error}"))
        page.on(
            "request", lambda request: urlsplit(request.url).netloc in ("", own) or faults.append(f"asks {request.url}")
        )
        page.goto(address)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert not faults, faults


def address_in(text):
    """The address that the program has printed."""
    return next(line.split("live view: ")[1].strip() for line in text.splitlines() if "live view: " in line)


def until(page, expression):
    """Waits until something holds on a page. The page forbids what Playwright's own wait_for_function would do:
    eval."""
    deadline = time.monotonic() + PATIENCE_MS / 1000
    while not page.evaluate(expression):
        assert time.monotonic() < deadline, f"never: {expression}"
        page.wait_for_timeout(50) if hasattr(page, "wait_for_timeout") else time.sleep(0.05)
