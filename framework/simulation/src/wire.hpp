// The samples that simulated modules send each other: numbers from which a reader can tell which sample it
// is, and that all of its bytes belong together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include <takt/channel/link.hpp>
#include <takt/model/cell.hpp>

namespace takt::simulation {

inline constexpr std::uint32_t kSampleBytes = 64;

/// A sample is written in two halves, so that somebody who has its buffer at the same time is found out.
void write_first_half(std::byte* sample, std::uint32_t connection, std::uint64_t number) noexcept;
void write_second_half(std::byte* sample, std::uint32_t connection, std::uint64_t number) noexcept;
std::uint64_t number_of(const std::byte* sample) noexcept;
bool is_whole(const std::byte* sample, std::uint32_t connection) noexcept;

/// A connection's link on one device.
class Wire {
 public:
  /// Whose end it is: a module of the device, or the gateway.
  using End = std::optional<std::uint32_t>;

  /// `ahead`: places beside those that the connection has, see schedule::samples_ahead().
  Wire(const model::Connection& connection, std::uint32_t index, End writer, End reader,
       std::uint32_t wake_bits, std::uint64_t ahead);

  [[nodiscard]] const model::Connection& model() const noexcept { return *model_; }
  [[nodiscard]] std::uint32_t connection() const noexcept { return connection_; }
  [[nodiscard]] End writer() const noexcept { return writer_; }
  [[nodiscard]] End reader() const noexcept { return reader_; }
  [[nodiscard]] channel::Link link() const noexcept { return link_; }

  /// As the samples of two modules of a host that has ended: gone.
  void drop();
  /// Whether every sample that was written was taken, overwritten or dropped, or is there still.
  [[nodiscard]] bool adds_up() const noexcept;

 private:
  [[nodiscard]] std::uint64_t full() const noexcept;

  struct alignas(64) Line {
    std::byte bytes[64];
  };
  const model::Connection* model_;
  std::uint32_t connection_;
  End writer_;
  End reader_;
  std::unique_ptr<Line[]> memory_;
  channel::Link link_;
  std::uint64_t dropped_ = 0;
};

}  // namespace takt::simulation
