// PortType: what a port must know about its type. takt_add_idl generates a specialisation for every struct of
// an IDL file:
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
  std::uint32_t max_size;   ///< most bytes of a sample as CDR: with encapsulation, a multiple of 4
};

/// Encodes and decodes values of T, a struct of an IDL file. All functions except reserve() are real-time.
/// decode() is real-time only if reserve() was called for the value.
///
///   static constexpr TypeInfo info;
///
///   /// Writes the value as CDR and returns the bytes written. 0 if `size` is too small for the sample, or
///   /// if a field exceeds its bound.
///   static std::uint32_t encode(const T& value, std::byte* to, std::uint32_t size) noexcept;
///
///   /// Whether encode() accepts the value if there is room.
///   static bool fits(const T& value) noexcept;
///
///   /// Reads a sample in either byte order. Up to 3 bytes may follow it, because RTPS sends whole words.
///   /// False if the bytes are not a valid sample; the content of `value` is then unspecified.
///   static bool decode(const std::byte* from, std::uint32_t size, T& value) noexcept;
///
///   /// Reserves room for the largest possible sequences of the value. Allocates.
///   static void reserve(T& value);
template <class T>
struct PortType;

}  // namespace takt
