// The type of a port as data, read from the description of its IDL. Programs that were not compiled with the
// type use it to check, print and build samples. Port types are final structs without keys, and all their
// strings and sequences have bounds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::model {

/// The limits of port types. The IDL compiler (cmake/takt_idl.py) has the same limits.
inline constexpr std::size_t kMaxSampleSize = 64 * 1024 * 1024;  ///< in bytes
/// Maximum number of fields. The fields of a nested struct count each time that the struct is used.
inline constexpr std::size_t kMaxFields = 4096;
inline constexpr std::size_t kMaxNesting = 16;  ///< maximum nesting depth of structs
inline constexpr std::size_t kMaxTypeName = 255;
inline constexpr std::size_t kMaxUnit = 32;  ///< maximum number of characters of a unit
/// Maximum length in bytes of a text for parse_type().
inline constexpr std::size_t kMaxDescription = 1024 * 1024;

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
/// Returns the IDL keyword of a scalar, for example "boolean", "unsigned long", "string", "enum" or "struct".
const char* to_text(Scalar scalar);

/// One field of a struct: a single value, an array, a sequence, or an array of sequences. The elements of a
/// sequence may be arrays.
struct Field {
  std::string name;
  Scalar scalar = Scalar::int32;
  std::string unit{};                     ///< unit of a number, from @unit in IDL; may be empty
  std::size_t bound = 0;                  ///< maximum number of characters of a string
  std::vector<std::size_t> dimensions{};  ///< dimensions of an array; empty: not an array
  std::size_t sequence = 0;  ///< maximum number of elements of a sequence; 0 if the field is not a sequence
  /// If each element of the sequence is an array: the dimensions of this array. Empty: each element is a
  /// single value.
  std::vector<std::size_t> elements{};
  std::string type_name{};  ///< name of the enumeration or structure, for example "motion::Mode"
  std::vector<std::string> enumerators{};
  std::vector<Field> fields{};  ///< fields of the structure
  bool operator==(const Field&) const = default;
};

struct Type {
  std::string name;  ///< name of the type on DDS, for example "motion::JointState"
  std::vector<Field> fields;
  /// Two ports can be connected only if their types are equal.
  bool operator==(const Type&) const = default;
};

/// Reads a type from the JSON that takt_add_idl puts into the generated code. The members of the JSON are
/// those of Type and Field; empty members are omitted:
///
///   {"name":"motion::Plan","fields":[{"name":"mode","type":"enum","of":"motion::Mode","enumerators":["OFF","ON"]},
///     {"name":"speed","type":"double","unit":"m/s"},
///     {"name":"label","type":"string","bound":15},{"name":"way","type":"double","array":[2,6],"sequence":8,"elements":[3]},
///     {"name":"start","type":"struct","of":"motion::Pose","fields":[...]}]}
///
/// Fails if the text does not describe a type, or if no port can have the type, because it has a string
/// without a bound, a sequence within a sequence or a key, or exceeds a limit above. Each problem names its
/// field.
Result<Type> parse_type(const std::string& text);
/// Converts a type to JSON. If parse_type() read the type, the result equals its text, byte for byte.
std::string to_text(const Type& type);

/// Returns the maximum size in bytes of a sample in XCDR1. The size includes the 4 bytes of encapsulation,
/// and is a multiple of 4, because RTPS sends whole words of 4 bytes. If a sample can exceed kMaxSampleSize,
/// the result is any number larger than kMaxSampleSize.
std::size_t max_size(const Type& type);

/// Returns true if the bytes are one complete sample of the type, and keep all bounds of the type. Checks the
/// encapsulation (XCDR1, either byte order), lengths, booleans, enumerators and the ends of strings. Padding
/// after the last field is allowed. Returns true for exactly the samples that PortType::decode() accepts.
/// Real-time threads may call this for a type that parse_type() returned: is_sample() neither allocates
/// memory nor throws, whatever the bytes are.
bool is_sample(const Type& type, const std::byte* bytes, std::size_t size) noexcept;

/// Returns the sample as one line of JSON with all fields, for example {"position": [0, 1], "mode": "ON"}.
/// The bytes must be a sample, see is_sample(). Numbers that JSON cannot express become "NaN", "Infinity" or
/// "-Infinity". Bytes of a string that are not UTF-8 are replaced.
std::string sample_json(const Type& type, const std::byte* bytes, std::size_t size);

/// Converts JSON, in the form that sample_json() writes, to the bytes of a sample, in little endian. Missing
/// fields become zero. Fails if a value is not valid for its field; the problem names the field.
Result<std::vector<std::byte>> sample_bytes(const Type& type, const std::string& json);

}  // namespace takt::model
