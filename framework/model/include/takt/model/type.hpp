// The type of a port as data: the content of its IDL. With it, programs that were not compiled with the type
// can check and print its samples. Port types are final structs without keys; their strings and sequences
// have bounds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::model {

/// The limits of every type. The IDL compiler (cmake/takt_idl.py) has the same limits.
inline constexpr std::size_t kMaxSampleSize = 64 * 1024 * 1024;  ///< bytes
inline constexpr std::size_t kMaxFields = 4096;  ///< including the fields of structs, counted at every use
inline constexpr std::size_t kMaxNesting = 16;   ///< levels of structs within structs
inline constexpr std::size_t kMaxTypeName = 255;
inline constexpr std::size_t kMaxDescription = 1024 * 1024;  ///< bytes of the text for parse_type()

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
/// The IDL keywords: "boolean", "octet", "char", "short", "unsigned long", "double", "string", "enum",
/// "struct", ...
const char* to_text(Scalar scalar);

/// A field is one value, an array, a sequence, or an array of sequences. The elements of a sequence may be
/// arrays.
struct Field {
  std::string name;
  Scalar scalar = Scalar::int32;
  std::size_t bound = 0;                  ///< for a string: maximum number of characters
  std::vector<std::size_t> dimensions{};  ///< of an array; empty: not an array
  std::size_t sequence = 0;               ///< maximum number of elements of a sequence; 0: not a sequence
  std::vector<std::size_t> elements{};    ///< dimensions of each element of a sequence; empty: single values
  std::string type_name{};                ///< of an enumeration or structure: "motion::Mode"
  std::vector<std::string> enumerators{};
  std::vector<Field> fields{};  ///< of a structure
  bool operator==(const Field&) const = default;
};

struct Type {
  std::string name;  ///< its name on DDS: "motion::JointState"
  std::vector<Field> fields;
  /// Two ports can be connected if their types are equal.
  bool operator==(const Type&) const = default;
};

/// Reads the JSON in the code that takt_add_idl generates. Its members are those of Field; empty members are
/// left out:
///
///   {"name":"motion::Plan","fields":[{"name":"mode","type":"enum","of":"motion::Mode","enumerators":["OFF","ON"]},
///     {"name":"label","type":"string","bound":15},{"name":"way","type":"double","array":[2,6],"sequence":8,"elements":[3]},
///     {"name":"start","type":"struct","of":"motion::Pose","fields":[...]}]}
///
/// Fails if the text is not such a description, or if no port can have the type: a string without a bound, a
/// sequence within a sequence, a key, or a limit above exceeded. Each problem names its field.
Result<Type> parse_type(const std::string& text);
/// The text that parse_type() read, byte for byte.
std::string to_text(const Type& type);

/// The maximum size of a sample in bytes, as XCDR1. It includes the 4 bytes of encapsulation and is a
/// multiple of 4, because RTPS sends whole words. If the size exceeds kMaxSampleSize, the result is some
/// number larger than kMaxSampleSize.
std::size_t max_size(const Type& type);

/// Whether the bytes are one complete sample of the type, within all bounds. Checks the encapsulation (XCDR1,
/// either byte order), lengths, booleans, enumerators and ends of strings. The last word may be padded. The
/// result is true exactly if PortType::decode() succeeds. Real-time for a type of parse_type(): neither
/// allocates nor throws for any bytes.
bool is_sample(const Type& type, const std::byte* bytes, std::size_t size) noexcept;

/// The sample as one line of JSON with its fields: {"position": [0, 1], "mode": "ON"}. Requires is_sample().
/// Numbers that JSON cannot express are "NaN", "Infinity" or "-Infinity"; bytes of a string that are not
/// UTF-8 are replaced.
std::string sample_json(const Type& type, const std::byte* bytes, std::size_t size);

/// Converts such JSON to the bytes of a sample, in little endian. A missing field is zero. If a value does
/// not fit, fails with the name of the field.
Result<std::vector<std::byte>> sample_bytes(const Type& type, const std::string& json);

}  // namespace takt::model
