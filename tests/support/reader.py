"""Pages as their readers have them: elements, visible text and scripts."""

from html.parser import HTMLParser


class Reader(HTMLParser):
    """Elements and visible text of a page; complains about elements that are not closed."""

    EMPTY = frozenset({"meta", "img", "circle", "path", "line", "polyline", "input", "br"})

    def __init__(self, page):
        super().__init__()
        self.open, self.elements, self.text, self.scripts = [], [], "", []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts.append(data)
        elif self.open and self.open[-1] != "style":
            self.text += data
