#!/usr/bin/python3
"""Every link of the built site leads somewhere inside it: pages, anchors, pictures, scripts, fonts of style sheets; and nothing is loaded from a
network. check_site.py FOLDER [--skip SUBFOLDER]...    Links to other sites are not followed."""

import argparse
import html.parser
import pathlib
import re
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """The links, the loaded files and the anchors of a page."""

    LOADED = {("img", "src"), ("script", "src"), ("source", "src"), ("video", "src"), ("iframe", "src")}

    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.anchors = [], [], {""}
        self.feed(path.read_text(encoding="utf-8", errors="replace"))

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        for name in ("id", "name"):
            if values.get(name):
                self.anchors.add(values[name])
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag == "link" and values.get("href"):
            (self.loaded if values.get("rel") in ("stylesheet", "icon", "preload") else self.links).append(values["href"])
        for name in ("src",):
            if (tag, name) in self.LOADED and values.get(name):
                self.loaded.append(values[name])


def problems(root, skipped):
    pages = {path: Page(path) for path in sorted(root.rglob("*.html"))}
    if not pages:
        yield f"{root}: no page"
    for path, page in pages.items():
        name = path.relative_to(root)
        if any(part in skipped for part in name.parts[:-1]):
            continue
        for target in [*page.links, *page.loaded]:
            parts = urllib.parse.urlsplit(target)
            if parts.scheme in ("data", "mailto"):
                continue
            if parts.scheme or parts.netloc:
                if target in page.loaded:
                    yield f"{name}: loads {target} from a network"
                continue
            if target.startswith("/"):
                yield f"{name}: {target} begins at the root of a server"
                continue
            file = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if file.is_dir():
                file = file / "index.html"
            if not file.exists():
                yield f"{name}: {target}: there is no such file"
            elif parts.fragment and file in pages and urllib.parse.unquote(parts.fragment) not in pages[file].anchors:
                yield f"{name}: {target}: the page has no such anchor"
    for path in sorted(root.rglob("*.css")):
        if any(part in skipped for part in path.relative_to(root).parts[:-1]):
            continue
        for target in re.findall(r"url\(\s*['\"]?([^'\")]+)", path.read_text(encoding="utf-8", errors="replace")):
            if re.match(r"https?:|//", target):
                yield f"{path.relative_to(root)}: loads {target} from a network"
            elif not target.startswith(("data:", "#")) and not (path.parent / target.split("?")[0].split("#")[0]).exists():
                yield f"{path.relative_to(root)}: {target}: there is no such file"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--skip", action="append", default=[], help="folder whose pages are not checked, but may be linked to")
    options = parser.parse_args()
    found = list(problems(options.folder.resolve(), set(options.skip)))
    print("\n".join(found) if found else f"{sum(1 for _ in options.folder.rglob('*.html'))} pages, every link leads somewhere")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
