"""Elements of a page that a command writes, and whether its tags are balanced."""

from html.parser import HTMLParser

ALONE = ("meta", "img", "input")
"""What is never closed."""


class Page(HTMLParser):
    """Elements of a page; its tags are balanced."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.open = [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        """Note an element, and that it must be closed."""
        self.elements.append((tag, dict(attrs)))
        if tag not in ALONE:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        """Note an element that closes itself."""
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        """Close the element that was opened last."""
        assert self.open.pop() == tag

    def all(self, tag):
        """Attributes of each element of a kind."""
        return [attributes for name, attributes in self.elements if name == tag]
