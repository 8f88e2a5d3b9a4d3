#!/usr/bin/env python3
"""Checks docs/descriptor.md: the page has exactly the elements and attributes of the schema, with their values, bounds and defaults. The
bounds equal those of the code, and `takt check` accepts the examples.

Usage: descriptor_page_test.py BUILD_DIRECTORY SOURCE_DIRECTORY"""
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

build, source = sys.argv[1:]
XS = "{http://www.w3.org/2001/XMLSchema}"
schema = ElementTree.parse(os.path.join(source, "config", "takt.xsd")).getroot()
page = open(os.path.join(source, "docs", "descriptor.md"), encoding="utf-8").read()
failures = []

types = {t.get("name"): t for t in schema if t.tag in (XS + "complexType", XS + "simpleType")}
groups = {g.get("name"): g for g in schema if g.tag == XS + "group"}
# The page explains these types once, not in each row.
SAID_ABOVE = {"Name", "Time", "Endpoint"}


def inside(node):
    """Yields the elements and attributes directly in one element, also those of groups and extensions."""
    for child in node:
        if child.tag == XS + "element":
            yield child
        elif child.tag == XS + "attribute":
            yield child
        elif child.tag == XS + "group" and child.get("ref"):
            yield from inside(groups[child.get("ref")])
        else:
            yield from inside(child)


def facets(node):
    """The words and numbers that limit the value of this attribute or element."""
    kind = node.get("type")
    found = []
    if kind is not None:
        if kind in SAID_ABOVE or kind not in types:
            return found
        node = types[kind]
        if node.tag == XS + "complexType":
            return found
    for child in node.iter():
        if child.tag in (XS + "element", XS + "attribute") and child is not node:
            break  # the following nodes belong to a child
        name = child.tag.replace(XS, "")
        if name == "enumeration":
            found.append("`%s`" % child.get("value"))
        elif name in ("minInclusive", "maxInclusive", "minLength", "maxLength"):
            found.append(child.get("value"))
        elif name == "restriction" and child.get("base") in types and child.get("base") not in SAID_ABOVE:
            found += facets(types[child.get("base")])
    return found


UNITS = {"ns": 1, "us": 10**3, "ms": 10**6, "s": 10**9}


def says(text, word):
    """Returns whether the text contains the word. A time with a unit also counts as its number of nanoseconds."""
    times = [str(int(number) * UNITS[unit]) for number, unit in re.findall(r"\b(\d+) ?(ns|us|ms|s)\b", text)]
    return word in times or re.search(r"(?<![\w-])" + re.escape(word) + r"(?![\w-])", text) is not None


def walk(name, node, elements):
    """Fills elements[NAME] = {"`attribute`" or "`<element>`": its node} for all elements that are not empty."""
    rows = {}
    for child in inside(types[node.get("type")] if node.get("type") in types else node):
        is_element = child.tag == XS + "element"
        rows["`<%s>`" % child.get("name") if is_element else "`%s`" % child.get("name")] = child
        if is_element:
            walk(child.get("name"), child, elements)
    if rows:
        if elements.get(name, rows).keys() != rows.keys():
            # <executor> and <deadline> each occur in two places. The section describes the element that has attributes.
            rows = {**elements[name], **rows}
        elements[name] = rows


elements = {}
for root in schema.findall(XS + "element"):
    walk(root.get("name"), root, elements)

sections = {}
for heading, text in re.findall(r"^## `<([a-z-]+)>`\n(.*?)(?=^## |\Z)", page, re.S | re.M):
    rows = re.findall(r"^\| (`[^`]+`) \|(.*)\|$", text, re.M)
    if len(rows) != len({row for row, _ in rows}):
        failures.append(f"<{heading}> has a row twice")
    sections[heading] = dict(rows)

if len(elements) < 10 or sum(map(len, elements.values())) < 40:
    failures.append(f"only {len(elements)} elements were found in the schema")
for name in sorted(set(elements) - set(sections)):
    failures.append(f"<{name}> has no section")
for name in sorted(set(sections) - set(elements)):
    failures.append(f"<{name}> has a section and is not in the schema")
for name in set(elements) & set(sections):
    for row in elements[name].keys() - sections[name].keys():
        failures.append(f"<{name}>: {row} has no row")
    for row in sections[name].keys() - elements[name].keys():
        failures.append(f"<{name}>: {row} has a row and is not in the schema")
    for row in elements[name].keys() & sections[name].keys():
        node, text = elements[name][row], sections[name][row]
        value, _, rest = text.partition("|")
        unless_said = [node.get("default")] if node.get("default") is not None else []
        unless_said += ["required"] if node.get("use") == "required" else []
        for words, where in ((facets(node), value), (unless_said, rest)):
            for word in words:
                if not says(where, word):
                    failures.append(f"<{name}>: the row of {row} does not say {word}: {where.strip()}")

# The page must state the value of each bound that these headers define.
for header in ("framework/model/include/takt/model/validate.hpp", "framework/descriptor/src/well_formed.hpp", "framework/descriptor/src/include.hpp",
               "framework/descriptor/src/template.hpp"):
    code = open(os.path.join(source, header), encoding="utf-8").read()
    bounds = re.findall(r"inline constexpr (?:int|std::size_t) (kM\w+) = ([0-9']+);", code)
    if not bounds:
        failures.append(f"{header} has no bounds")
    for constant, value in bounds:
        if constant == "kMaxProblems":
            continue  # this constant limits reports, not descriptors
        value = value.replace("'", "")
        if not re.search(r"(?<!\d)" + value + r"(?!\d)", page):
            failures.append(f"{header}: {constant} is {value}, but the page does not name this value")

examples = re.findall(r"```xml\n(<(?:cell|root).*?)```", page, re.S)
if not examples:
    failures.append("there is no example")
for example in examples:
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
        file.write(example)
        file.flush()
        done = subprocess.run([os.path.join(build, "bin", "takt"), "check", "--remote", file.name], capture_output=True, text=True,
                              timeout=60)
        if done.returncode != 0:
            failures.append(f"takt check rejects an example:\n{done.stderr}")

print("\n".join(failures) or f"{sum(map(len, elements.values()))} rows agree with the schema")
sys.exit(1 if failures else 0)
