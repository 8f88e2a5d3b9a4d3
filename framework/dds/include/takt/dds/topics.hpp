// The typed topics on which nodes publish their state: Writer<T> and Reader<T> for T of idl/takt.idl, each
// with the QoS of its topic.
//
//   LifecycleStatus      takt/lifecycle    state
//   DeviceStatus         takt/device       state
//   ModuleStatistics     takt/statistics   measurement
//   ExecutorStatistics   takt/executor     measurement
//   PortStatus           takt/port         measurement
//   FaultEvent           takt/fault        event
//
// state: reliable, transient local, keep last 1, liveliness manual by topic with a lease of 300 ms
// measurement: best effort, volatile, keep last 1
// event: reliable, transient local, keep last 64
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>
#include <takt/wire/writer_id.hpp>

namespace takt::dds {

/// Publishes on the topic of T. Real-time threads must not use it. One thread at a time may call it.
template <class T>
class Writer {
 public:
  static Result<Writer> create(std::shared_ptr<Participant> participant);
  Writer(Writer&&) noexcept;
  Writer& operator=(Writer&&) noexcept;
  ~Writer();

  /// Returns false if Fast DDS rejects the sample, which failures() counts.
  bool write(const T& sample);
  /// Disposes of the sample with this key. Present readers are notified, and later readers do not get the
  /// sample.
  void dispose(const T& sample);
  /// Asserts that this writer is alive, for the topics of states. write() asserts it, too.
  void assert_liveliness();
  /// Waits until every reliable reader has acknowledged all written samples, at most for `limit`. A reader of
  /// Takt acknowledges within about 5 ms. Until then, a second sample of a key would overwrite the first.
  /// Returns false if the time is over.
  bool wait_acknowledged(std::chrono::milliseconds limit);
  [[nodiscard]] std::uint64_t failures() const noexcept;

 private:
  struct Inside;
  explicit Writer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// The callbacks of a reader. Threads of Fast DDS make one call at a time for each reader. A callback must be
/// quick, must not call DDS, and must not take a lock that another thread holds while it calls DDS.
template <class T>
struct Heard {
  std::function<void(const T&, wire::WriterId)> sample;
  /// The writer disposed of the sample with this key; other fields of the sample are not set.
  std::function<void(const T&, wire::WriterId)> disposed{};
  /// A live writer was lost, because its lease expired or it left. Called once for each loss.
  std::function<void(wire::WriterId)> lost{};
  /// A writer is alive. Called before the writer's first sample, and when a lost writer returns. Samples that
  /// it sent before are not repeated.
  std::function<void(wire::WriterId)> alive{};
};

template <class T>
class Reader {
 public:
  static Result<Reader> create(std::shared_ptr<Participant> participant, Heard<T> heard);
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();
  /// The number of writers that currently match this reader.
  [[nodiscard]] int matched() const noexcept;
  /// The number of samples that were invalid and therefore dropped.
  [[nodiscard]] std::uint64_t refused() const noexcept;

 private:
  struct Inside;
  explicit Reader(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
