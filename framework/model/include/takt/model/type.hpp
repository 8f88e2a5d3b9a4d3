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

/// Bounds of every type, the same for who makes one of IDL (cmake/takt_idl.py).
inline constexpr std::size_t kMaxSampleSize = 64 * 1024 * 1024;
inline constexpr std::size_t kMaxFields = 4096;  ///< with those of structs, each time that they are there
inline constexpr std::size_t kMaxNesting = 16;   ///< structs within one another
inline constexpr std::size_t kMaxTypeName = 255;
inline constexpr std::size_t kMaxDescription = 1024 * 1024;  ///< bytes of parse_type()'s text

enum class Scalar {
  boolean,
  octet,
  character,
  int8,
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
/// IDL's words: "boolean", "octet", "char", "short", "unsigned long", "double", "string", "enum", "struct",
/// ...
const char* to_text(Scalar scalar);

/// One value, an array, a sequence, or an array of sequences; a sequence's elements may be arrays.
struct Field {
  std::string name;
  Scalar scalar = Scalar::int32;
  std::size_t bound = 0;                  ///< of a string: most characters
  std::vector<std::size_t> dimensions{};  ///< of an array; empty: none
  std::size_t sequence = 0;               ///< most elements of a sequence; 0: it is none
  std::vector<std::size_t> elements{};    ///< dimensions of each element of a sequence; empty: none
  std::string type_name{};                ///< of an enumeration or structure: "motion::Mode"
  std::vector<std::string> enumerators{};
  std::vector<Field> fields{};  ///< of a structure
  bool operator==(const Field&) const = default;
};

struct Type {
  std::string name;  ///< "motion::JointState", its name on DDS
  std::vector<Field> fields;
  /// Two ports can be connected when their types are equal.
  bool operator==(const Type&) const = default;
};

/// From JSON as the code of takt_add_idl carries it, each member as in Field, those that are empty left out:
///
///   {"name":"motion::Plan","fields":[{"name":"mode","type":"enum","of":"motion::Mode","enumerators":["OFF","ON"]},
///     {"name":"label","type":"string","bound":15},{"name":"way","type":"double","array":[2,6],"sequence":8,"elements":[3]},
///     {"name":"start","type":"struct","of":"motion::Pose","fields":[...]}]}
///
/// Fails on a text that is none, and on a type that no port can have: a string without a bound, a sequence
/// within a sequence, a key, more than the bounds above; each problem names its field.
Result<Type> parse_type(const std::string& text);
/// The same text again, byte by byte.
std::string to_text(const Type& type);

/// Most bytes of a sample as XCDR1, with the 4 bytes of encapsulation before it and in whole words of 4, for
/// RTPS sends whole words; more than kMaxSampleSize when it is more.
std::size_t max_size(const Type& type);

/// Whether the bytes are one sample of the type, whole and within all bounds: encapsulation (XCDR1, either
/// byte order), lengths, booleans, enumerators, ends of strings; the rest of a word may follow. Holds exactly
/// when PortType::decode() does. Real-time for a type of parse_type(): neither allocates nor throws, whatever
/// the bytes are.
bool is_sample(const Type& type, const std::byte* bytes, std::size_t size) noexcept;

/// The sample by field, for bytes for which is_sample() holds: one line {"position": [0, 1], "mode": "ON"} of
/// JSON. What JSON has no number for is "NaN", "Infinity" or "-Infinity"; bytes of a string that are no UTF-8
/// are replaced.
std::string sample_json(const Type& type, const std::byte* bytes, std::size_t size);

/// The bytes of a sample from such JSON; a field that is missing is zero. Fails with the field's name where a
/// value does not fit. Little endian.
Result<std::vector<std::byte>> sample_bytes(const Type& type, const std::string& json);

}  // namespace takt::model
