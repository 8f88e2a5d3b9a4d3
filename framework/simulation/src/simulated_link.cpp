#include "simulated_link.hpp"

#include <cstring>

namespace takt::simulation {

namespace {

constexpr std::size_t kSampleWords = kSampleBytes / sizeof(std::uint64_t);

// Returns the word at `place` in a sample. Word 0 is the sample's number, and word 1 is its connection. The
// other words are unique for the sample and the place.
std::uint64_t word(std::uint32_t connection, std::uint64_t number, std::size_t place) noexcept {
  if (place == 0) return number;
  if (place == 1) return connection;
  std::uint64_t mixed = (number * 0x9e37'79b9'7f4a'7c15U) ^ (connection + (std::uint64_t{place} << 32));
  mixed = (mixed ^ (mixed >> 29)) * 0xbf58'476d'1ce4'e5b9U;
  return mixed ^ (mixed >> 32);
}

void write(std::byte* sample, std::uint32_t connection, std::uint64_t number, std::size_t from,
           std::size_t to) noexcept {
  for (std::size_t i = from; i < to; ++i) {
    const std::uint64_t value = word(connection, number, i);
    std::memcpy(sample + i * sizeof value, &value, sizeof value);
  }
}

}  // namespace

void write_first_half(std::byte* sample, std::uint32_t connection, std::uint64_t number) noexcept {
  write(sample, connection, number, 0, kSampleWords / 2);
}

void write_second_half(std::byte* sample, std::uint32_t connection, std::uint64_t number) noexcept {
  write(sample, connection, number, kSampleWords / 2, kSampleWords);
}

std::uint64_t number_of(const std::byte* sample) noexcept {
  std::uint64_t number = 0;
  std::memcpy(&number, sample, sizeof number);
  return number;
}

bool is_whole(const std::byte* sample, std::uint32_t connection) noexcept {
  const std::uint64_t number = number_of(sample);
  for (std::size_t i = 1; i < kSampleWords; ++i) {
    std::uint64_t value = 0;
    std::memcpy(&value, sample + i * sizeof value, sizeof value);
    if (value != word(connection, number, i)) return false;
  }
  return true;
}

std::uint64_t SimulatedLink::full() const noexcept {
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < link_.depth(); ++i)
    count += channel::SlotWord::full(link_.slot(i).load()) ? 1 : 0;
  return count;
}

void SimulatedLink::drop() {
  dropped_ += full();
  channel::drop_samples(link_);
}

bool SimulatedLink::adds_up() const noexcept {
  const channel::LinkBlock& block = link_.block();
  return block.written.load() == block.taken.load() + block.overwritten.load() + dropped_ + full();
}

}  // namespace takt::simulation
