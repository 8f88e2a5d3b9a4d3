// Decodes arbitrary bytes as a sample of a port. Three decoders must agree on whether the sample is valid:
// the decoder of C++ components, the decoder of C components, and the decoder that knows only the description
// of the type (dds/raw.cpp). Decoding a valid sample and encoding it again must not change its values.
//
// The first byte of an input selects the type.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/check.hpp>
#include <takt/model/type.hpp>

#include <everything_c.h>
#include <parts_c.h>
#include <everything.hpp>
#include <parts.hpp>

namespace {

using Sample = std::vector<std::byte>;

/// Number of bytes in the output buffer beyond the maximum size of a sample.
constexpr std::size_t kGuard = 16;

template <class T>
void check(const takt_type& in_c, const std::byte* bytes, std::size_t size) {
  using Port = takt::PortType<T>;
  static const takt::model::Type type = takt::model::parse_type(Port::info.description).value();
  const auto length = static_cast<std::uint32_t>(size);

  T value;
  Port::reserve(value);
  std::vector<unsigned char> plain(in_c.value_size);
  const bool is_sample = takt::model::is_sample(type, bytes, size);
  TAKT_CHECK(Port::decode(bytes, length, value) == is_sample);
  TAKT_CHECK((in_c.decode(reinterpret_cast<const unsigned char*>(bytes), length, plain.data()) != 0) ==
             is_sample);
  if (!is_sample) return;

  TAKT_CHECK(size <= Port::info.max_size + std::size_t{3});
  Sample again(Port::info.max_size + kGuard, std::byte{0xA5});
  const std::uint32_t written = Port::encode(value, again.data(), Port::info.max_size);
  TAKT_CHECK(written != 0 && written <= Port::info.max_size);
  Sample from_c(Port::info.max_size);
  TAKT_CHECK(in_c.encode(plain.data(), reinterpret_cast<unsigned char*>(from_c.data()),
                         Port::info.max_size) == written);
  from_c.resize(written);
  again.resize(written);
  TAKT_CHECK(again == from_c);
  TAKT_CHECK(takt::model::is_sample(type, again.data(), again.size()));
  TAKT_CHECK(takt::model::sample_json(type, bytes, size) ==
             takt::model::sample_json(type, again.data(), again.size()));
  TAKT_CHECK(Port::encode(value, again.data(), written - 1) == 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  // The buffer has exactly the size of the sample, so that AddressSanitizer detects reading beyond its end.
  const Sample sample(reinterpret_cast<const std::byte*>(data) + 1,
                      reinterpret_cast<const std::byte*>(data) + size);
  switch (data[0]) {
    case 's':
      check<everything::Scalars>(everything_Scalars_type, sample.data(), sample.size());
      break;
    case 'w':
      check<everything::Whole>(everything_Whole_type, sample.data(), sample.size());
      break;
    case 'p':
      check<parts::Part>(parts_Part_type, sample.data(), sample.size());
      break;
    case 't':
      check<everything::Tail>(everything_Tail_type, sample.data(), sample.size());
      break;
    default:
      break;
  }
  return 0;
}
