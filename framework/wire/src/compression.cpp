#include <takt/wire/compression.hpp>

#include <cstddef>

#include <zlib.h>

#include <takt/core/check.hpp>
#include <takt/wire/assembly.hpp>

namespace takt::wire {

namespace {

constexpr char kFirst = 'x';
constexpr std::size_t kFirstGuess = 64UL * 1024;

}  // namespace

std::string packed(std::string data) {
  if (data.size() <= kPart && !data.starts_with(kFirst)) return data;
  uLongf size = compressBound(data.size());
  std::string result(size, '\0');
  const int done = compress(reinterpret_cast<Bytef*>(result.data()), &size,
                            reinterpret_cast<const Bytef*>(data.data()), data.size());
  TAKT_CHECK(done == Z_OK && result[0] == kFirst);
  if (size >= data.size() && !data.starts_with(kFirst)) return data;
  result.resize(size);
  return result;
}

std::optional<std::string> unpacked(std::string data) {
  if (!data.starts_with(kFirst)) return data;
  std::string result;
  for (std::size_t room = kFirstGuess; room <= kMaxData; room *= 4) {
    result.resize(room);
    uLongf size = room;
    const int done = uncompress(reinterpret_cast<Bytef*>(result.data()), &size,
                                reinterpret_cast<const Bytef*>(data.data()), data.size());
    if (done == Z_BUF_ERROR && size == room) continue;
    if (done != Z_OK) return std::nullopt;
    result.resize(size);
    return result;
  }
  return std::nullopt;
}

}  // namespace takt::wire
