"""Generates C and C++ sources from IDL declarations."""
import json
import os

from idl.declarations import SCALARS, Alias, Const, Enum, Shape, Struct, description, max_size, product


def c_name(name):
    return name.replace("::", "_")


def outputs_of(stem):
    return [f"{stem}.hpp", f"{stem}_types.cpp", f"{stem}_c.h", f"{stem}_c.cpp"]


def literal(text):
    """Returns the text as a C string literal, split into lines."""
    pieces = [text[i:i + 90] for i in range(0, len(text), 90)] or [""]
    return "\n      ".join(json.dumps(piece) for piece in pieces)


class Code:
    """Lines of C++ that write (put) or read (get) the fields of a struct.

    With the language "c++", fields have accessor functions and sequences are vectors. With "c", the code is for the structs of C modules.
    """

    def __init__(self, language):
        self.language = language
        self.lines = []
        self.indent = "  "
        self.variables = 0

    def line(self, text):
        self.lines.append(self.indent + text)

    def block(self, head, body):
        self.line(head + " {")
        self.indent += "  "
        body()
        self.indent = self.indent[:-2]
        self.line("}")

    def loop(self, what, over, constant, body):
        variable = f"e{self.variables}"
        self.variables += 1
        kind = "const auto&" if constant else "auto&"
        self.block(f"for ({kind} {variable} : {over})", lambda: body(variable))

    def nest(self, depth, expression, constant, body):
        if depth == 0:
            return body(expression)
        self.loop(None, expression, constant, lambda inner: self.nest(depth - 1, inner, constant, body))

    def access(self, each):
        return f"value.{each.name}()" if self.language == "c++" else f"value.{each.name}"

    # -- Write

    def put(self, each):
        shape = each.shape
        at = self.access(each)
        if shape.sequence:
            self.nest(len(shape.dimensions), at, True, lambda e: self.put_sequence(shape, e))
        else:
            self.put_array(shape, shape.dimensions, at)

    def put_sequence(self, shape, at):
        n = f"{at}.size()" if self.language == "c++" else f"{at}.length"
        self.line(f"to.put_length({n}, {shape.sequence});")
        if self.language == "c++":
            if shape.scalar in SCALARS and shape.scalar != "boolean":
                size = product(shape.elements)
                count = n if size == 1 else f"{n} * {size}"
                pointer = f"{at}.data()" if not shape.elements else self.scalars(shape, f"{at}.data()", const=True)
                self.line(f"to.put_array({pointer}, {count});")
            elif shape.scalar == "boolean" and not shape.elements:
                self.line(f"if ({n} <= {shape.sequence}) for (const bool e : {at}) to.put(e);")
            else:
                self.block(f"if ({n} <= {shape.sequence})",
                           lambda: self.loop(None, at, True, lambda e: self.put_array(shape, shape.elements, e)))
            return
        if shape.scalar in SCALARS:
            size = product(shape.elements)
            count = n if size == 1 else f"{n} * std::size_t{{{size}}}"
            self.line(f"if ({n} <= {shape.sequence}) to.put_array({self.scalars(shape, f'{at}.items', const=True)}, "
                      f"{count});")
        else:
            index = f"i{self.variables}"
            self.variables += 1
            self.block(f"for (std::uint32_t {index} = 0; {index} < {n} && {index} < {shape.sequence}; ++{index})",
                       lambda: self.put_array(shape, shape.elements, f"{at}.items[{index}]"))

    def scalars(self, shape, pointer, const):
        kind = SCALARS[shape.scalar][1]
        return f"reinterpret_cast<{'const ' if const else ''}{kind}*>({pointer})"

    def put_array(self, shape, dimensions, at):
        if dimensions and shape.scalar in SCALARS:
            self.line(f"to.put_array({self.scalars(shape, f'&{at}', const=True)}, {product(dimensions)});")
        else:
            self.nest(len(dimensions), at, True, lambda e: self.put_one(shape, e))

    def put_one(self, shape, at):
        if shape.scalar == "string":
            limit = f"{at}.c_str(), {at}.size()" if self.language == "c++" else f"{at}, {shape.bound + 1}"
            self.line(f"to.put_text({limit}, {shape.bound});")
        elif shape.scalar == "enum":
            self.line(f"to.put_enumerator(static_cast<std::uint32_t>({at}), {len(shape.of.enumerators)});")
        elif shape.scalar == "struct":
            self.line(f"{self.function(shape, 'put')}(to, {at});")
        else:
            self.line(f"to.put({at});")

    def function(self, shape, what):
        return f"PortType<::{shape.of.name}>::{what}" if self.language == "c++" else f"{what}_{c_name(shape.of.name)}"

    # -- Read

    def get(self, each):
        shape = each.shape
        at = self.access(each)
        if shape.sequence:
            self.nest(len(shape.dimensions), at, False, lambda e: self.get_sequence(shape, e))
        else:
            self.get_array(shape, shape.dimensions, at)

    def get_sequence(self, shape, at):
        if self.language == "c++":
            self.line(f"{at}.resize(from.get_length({shape.sequence}));")
            n = f"{at}.size()"
            if shape.scalar in SCALARS and shape.scalar != "boolean":
                size = product(shape.elements)
                count = n if size == 1 else f"{n} * {size}"
                pointer = f"{at}.data()" if not shape.elements else self.scalars(shape, f"{at}.data()", const=False)
                self.line(f"from.get_array({pointer}, {count});")
            elif shape.scalar == "boolean" and not shape.elements:
                self.line(f"for (auto e : {at}) e = from.get_boolean();")
            else:
                self.loop(None, at, False, lambda e: self.get_array(shape, shape.elements, e))
            return
        self.line(f"{at}.length = static_cast<std::uint32_t>(from.get_length({shape.sequence}));")
        n = f"{at}.length"
        if shape.scalar in SCALARS and shape.scalar != "boolean":
            size = product(shape.elements)
            count = n if size == 1 else f"{n} * std::size_t{{{size}}}"
            self.line(f"from.get_array({self.scalars(shape, f'{at}.items', const=False)}, {count});")
        else:
            index = f"i{self.variables}"
            self.variables += 1
            self.block(f"for (std::uint32_t {index} = 0; {index} < {n}; ++{index})",
                       lambda: self.get_array(shape, shape.elements, f"{at}.items[{index}]"))

    def get_array(self, shape, dimensions, at):
        if dimensions and shape.scalar in SCALARS and shape.scalar != "boolean":
            self.line(f"from.get_array({self.scalars(shape, f'&{at}', const=False)}, {product(dimensions)});")
        else:
            self.nest(len(dimensions), at, False, lambda e: self.get_one(shape, e))

    def get_one(self, shape, at):
        if shape.scalar == "string":
            self.line(f"{at} = from.get_text({shape.bound});" if self.language == "c++"
                      else f"from.get_text({at}, {shape.bound});")
        elif shape.scalar == "enum":
            name = f"::{shape.of.name}" if self.language == "c++" else c_name(shape.of.name)
            self.line(f"{at} = static_cast<{name}>(from.get_enumerator({len(shape.of.enumerators)}));")
        elif shape.scalar == "struct":
            self.line(f"{self.function(shape, 'get')}(from, {at});")
        elif shape.scalar == "boolean":
            self.line(f"{at} = from.get_boolean();")
        else:
            self.line(f"{at} = from.get<{SCALARS[shape.scalar][1]}>();")

    # -- Check whether put() accepts the value; only for C++

    def fits(self, each):
        shape = each.shape
        if shape.may_not_fit():
            self.nest(len(shape.dimensions), self.access(each), True,
                      lambda e: self.sequence_fits(shape, e) if shape.sequence else self.one_fits(shape, e))

    def sequence_fits(self, shape, at):
        self.line(f"if ({at}.size() > {shape.sequence}) return false;")
        if shape.scalar == "enum" or (shape.scalar == "struct" and shape.of.misfits):
            self.nest(1 + len(shape.elements), at, True, lambda e: self.one_fits(shape, e))

    def one_fits(self, shape, at):
        self.line(f"if (static_cast<std::uint32_t>({at}) >= {len(shape.of.enumerators)}) return false;" if shape.scalar == "enum"
                  else f"if (!{self.function(shape, 'fits')}({at})) return false;")

    # -- Reserve memory for sequences

    def reserve(self, each):
        shape = each.shape
        at = self.access(each)
        if shape.sequence:
            self.nest(len(shape.dimensions), at, False, lambda e: self.line(f"{e}.reserve({shape.sequence});"))
        elif shape.has_sequence():
            self.nest(len(shape.dimensions), at, False, lambda e: self.line(f"PortType<::{shape.of.name}>::reserve({e});"))


