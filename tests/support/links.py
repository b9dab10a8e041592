"""Links of HTML files: which lead nowhere."""

from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """`places` are what can be linked to, `links` what is linked to, `outside` what is loaded from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.places, self.links, self.outside = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id" or (tag == "a" and name == "name"):
                self.places.add(value)
            elif name in ("href", "src") and value is not None:
                if not urlsplit(value).scheme and not value.startswith("//"):
                    self.links.append(value)
                elif tag != "a" and urlsplit(value).scheme != "data":
                    self.outside.append(value)


def faults(folder):
    """Complaints about the HTML files below a folder: links to what is not there, outside resources."""
    pages = {path.resolve(): Page(path.read_text()) for path in folder.rglob("*.html")}
    for path, page in pages.items():
        name = path.relative_to(folder.resolve())
        yield from (f"{name}: loads {address}" for address in page.outside)
        for link in page.links:
            parts = urlsplit(link)
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.is_file():
                yield f"{name}: {link}: no such file"
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].places:
                yield f"{name}: {link}: no such place there"
