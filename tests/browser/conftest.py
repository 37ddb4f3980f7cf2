"""A real browser, without a window."""

import os
import shutil

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")


# Not of the session: while Playwright runs, no other test could start an event loop.
@pytest.fixture(scope="module")
def chromium():
    """The installed Chromium; skipped without one, unless all must be there."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        if os.environ.get("RESTIR_NO_SKIP"):
            pytest.fail("no Chromium is installed")
        pytest.skip("no Chromium is installed (Debian: apt-get install chromium)")
    from playwright.sync_api import sync_playwright

    # Chromium refuses to sandbox itself for the superuser.
    arguments = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=arguments)
        yield browser
        browser.close()


@pytest.fixture
def visit(chromium):
    """Open a file in a window of some width; what it fetches, and complains of."""
    contexts = []

    def open_file(path, width=1280, scheme="light"):
        context = chromium.new_context(
            viewport={"width": width, "height": 800}, color_scheme=scheme
        )
        contexts.append(context)
        page = context.new_page()
        page.fetched, page.complaints = [], []
        page.on("request", lambda request: page.fetched.append(request.url))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on(
            "console",
            lambda line: (
                page.complaints.append(line.text)
                if line.type in ("error", "warning")
                else None
            ),
        )
        page.goto(path.as_uri())
        return page

    yield open_file
    for context in contexts:
        context.close()