def code_of(language, struct, what):
    code = Code(language)
    for each in struct.fields:
        getattr(code, what)(each)
    return code.lines


def head(file, what):
    return [f"// {what} Generated from {os.path.basename(file.path)} by takt_idl.py; do not edit."]


def c_declaration(shape, name):
    """Returns an IDL declaration as a declaration in C."""
    kind = "char" if shape.scalar == "string" else c_name(shape.of.name) if shape.of else SCALARS[shape.scalar][1]
    text = f"[{shape.bound + 1}]" if shape.scalar == "string" else ""
    if shape.sequence:
        items = f"{kind} items[{shape.sequence}]{sizes(shape.elements)}{text};"
        return f"struct {{ uint32_t length; {items} }} {name}{sizes(shape.dimensions)};"
    return f"{kind} {name}{sizes(shape.dimensions)}{text};"


def integer_in_c(value):
    if value == -2 ** 63:
        return f"({value + 1} - 1)"
    return f"({value})" if value < 0 else f"{value}ULL" if value >= 2 ** 63 else str(value)


def c_header(file):
    """X_c.h: the structs of C modules."""
    guard = f"TAKT_IDL_{file.stem.upper()}_C_H"
    lines = [f"/* The port types of C modules. Generated from {os.path.basename(file.path)} by takt_idl.py; do not edit. */",
             f"#ifndef {guard}", f"#define {guard}", "", "#include <stdbool.h>", "#include <stdint.h>", "",
             "#include <takt/type.h>",
             ""] + [f'#include "{stem}_c.h"' for stem in included_stems(file)]
    lines += ["", "#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    for declared in file.declares:
        name = c_name(declared.name)
        if isinstance(declared, Const):
            lines.append(f"#define {name} {integer_in_c(declared.value)}")
        elif isinstance(declared, Enum):
            scope = c_name(declared.name.rpartition("::")[0])
            names = [f"{scope}_{each}" if scope else each for each in declared.enumerators]
            lines += [f"typedef enum {name} {{ {', '.join(names)} }} {name};"]
        elif isinstance(declared, Struct):
            lines += ["", f"typedef struct {name} {{"] + [f"  {c_declaration(f.shape, f.name)}" for f in declared.fields] + [
                f"}} {name};", f"extern const takt_type {name}_type;",
                f"uint32_t {name}_encode(const {name}* value, unsigned char* to, uint32_t size);",
                f"int {name}_decode(const unsigned char* from, uint32_t size, {name}* value);"]
    return lines + ["", "#ifdef __cplusplus", "}", "#endif", "", "#endif"]


def c_source(file):
    """X_c.cpp: the serialization of the structs of X_c.h."""
    lines = head(file, "Serialization of the port types of C modules.") + [
        f'#include "{file.stem}_c.h"', "", "#include <cstddef>", "", "#include <takt/core/cdr.hpp>", "",
        "namespace takt::in_c {", ""]
    ours = structs_of(file)
    theirs = {f.shape.of.name for s in ours for f in s.fields if f.shape.scalar == "struct"} - {s.name for s in ours}
    for name in map(c_name, sorted(theirs)):
        lines += [f"void put_{name}(CdrWriter& to, const {name}& value) noexcept;",
                  f"void get_{name}(CdrReader& from, {name}& value) noexcept;", ""]
    for struct in ours:
        name = c_name(struct.name)
        lines += [f"void put_{name}(CdrWriter& to, const {name}& value) noexcept {{"] + code_of("c", struct, "put") + ["}", ""]
        lines += [f"void get_{name}(CdrReader& from, {name}& value) noexcept {{"] + code_of("c", struct, "get") + ["}", ""]
    lines += ["}  // namespace takt::in_c", "", 'extern "C" {', ""]
    for struct in ours:
        name = c_name(struct.name)
        lines += [
            f"uint32_t {name}_encode(const {name}* value, unsigned char* to, uint32_t size) {{",
            "  takt::CdrWriter writer{reinterpret_cast<std::byte*>(to), size};", f"  takt::in_c::put_{name}(writer, *value);",
            "  return writer.size();", "}", "",
            f"int {name}_decode(const unsigned char* from, uint32_t size, {name}* value) {{",
            "  takt::CdrReader reader{reinterpret_cast<const std::byte*>(from), size};",
            f"  takt::in_c::get_{name}(reader, *value);", "  return reader.complete() ? 1 : 0;", "}", "",
            f"const takt_type {name}_type = {{", f"    {json.dumps(struct.name)},", f"    {literal(description(struct))},",
            f"    {max_size(struct)},", f"    sizeof({name}),",
            "    [](const void* value, unsigned char* to, uint32_t size) {",
            f"      return {name}_encode(static_cast<const {name}*>(value), to, size);", "    },",
            "    [](const unsigned char* from, uint32_t size, void* value) {",
            f"      return {name}_decode(from, size, static_cast<{name}*>(value));", "    }};", ""]
    return lines + ["}"]


def sizes(dimensions):
    return "".join(f"[{size}]" for size in dimensions)


def included_stems(file):
    return [other.stem for other, _ in file.includes]


def cpp_type(shape):
    """Returns the C++ type of a field. The type begins with :: because a field or a module may have the same name."""
    def in_arrays(kind, dimensions):
        for size in reversed(dimensions):
            kind = f"::std::array<{kind}, {size}>"
        return kind

    if shape.scalar == "string":
        kind = f"::takt::BoundedString<{shape.bound}>"
    elif shape.of:
        kind = f"::{shape.of.name}"
    else:
        kind = SCALARS[shape.scalar][1]
        kind = f"::std::{kind}" if kind.endswith("_t") else kind
    kind = in_arrays(kind, shape.elements)
    return in_arrays(f"::std::vector<{kind}>" if shape.sequence else kind, shape.dimensions)


def cpp_class(struct):
    """Returns the class of a struct. Each field has the functions that fastddsgen generates: position(), and position(value)."""
    prefix = "m_"
    while any(each.name.startswith(prefix) for each in struct.fields):
        prefix += "m_"  # a member must not have the name of a function
    name = struct.name.split("::")[-1]
    lines = [f"class {name} {{", " public:"]
    for each in struct.fields:
        kind, member, shape = cpp_type(each.shape), prefix + each.name, each.shape
        small = not (shape.dimensions or shape.sequence or shape.scalar in ("string", "struct"))
        lines.append(f"  {kind + ' ' if small else f'const {kind}& '}{each.name}() const noexcept {{ return {member}; }}")
        lines.append(f"  {kind}& {each.name}() noexcept {{ return {member}; }}")
        if small:
            lines.append(f"  void {each.name}({kind} value) noexcept {{ {member} = value; }}")
        else:
            lines.append(f"  void {each.name}(const {kind}& value) {{ {member} = value; }}")
            lines.append(f"  void {each.name}({kind}&& value) noexcept {{ {member} = ::std::move(value); }}")
    lines += [f"  bool operator==(const {name}&) const = default;", "", " private:"]
    lines += [f"  {cpp_type(each.shape)} {prefix}{each.name}{{}};" for each in struct.fields]
    return lines + ["};"]


def cpp_declarations(file):
    """Returns the declarations of a file in C++, each in the namespace of its module."""
    lines, scope = [], None
    for declared in file.declares:
        inner, _, name = declared.name.rpartition("::")
        if inner != scope:
            lines += ([f"}}  // namespace {scope}"] if scope else []) + ["", f"namespace {inner} {{"][:2 if inner else 1]
            scope = inner
        lines.append("")
        if isinstance(declared, Const):
            kind = cpp_type(Shape(declared.type))
            lines.append(f"inline constexpr {kind} {name} = {integer_in_c(declared.value)};")
        elif isinstance(declared, Alias):
            lines.append(f"using {name} = {cpp_type(declared.shape)};")
        elif isinstance(declared, Enum):
            lines.append(f"enum {name} : ::std::uint32_t {{ {', '.join(declared.enumerators)} }};")
        else:
            lines += cpp_class(declared)
    return lines + (["", f"}}  // namespace {scope}"] if scope else [])


def header(file):
    """X.hpp: the declarations in C++, and takt::PortType for each struct."""
    lines = head(file, "The port types of C++ modules.") + [
        "#pragma once", "", "#include <array>", "#include <cstddef>", "#include <cstdint>", "#include <utility>",
        "#include <vector>", "", "#include <takt/component/port_type.hpp>", "#include <takt/core/bounded_string.hpp>",
        ""] + [f'#include "{stem}.hpp"' for stem in included_stems(file)] + cpp_declarations(file) + [
        "", "namespace takt {", "class CdrReader;", "class CdrWriter;", ""]
    for struct in structs_of(file):
        name = "::" + struct.name
        lines += [
            "template <>", f"struct PortType<{name}> {{", "  static constexpr TypeInfo info{",
            f"      {json.dumps(struct.name)},", f"      {literal(description(struct))},", f"      {max_size(struct)}}};",
            f"  static std::uint32_t encode(const {name}& value, std::byte* to, std::uint32_t size) noexcept;",
            f"  static bool fits(const {name}& value) noexcept;" if struct.misfits else
            f"  static constexpr bool fits(const {name}&) noexcept {{ return true; }}",
            f"  static bool decode(const std::byte* from, std::uint32_t size, {name}& value) noexcept;",
            f"  static void reserve({name}& value);",
            "  // Used if the struct is a field of another struct.",
            f"  static void put(CdrWriter& to, const {name}& value) noexcept;",
            f"  static void get(CdrReader& from, {name}& value);", "};", ""]
    return lines + ["}  // namespace takt"] + ros2_names(file)


def ros2_names(file):
    """Aliases for ROS 2 messages: the type is std_msgs::msg::dds_::String_ on the network, and std_msgs::msg::String in programs."""
    lines = []
    for struct in structs_of(file):
        if is_ros2_message(struct.name):
            package, _, _, name = struct.name.split("::")
            lines.append(f"namespace {package}::msg {{ using {name[:-1]} = dds_::{name}; }}")
    return [""] + lines if lines else []


def is_ros2_message(name):
    parts = name.split("::")
    return len(parts) == 4 and parts[1:3] == ["msg", "dds_"] and parts[3].endswith("_") and len(parts[3]) > 1


def source(file):
    """X_types.cpp: the serialization of the types of X.hpp."""
    lines = head(file, "Serialization of the port types.") + [f'#include "{file.stem}.hpp"', "", "#include <takt/core/cdr.hpp>", "",
                                                       "namespace takt {", ""]
    for struct in structs_of(file):
        name, port = "::" + struct.name, f"PortType<::{struct.name}>"
        lines += [f"void {port}::put(CdrWriter& to, const {name}& value) noexcept {{"] + code_of("c++", struct, "put") + ["}", ""]
        lines += [f"void {port}::get(CdrReader& from, {name}& value) {{"] + code_of("c++", struct, "get") + ["}", ""]
        if struct.misfits:
            lines += [f"bool {port}::fits(const {name}& value) noexcept {{"] + code_of("c++", struct, "fits") + [
                "  return true;", "}", ""]
        lines += [f"void {port}::reserve({name}& value) {{"] + code_of("c++", struct, "reserve") + ["}", ""]
        lines += [f"std::uint32_t {port}::encode(const {name}& value, std::byte* to, std::uint32_t size) noexcept {{",
                  "  CdrWriter writer{to, size};", "  put(writer, value);", "  return writer.size();", "}", ""]
        lines += [f"bool {port}::decode(const std::byte* from, std::uint32_t size, {name}& value) noexcept {{",
                  "  CdrReader reader{from, size};"]
        # The generated read function throws only if no memory is reserved for the sequences of the value.
        lines += (["  try {", "    get(reader, value);", "  } catch (...) {", "    return false;", "  }"] if struct.sequences
                  else ["  get(reader, value);"]) + ["  return reader.complete();", "}", ""]
    return lines + ["}  // namespace takt"]


def structs_of(file):
    return [d for d in file.declares if isinstance(d, Struct)]


def write_sources(folder, file):
    os.makedirs(folder, exist_ok=True)
    for name, lines in ((f"{file.stem}.hpp", header(file)), (f"{file.stem}_types.cpp", source(file)),
                        (f"{file.stem}_c.h", c_header(file)), (f"{file.stem}_c.cpp", c_source(file))):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as stream:
            stream.write("\n".join(lines) + "\n")
