// The typed topics on which nodes publish their state: Writer<T> and Reader<T> for T of idl/takt.idl, each
// with the QoS of its topic.
//
//   LifecycleStatus      takt/lifecycle    a state: reliable, transient local, keep last 1, liveliness manual
//                                          by topic with a lease of 300 ms
//   DeviceStatus         takt/device       a state
//   ModuleStatistics     takt/statistics   best effort, volatile, keep last 1
//   ExecutorStatistics   takt/executor     the same
//   PortStatus           takt/port         the same
//   FaultEvent           takt/fault        an event: reliable, transient local, keep last 64
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

/// Not for real-time threads; one thread at a time.
template <class T>
class Writer {
 public:
  static Result<Writer> create(std::shared_ptr<Participant> participant);
  Writer(Writer&&) noexcept;
  Writer& operator=(Writer&&) noexcept;
  ~Writer();

  /// Returns false if Fast DDS rejects the sample, which failures() counts.
  bool write(const T& sample);
  /// Disposes of the sample with this key: present readers are notified, and later readers do not get it.
  void dispose(const T& sample);
  /// Asserts that this writer is alive, on topics with a liveliness; write() does so too.
  void assert_liveliness();
  /// Waits at most this long until every reliable reader has everything that was written. A reader of Takt
  /// acknowledges after 5 ms. Until then a second sample of a key would overwrite the first.
  bool wait_acknowledged(std::chrono::milliseconds limit);
  [[nodiscard]] std::uint64_t failures() const noexcept;

 private:
  struct Inside;
  explicit Writer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// The callbacks of a reader. A thread of Fast DDS makes one call at a time for each reader. They must be
/// quick, must not call DDS, and must not take a lock that another thread holds while it calls DDS.
template <class T>
struct Heard {
  std::function<void(const T&, wire::WriterId)> sample;
  /// The key of this sample was disposed; other fields are not set.
  std::function<void(const T&, wire::WriterId)> disposed{};
  /// A live writer is lost: its lease expired, or it left. Called once.
  std::function<void(wire::WriterId)> lost{};
  /// A writer is alive: called before its first sample, and when it returns. Its earlier samples are not
  /// repeated.
  std::function<void(wire::WriterId)> alive{};
};

template <class T>
class Reader {
 public:
  static Result<Reader> create(std::shared_ptr<Participant> participant, Heard<T> heard);
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();
  /// The number of writers that match at present.
  [[nodiscard]] int matched() const noexcept;
  /// The number of samples that were invalid and therefore dropped.
  [[nodiscard]] std::uint64_t refused() const noexcept;

 private:
  struct Inside;
  explicit Reader(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
