// What a port must know of its type. takt_add_idl generates a specialisation for every struct of an IDL file:
//
//   takt_add_idl(types motion.idl)      in CMake
//   #include <motion.hpp>               the struct motion::JointState and its PortType
#pragma once

#include <cstddef>
#include <cstdint>

namespace takt {

/// Static storage, the same in every object that was compiled from the same IDL.
struct TypeInfo {
  const char* name;         ///< "motion::JointState", its name on DDS
  const char* description;  ///< JSON, as model::parse_type() reads it; two types are one when this is equal
  std::uint32_t max_size;   ///< most bytes of a sample as CDR: with encapsulation, in whole words of 4 bytes
};

/// For T of an IDL file. All but reserve() are real-time; decode() for a value that was reserved.
///
///   static constexpr TypeInfo info;
///
///   /// Bytes written; 0 when `size` is less than the sample needs, or a field is beyond its bound.
///   static std::uint32_t encode(const T& value, std::byte* to, std::uint32_t size) noexcept;
///
///   /// Whether encode() would take it, given room.
///   static bool fits(const T& value) noexcept;
///
///   /// False when the bytes are no sample, and what the value then holds is not said. Either byte order; up
///   /// to 3 bytes may follow, for RTPS sends whole words.
///   static bool decode(const std::byte* from, std::uint32_t size, T& value) noexcept;
///
///   /// Gives its sequences the room that they may need. Allocates.
///   static void reserve(T& value);
template <class T>
struct PortType;

}  // namespace takt
