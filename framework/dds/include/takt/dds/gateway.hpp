// Moves samples between the links of a device and DDS. Bytes only: what a component wrote as CDR goes out as
// it is, and what comes in is held against the type's description before it reaches a link.
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

namespace takt::dds {

struct Quality {
  bool reliable = false;
  std::uint32_t depth = 1;
  std::optional<Nanoseconds> deadline;
  std::optional<Nanoseconds> lifespan;
  /// What was written last, `depth` of it, also comes to who is found later.
  bool kept = false;
};

struct Flow {
  std::string topic;  ///< takt/<cell>/<device>/<module>/<port>, or a name of its own
  model::Type type;
  Quality quality;
};

/// What an operator wants to know of one flow.
struct FlowHealth {
  std::uint32_t matched = 0;
  std::uint64_t samples = 0;   ///< moved
  std::uint64_t lost = 0;      ///< told by DDS, or by a gap in the writer's numbers
  std::uint64_t refused = 0;   ///< bytes that are no sample of the type
  std::uint64_t failures = 0;  ///< writes that DDS did not take
  std::string incompatible;    ///< the policy that kept somebody from matching: "reliability"; empty: none
};

/// Outgoing: one thread (not real-time) sleeps on the wake_word, reads the links, writes to DDS. Incoming:
/// the receive thread of Fast DDS writes to the links and rings for whom they wake.
class Gateway {
 public:
  using FlowId = std::size_t;

  /// `place`: its own among the gateways that share the wake_word, 0 to 31.
  static Result<std::unique_ptr<Gateway>> create(std::shared_ptr<Participant> participant,
                                                 channel::WakeWord& wake_word, std::uint32_t place = 0);
  virtual ~Gateway() = default;

  /// The gateway becomes the reader of `from`.
  virtual Result<FlowId> add_outgoing(const Flow& flow, channel::Link from) = 0;
  /// The gateway becomes the writer of all of `to`.
  virtual Result<FlowId> add_incoming(const Flow& flow, std::vector<channel::Link> to) = 0;
  /// Afterwards nobody touches the memory of its links. Others are not disturbed.
  virtual void remove(FlowId flow) = 0;
  /// All 0 for one that was removed.
  [[nodiscard]] virtual FlowHealth health(FlowId flow) const = 0;

 protected:
  Gateway() = default;
};

/// Reads one topic without a device: `takt echo`. `sample` is called on a thread of Fast DDS with the bytes
/// and the writer's time (ns since 1970).
class Tap {
 public:
  static Result<std::unique_ptr<Tap>> create(
      std::shared_ptr<Participant> participant, const Flow& flow,
      std::function<void(const std::byte* bytes, std::size_t size, std::int64_t time_ns)> sample);
  virtual ~Tap() = default;
  [[nodiscard]] virtual FlowHealth health() const = 0;

 protected:
  Tap() = default;
};

/// Writes one topic without a device, for a program that gives a cell what no module gives it.
class Feed {
 public:
  static Result<std::unique_ptr<Feed>> create(std::shared_ptr<Participant> participant, const Flow& flow);
  virtual ~Feed() = default;
  /// Bytes of a sample, with the time of its value (ns since 1970; 0: now). False when DDS did not take them.
  virtual bool write(const std::byte* bytes, std::size_t size, std::int64_t time_ns = 0) = 0;
  [[nodiscard]] virtual FlowHealth health() const = 0;

 protected:
  Feed() = default;
};

}  // namespace takt::dds
