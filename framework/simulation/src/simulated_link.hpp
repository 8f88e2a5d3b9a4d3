// The samples and links of simulated modules. The bytes of a sample show a reader which sample it is, and
// whether all its bytes belong together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include <takt/channel/link.hpp>
#include <takt/model/cell.hpp>

namespace takt::simulation {

inline constexpr std::uint32_t kSampleBytes = 64;

/// A sample is written in two halves, so that a test detects a reader or writer that uses the buffer in
/// between.
void write_first_half(std::byte* sample, std::uint32_t connection, std::uint64_t number) noexcept;
void write_second_half(std::byte* sample, std::uint32_t connection, std::uint64_t number) noexcept;
std::uint64_t number_of(const std::byte* sample) noexcept;
bool is_whole(const std::byte* sample, std::uint32_t connection) noexcept;

/// A connection's link on one device.
class SimulatedLink {
 public:
  /// The owner of an end: the index of a module of the device; empty for the gateway.
  using End = std::optional<std::uint32_t>;

  /// `index` is that of the connection in its descriptor; `number` is that of ConnectionNumbers.
  SimulatedLink(const model::Connection& connection, std::uint32_t index, std::uint32_t number, End writer,
                End reader, channel::Link link)
      : model_(&connection),
        connection_(index),
        number_(number),
        writer_(writer),
        reader_(reader),
        link_(link) {}

  [[nodiscard]] const model::Connection& model() const noexcept { return *model_; }
  [[nodiscard]] std::uint32_t connection() const noexcept { return connection_; }
  [[nodiscard]] std::uint32_t number() const noexcept { return number_; }
  [[nodiscard]] End writer() const noexcept { return writer_; }
  [[nodiscard]] End reader() const noexcept { return reader_; }
  [[nodiscard]] channel::Link link() const noexcept { return link_; }

  /// Drops the samples in the link. Used for a link within the shared host, whose samples are lost when the
  /// host ends.
  void drop();
  /// True if every written sample was taken, overwritten or dropped, or is still in the link.
  [[nodiscard]] bool adds_up() const noexcept;

 private:
  [[nodiscard]] std::uint64_t full() const noexcept;

  const model::Connection* model_;
  std::uint32_t connection_;
  std::uint32_t number_;
  End writer_;
  End reader_;
  channel::Link link_;
  std::uint64_t dropped_ = 0;
};

}  // namespace takt::simulation
