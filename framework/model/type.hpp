// The type of a port, as data: what is written in its IDL, so that programs that were not compiled with it
// can check and print its samples. Types of ports are final structs without keys, whose strings and sequences
// are bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::model {

enum class Scalar {
  boolean,
  octet,
  character,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  text,
  enumeration,
  structure
};
/// IDL's words: "boolean", "octet", "char", "short", "unsigned long", "double", "string", ...
const char* to_text(Scalar scalar);

struct Field {
  std::string name;
  Scalar scalar = Scalar::int32;
  std::size_t bound = 0;                ///< of a string: most characters
  std::vector<std::size_t> dimensions;  ///< of an array; empty: none
  std::size_t sequence = 0;             ///< most elements of a sequence; 0: it is none
  std::string type_name;                ///< of an enumeration or structure: "motion::Mode"
  std::vector<std::string> enumerators;
  std::vector<Field> fields;  ///< of a structure
  bool operator==(const Field&) const = default;
};

struct Type {
  std::string name;  ///< "motion::JointState", its name on DDS
  std::vector<Field> fields;
  /// Two ports can be connected when their types are equal.
  bool operator==(const Type&) const = default;
};

/// As the code that takt_add_idl generates carries it (JSON). Fails on a text that is none, and on a type
/// that no port can have: a string or sequence without a bound, a sequence within a sequence, a key; the
/// problem names the field.
Result<Type> parse_type(const std::string& text);
std::string to_text(const Type& type);

/// Most bytes of a sample as XCDR1, with the 4 bytes of encapsulation before it.
std::size_t max_size(const Type& type);

/// Whether the bytes are one sample of the type, whole and within all bounds: encapsulation (XCDR1, either
/// byte order), lengths, booleans, enumerators, ends of strings. Neither allocates nor throws, whatever the
/// bytes are.
bool is_sample(const Type& type, const std::byte* bytes, std::size_t size) noexcept;

/// The sample by field, for bytes for which is_sample() holds: one line {"position": [0, 1], "mode": "ON"} of
/// JSON.
std::string sample_json(const Type& type, const std::byte* bytes, std::size_t size);

/// The bytes of a sample from such JSON; a field that is missing is zero. Fails with the field's name where a
/// value does not fit. Little endian.
Result<std::vector<std::byte>> sample_bytes(const Type& type, const std::string& json);

}  // namespace takt::model
