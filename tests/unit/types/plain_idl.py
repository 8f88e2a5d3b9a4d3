#!/usr/bin/env python3
"""Rewrites port types for fastddsgen, whose classes the tests compare with those of Takt.

  plain_idl.py LIBRARY DIR a.idl b.idl     writes DIR/a.idl and DIR/b.idl; LIBRARY is the folder of takt_idl.py

The rewritten files have numbers instead of constants, because the code that fastddsgen generates for constants does not compile, and no
arrays of typedefs, because that code does not initialize them."""
import os
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])

from idl.code import included_stems, sizes  # noqa: E402
from idl.declarations import Alias, Const, Enum  # noqa: E402
from idl.library import Library  # noqa: E402


def idl_declaration(declared, name):
    """Returns a declaration without typedefs. Sequences keep their typedefs."""
    shape = declared.shape
    if shape.sequence:
        return f"{shape.text} {name}{sizes(declared.own)};"
    kind = f"string<{shape.bound}>" if shape.scalar == "string" else shape.of.name if shape.of else shape.scalar
    return f"{kind} {name}{sizes(shape.dimensions)};"


def plain_idl(file):
    guard = f"{file.stem.upper()}_PLAIN_IDL"
    lines = [f"#ifndef {guard}", f"#define {guard}"] + [f'#include "{stem}.idl"' for stem in included_stems(file)]
    for declared in file.declares:
        *modules, name = declared.name.split("::")
        lines += [f"module {module} {{" for module in modules]
        if isinstance(declared, Const):
            lines.append(f"const {declared.type} {name} = {declared.value};")
        elif isinstance(declared, Alias):
            lines.append(f"typedef {idl_declaration(declared, name)}")
        elif isinstance(declared, Enum):
            lines.append(f"enum {name} {{ {', '.join(declared.enumerators)} }};")
        else:
            lines += [f"@final struct {name} {{"]
            lines += [f"  {idl_declaration(each, each.name)}" for each in declared.fields] + ["};"]
        lines += ["};" for module in modules]
    return lines + ["#endif"]


library = Library()
for path in sys.argv[3:]:
    read = library.read(path)
    with open(os.path.join(sys.argv[2], os.path.basename(path)), "w", encoding="utf-8") as stream:
        stream.write("\n".join(plain_idl(read)) + "\n")
