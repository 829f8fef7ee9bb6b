"""Checks the built site, ``python docs/check_site.py docs/_build/html``: links, anchors, and nothing from a network."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_LOADED = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src"}
_HINTS = ("canonical", "next", "prev", "search", "index")  # relations that load nothing


class Page(HTMLParser):
    """Anchors of a page, what it links to, and what it loads."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors: set[str] = {""}
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.anchors |= {found[key] or "" for key in ("id", "name") if key in found}
        if tag == "a" and found.get("href"):
            self.links.append(found["href"] or "")
        value = found.get(_LOADED.get(tag, ""))
        if value and not (tag == "link" and found.get("rel") in _HINTS):
            self.loaded.append(value)


def faults(site: Path) -> list[str]:
    """What is wrong with the site, a line each."""
    pages = {path.resolve(): Page(path) for path in sorted(site.rglob("*.html"))}
    out = [] if pages else [f"{site} holds no page: run 'make docs'"]
    for path, page in pages.items():
        name = path.relative_to(site.resolve())
        out += [f"{name}: loads {url}" for url in page.loaded if urlsplit(url).netloc]
        for url in (*page.links, *page.loaded):
            parts = urlsplit(url)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                out.append(f"{name}: {url} is not there")
            elif target in pages and unquote(parts.fragment) not in pages[target].anchors:
                out.append(f"{name}: {url} has no such anchor")
    return out


if __name__ == "__main__":
    found = faults(Path(sys.argv[1]))
    sys.exit("\n".join(found) if found else 0)
