// The typed topics on which nodes publish their state. T is one of the types below, from idl/takt.idl.
// Writer<T> and Reader<T> use the QoS that is listed below for the kind of topic.
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

/// Publishes on the topic of T. Not for real-time threads. Only one thread at a time may use a writer.
template <class T>
class Writer {
 public:
  static Result<Writer> create(std::shared_ptr<Participant> participant);
  Writer(Writer&&) noexcept;
  Writer& operator=(Writer&&) noexcept;
  ~Writer();

  /// Writes a sample. Returns false if Fast DDS rejects the sample; failures() counts such samples.
  bool write(const T& sample);
  /// Disposes of the sample with this key. DDS notifies the present readers, and does not send the sample to
  /// readers that join later.
  void dispose(const T& sample);
  /// Asserts to the readers that this writer is alive, as each write() also does. Only the topics of kind
  /// state need this.
  void assert_liveliness();
  /// Waits until every reliable reader has acknowledged all written samples, but at most for `limit`. A
  /// reader of Takt acknowledges within about 5 ms. Call this function between two samples of one key.
  /// Otherwise the second sample would overwrite the first one before all readers have received the first
  /// one. Returns false if `limit` has passed.
  bool wait_acknowledged(std::chrono::milliseconds limit);
  [[nodiscard]] std::uint64_t failures() const noexcept;

 private:
  struct Inside;
  explicit Writer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// The callbacks of a reader. Threads of Fast DDS call them, but for each reader never two at the same time.
/// A callback must return quickly, must not call DDS, and must not take a lock that another thread holds
/// while this other thread calls DDS.
template <class T>
struct Callbacks {
  std::function<void(const T&, wire::WriterId)> sample;
  /// Called when the writer has disposed of the sample with this key. Only the key fields are set.
  std::function<void(const T&, wire::WriterId)> disposed{};
  /// Called once when a live writer is lost, because its lease has expired or it has left.
  std::function<void(wire::WriterId)> lost{};
  /// Called before the first sample of a writer, and when a lost writer is alive again. The samples that the
  /// writer sent before its loss are not delivered again.
  std::function<void(wire::WriterId)> alive{};
};

template <class T>
class Reader {
 public:
  static Result<Reader> create(std::shared_ptr<Participant> participant, Callbacks<T> callbacks);
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();
  /// Returns the number of writers that currently match this reader.
  [[nodiscard]] int matched() const noexcept;
  /// Returns the number of samples that this reader has dropped because they were invalid.
  [[nodiscard]] std::uint64_t refused() const noexcept;

 private:
  struct Inside;
  explicit Reader(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
