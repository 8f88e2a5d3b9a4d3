// The topics on which nodes say what goes on, typed: Writer<T> and Reader<T> for T of idl/takt.idl, each with
// the QoS of its topic.
//
//   T                          topic             QoS
//   takt::LifecycleStatus      takt/lifecycle    reliable, transient local, keep last 1, liveliness manual by
//   topic takt::DeviceStatus         takt/device       the same, lease 300 ms takt::ModuleStatistics
//   takt/statistics   best effort, keep last 1 takt::ExecutorStatistics   takt/executor     best effort, keep
//   last 1 takt::PortStatus           takt/port         best effort, keep last 1
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>

namespace takt::dds {

/// Tells one writer on the network from another, for as long as this process lives.
using WriterId = std::uint64_t;

/// None of these from a real-time thread; one thread at a time.
template <class T>
class Writer {
 public:
  static Result<Writer> create(std::shared_ptr<Participant> participant);
  Writer(Writer&&) noexcept;
  Writer& operator=(Writer&&) noexcept;
  ~Writer();

  /// False when Fast DDS did not take it; counted in failures().
  bool write(const T& sample);
  /// Nobody who joins later gets the sample with this key any more; who has it is told that it is gone.
  void dispose(const T& sample);
  /// Where the topic has a liveliness: this writer lives. write() says so too.
  void assert_liveliness();
  /// Waits until every reliable reader has everything that was written, at most this long.
  bool wait_acknowledged(std::chrono::milliseconds limit);
  [[nodiscard]] std::uint64_t failures() const noexcept;

 private:
  struct Inside;
  explicit Writer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// What a reader is told, on a thread of Fast DDS, one call at a time for each reader. Not to take long, and
/// not to create or delete anything of DDS.
template <class T>
struct Heard {
  std::function<void(const T&, WriterId)> sample;
  /// The key of this sample was disposed; other fields are not set.
  std::function<void(const T&, WriterId)> disposed{};
  /// The writer is not alive any more: its lease ran out, or it left.
  std::function<void(WriterId)> lost{};
  /// A writer is alive: the first time, and after it was lost. What it wrote before is not told again.
  std::function<void(WriterId)> alive{};
};

template <class T>
class Reader {
 public:
  static Result<Reader> create(std::shared_ptr<Participant> participant, Heard<T> heard);
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();
  /// Writers that match at present.
  [[nodiscard]] int matched() const noexcept;

 private:
  struct Inside;
  explicit Reader(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
