#!/usr/bin/env python3
"""Installs the manual: the README, the pages of docs/, and every page, picture and file that they link to, directly or through other pages.

The manual has the layout of the source tree, so that relative links stay valid. A link to a folder becomes a link to its page. Links to
pages for people who change Takt itself are removed; their words stay.

Usage: manual.py SOURCE DESTINATION"""
import glob
import os
import re
import shutil
import sys

FOR_DEVELOPERS = ("ARCHITECTURE.md", "CONTRIBUTING.md", "tests/", "docs/api.md")
CODE = re.compile(r"^```.*?^```$", re.M | re.S)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s#]*)(#[^()\s]*)?\)")
NAMED = re.compile(r"^\[([^\[\]]+)\]: +(?![a-z]+:)([^\s#]+)", re.M)  # the target of links of the form [name]


class Manual:
    def __init__(self, source):
        self.source = source
        self.files = {}  # by path: the text of a page, or None for a file that is copied

    def add(self, path):
        if path in self.files:
            return
        self.files[path] = None
        if path.endswith(".md"):
            with open(os.path.join(self.source, path), encoding="utf-8") as file:
                self.files[path] = self.rewritten(file.read(), path)

    def rewritten(self, text, path):
        """Returns the text with each link made valid, outside blocks of code. Adds the files to which it links."""
        done, at = [], 0
        for code in CODE.finditer(text):
            done += [self.rewritten_links(text[at:code.start()], path), code.group()]
            at = code.end()
        return "".join(done) + self.rewritten_links(text[at:], path)

    def rewritten_links(self, text, path):
        def rewritten_link(link):
            picture, words, target, anchor = link.groups()
            if not target or re.match(r"[a-z]+:", target):
                return link.group()
            target = self.target(target, path)
            return f"{picture}[{words}]({target}{anchor or ''})" if target else words

        for named in NAMED.finditer(text):
            if self.target(named[2], path) != named[2]:
                sys.exit(f"{path}: error: the link [{named[1]}] names a folder or a page for developers, which only an inline link may do; write [text](target)")
        return LINK.sub(rewritten_link, text)

    def target(self, target, path):
        """Adds the file to which a page links, and returns the target of the link in the manual; none if the manual does not have it."""
        to = os.path.normpath(os.path.join(os.path.dirname(path), target))
        if to.startswith(FOR_DEVELOPERS):
            return None
        if os.path.isdir(os.path.join(self.source, to)):
            to, target = to + "/README.md", target.rstrip("/") + "/README.md"
        if not os.path.isfile(os.path.join(self.source, to)):
            sys.exit(f"{path}: error: there is no file {to}; correct the link")
        self.add(to)
        return target


def main(source, destination):
    manual = Manual(source)
    for page in ["README.md", "LICENSE"] + sorted(glob.glob("docs/*.md", root_dir=source)):
        if not page.startswith(FOR_DEVELOPERS):
            manual.add(page)
    for path, text in manual.files.items():
        to = os.path.join(destination, path)
        os.makedirs(os.path.dirname(to), exist_ok=True)
        if text is None:
            shutil.copyfile(os.path.join(source, path), to)
        else:
            with open(to, "w", encoding="utf-8") as file:
                file.write(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
