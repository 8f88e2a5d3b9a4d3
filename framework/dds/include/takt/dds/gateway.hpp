// Moves samples between the links of a device and DDS, as bytes. Outgoing samples are the CDR bytes that a
// component wrote, unchanged. The gateway checks incoming bytes against the description of their type before
// it writes them to a link.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/type.hpp>
#include <takt/wire/flow_health.hpp>

namespace takt::dds {

struct Quality {
  bool reliable = false;
  std::uint32_t depth = 1;
  std::optional<Nanoseconds> deadline;
  std::optional<Nanoseconds> lifespan;
  /// True if readers that join later get the last `depth` samples.
  bool kept = false;
};

struct Flow {
  std::string topic;  ///< takt/<cell>/<device>/<module>/<port>, or a name from the descriptor
  model::Type type;
  Quality quality;
};

/// Moves the samples of all flows that are added to it. For outgoing samples, one thread that is not
/// real-time sleeps on the wake word, reads the links and writes to DDS. For incoming samples, the receive
/// threads of Fast DDS write to the links and wake the readers through the wake word.
class Gateway {
 public:
  using FlowId = std::size_t;  ///< not 0

  /// Creates a gateway. `place` is the number of its bit in WakeWord::gateway_sleeps, from 0 to 31. Gateways
  /// that share a wake word need different places.
  static Result<std::unique_ptr<Gateway>> create(std::shared_ptr<Participant> participant,
                                                 channel::WakeWord& wake_word, std::uint32_t place = 0);
  virtual ~Gateway() = default;

  /// Adds a flow from a link to DDS. The gateway becomes the reader of `from`.
  virtual Result<FlowId> add_outgoing(const Flow& flow, channel::Link from) = 0;
  /// Makes an outgoing flow carry only the newest sample, once in `every`, or every sample (0). If all outgoing
  /// flows carry only newest samples, writers do not wake the gateway, which looks for samples by itself.
  /// Does not wait for a write to DDS.
  virtual void thin_out(FlowId flow, Nanoseconds every) = 0;
  /// Adds a flow from DDS to links. The gateway becomes the writer of all links in `to`.
  virtual Result<FlowId> add_incoming(const Flow& flow, std::vector<channel::Link> to) = 0;
  /// Removes a flow. Waits until the sample of the flow that is being written to or read from DDS is
  /// finished. When remove() has returned, the gateway no longer accesses the memory of the flow's links.
  /// Other flows continue.
  virtual void remove(FlowId flow) = 0;
  /// Returns the counters of a flow; all are 0 if the flow was removed. Does not wait for a write to DDS.
  [[nodiscard]] virtual wire::FlowHealth health(FlowId flow) const = 0;

 protected:
  Gateway() = default;
};

/// Reads the samples of one topic in a program that is not a device, such as `takt echo`. A thread of Fast
/// DDS calls `sample` with the bytes and the source time of each sample, in ns since 1970. It first calls
/// `lost` if samples before this one are missing: lost on the way, rejected, or not sent by their device.
class Tap {
 public:
  static Result<std::unique_ptr<Tap>> create(
      std::shared_ptr<Participant> participant, const Flow& flow,
      std::function<void(const std::byte* bytes, std::size_t size, std::int64_t time_ns)> sample,
      std::function<void(std::uint64_t count)> lost = nullptr);
  virtual ~Tap() = default;
  [[nodiscard]] virtual wire::FlowHealth health() const = 0;

 protected:
  Tap() = default;
};

/// Writes samples of one topic in a program that is not a device, to send them into a cell.
class Feed {
 public:
  static Result<std::unique_ptr<Feed>> create(std::shared_ptr<Participant> participant, const Flow& flow);
  virtual ~Feed() = default;
  /// Writes the bytes of a sample with the source time `time_ns`, in ns since 1970; 0 means now. Returns
  /// false if DDS rejects the sample.
  virtual bool write(const std::byte* bytes, std::size_t size, std::int64_t time_ns = 0) = 0;
  [[nodiscard]] virtual wire::FlowHealth health() const = 0;

 protected:
  Feed() = default;
};

}  // namespace takt::dds
