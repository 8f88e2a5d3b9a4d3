// The topics on which nodes say what goes on, typed: Writer<T> and Reader<T> for T of idl/takt.idl, each with
// the QoS of its topic.
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
  /// Waits until every reliable reader has everything that was written, at most this long. A reader of Takt
  /// says so after 5 ms. Until then a second sample of a key would overwrite the first.
  bool wait_acknowledged(std::chrono::milliseconds limit);
  [[nodiscard]] std::uint64_t failures() const noexcept;

 private:
  struct Inside;
  explicit Writer(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

/// What a reader is told, on a thread of Fast DDS, one call at a time for each reader. Not to take long, not
/// to call anything of DDS, and to take no lock that somebody holds while calling DDS.
template <class T>
struct Heard {
  std::function<void(const T&, WriterId)> sample;
  /// The key of this sample was disposed; other fields are not set.
  std::function<void(const T&, WriterId)> disposed{};
  /// A writer that was alive is not any more: its lease ran out, or it left. Told once.
  std::function<void(WriterId)> lost{};
  /// A writer is alive: before its first sample, and when it is back. What it wrote before is not told again.
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
  /// What came and was no sample, or made no sense, and was not told.
  [[nodiscard]] std::uint64_t refused() const noexcept;

 private:
  struct Inside;
  explicit Reader(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::dds
