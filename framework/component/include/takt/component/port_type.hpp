// PortType: describes, encodes and decodes the samples of a port. takt_add_idl generates a specialisation for
// every struct of an IDL file:
//
//   takt_add_idl(types motion.idl)      in CMake
//   #include <motion.hpp>               the struct motion::JointState and its PortType
#pragma once

#include <cstddef>
#include <cstdint>

namespace takt {

/// The description of a type, in static storage. The content is the same in every object file that is
/// compiled from the same IDL.
struct TypeInfo {
  const char* name;         ///< "motion::JointState", the name on DDS
  const char* description;  ///< JSON for model::parse_type(); types with equal descriptions are the same type
  std::uint32_t max_size;   ///< maximum size of a CDR sample in bytes, with encapsulation; a multiple of 4
};

/// Encodes and decodes values of T, a struct of an IDL file. A real-time thread may call encode() and fits().
/// It may also call decode(), if reserve() was called for the value before.
///
///   static constexpr TypeInfo info;
///
///   /// Writes the value as CDR and returns the bytes written; 0 if `size` is too small for the sample, or
///   /// if a field exceeds its bound.
///   static std::uint32_t encode(const T& value, std::byte* to, std::uint32_t size) noexcept;
///
///   /// Returns true if encode() accepts the value, provided that `size` is large enough.
///   static bool fits(const T& value) noexcept;
///
///   /// Reads a sample in either byte order. Up to 3 bytes may follow it, because RTPS sends whole words.
///   /// Returns false if the bytes are no valid sample; the content of `value` is then unspecified.
///   static bool decode(const std::byte* from, std::uint32_t size, T& value) noexcept;
///
///   /// Reserves room for the largest possible sequences of the value. Allocates.
///   static void reserve(T& value);
template <class T>
struct PortType {
  static_assert(
      sizeof(T) == 0,
      "the types of ports come from IDL: put a struct into an IDL file, call takt_add_idl() for it in "
      "CMake, and include the generated .hpp file; basic.idl has structs for a single value, such as "
      "basic::Number for a double");

  // The compiler reports only the assertion, because these declarations prevent further errors.
  static constexpr TypeInfo info{"", R"({"fields":[]})", 0};
  static std::uint32_t encode(const T& value, std::byte* to, std::uint32_t size) noexcept;
  static bool fits(const T& value) noexcept;
  static bool decode(const std::byte* from, std::uint32_t size, T& value) noexcept;
  static void reserve(T& value);
  template <class Writer>
  static void put(Writer& to, const T& value) noexcept;
  template <class Reader>
  static void get(Reader& from, T& value);
};

}  // namespace takt
