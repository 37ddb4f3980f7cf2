"""Pages of the documentation: what a browser would fetch elsewhere, and dead links.

``python -m tests.contracts.pages docs/_build/html`` says what is wrong, and is part of
the checks of a build.
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

FETCHED = {
    "script": "src", "img": "src", "iframe": "src", "link": "href", "source": "src",
}  # fmt: skip
QUIET = {"canonical", "next", "prev", "author", "search", "index"}
"""Relations of links that no browser follows by itself."""


class ParsedPage(HTMLParser):
    """What a page fetches, links to, and can be linked to."""

    def __init__(self, path):
        super().__init__()
        self.fetched, self.links, self.anchors = [], [], set()
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attributes):
        """Note what matters of a tag."""
        given = dict(attributes)
        self.anchors |= {given[k] for k in ("id", "name") if given.get(k)}
        relation = set((given.get("rel") or "").split())
        if tag in FETCHED and given.get(FETCHED[tag]) and not relation & QUIET:
            self.fetched.append(given[FETCHED[tag]])
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])


def faults(folder):
    """Of all pages, a line each."""
    pages = {path.resolve(): ParsedPage(path) for path in folder.rglob("*.html")}
    for path, page in sorted(pages.items()):
        here = path.relative_to(folder.resolve())
        for url in page.fetched:
            if urlsplit(url).scheme in ("http", "https") or url.startswith("//"):
                yield f"{here} fetches {url}"
            elif not target(path, url).exists() and not url.startswith("data:"):
                yield f"{here} wants {url}, which is not there"
        for url in page.links:
            parts = urlsplit(url)
            if parts.scheme or parts.netloc:
                continue
            there = target(path, url) if parts.path else path
            if not there.exists():
                yield f"{here} leads to {url}, which is not there"
            elif parts.fragment and there in pages and not found(pages[there], parts):
                yield f"{here} leads to {url}, which has no such place"


def found(page, parts):
    """Whether a page has the place that an address means."""
    return unquote(parts.fragment) in page.anchors


def target(path, url):
    """The file that a relative address means."""
    there = (path.parent / unquote(urlsplit(url).path)).resolve()
    return there / "index.html" if there.is_dir() else there


if __name__ == "__main__":
    told = list(faults(Path(sys.argv[1])))
    sys.stdout.write("".join(f"{line}\n" for line in told))
    sys.exit(bool(told))
