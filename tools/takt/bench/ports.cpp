// takt bench ports: measures the transfer of a sample from one port to another.
#include <cstdlib>
#include <cstring>
#include <memory>

#include <takt/core/check.hpp>
#include <takt/os/shared_memory.hpp>
#include <takt/process.hpp>

#include <bench.hpp>

#include "bare_loop.hpp"
#include "benchmarks.hpp"
#include "timed.hpp"

namespace takt::bench {

namespace {

using Sample = ::bench::Sample64;

constexpr double kPortSeconds = 3;

/// A connection, with its writer and its reader.
class Pair {
 public:
  /// If `as_objects`, the samples are objects, as within a host. Otherwise they are bytes in shared memory,
  /// as between two processes.
  Pair(bool as_objects, std::uint32_t depth, bool safe = false) {
    const channel::Link::Options options{.depth = depth,
                                         .payload = as_objects ? 0 : PortType<Sample>::info.max_size,
                                         .is_queue = depth > 1,
                                         .deadline_ns = safe ? 1'000'000 : 0,
                                         .safe = safe ? PortType<Sample>::info.max_size : 0,
                                         .force = depth > 1 ? 0 : PortType<Sample>::info.max_size};
    memory_ = std::move(os::SharedMemory::create("takt-link", channel::Link::layout(options).size()).value());
    channel::Link::format(memory_.data(), options);
    const channel::Link link{memory_.data()};
    if (safe) give_safe(link);
    void* values = as_objects ? out_.make_values(link.buffers()) : nullptr;
    out_.serve(context_);
    in_.serve(context_);
    out_.connect(link, values);
    in_.connect(link, values);
  }

  void write() {
    ++sample_.sent_ns();
    out_.write(sample_);
  }
  void write_and_read() {
    write();
    TAKT_CHECK(in_.read() && in_.value().sent_ns() == sample_.sent_ns());
  }
  bool read() { return static_cast<bool>(in_.read()); }

 private:
  static void give_safe(const channel::Link& link) {
    std::vector<std::byte> bytes(PortType<Sample>::info.max_size);
    bytes.resize(PortType<Sample>::encode({}, bytes.data(), PortType<Sample>::info.max_size));
    link.give_safe(bytes);
    link.trust();
  }

  PortContext context_{.start_ns = 1};
  os::SharedMemory memory_;
  Sample sample_;
  OutPort<Sample> out_{"out"};
  InPort<Sample> in_{"in"};
};

/// The reference: copies a sample to a buffer and back with memcpy. The assembly statements stop the compiler
/// from removing the copies.
class Copy {
 public:
  void write_and_read() {
    ++sample_[0];
    std::memcpy(place_, sample_, sizeof sample_);
    asm volatile("" : : "r"(place_) : "memory");
    std::memcpy(read_, place_, sizeof read_);
    asm volatile("" : : "r"(read_) : "memory");
  }

 private:
  std::int64_t sample_[8]{};
  std::int64_t place_[8]{};
  std::int64_t read_[8]{};
};

}  // namespace

Result<std::vector<Section>> ports(const Settings& settings, Problems& refused) {
  Section section{.title = "transfer of a sample of 64 bytes between two ports, in one thread: ns",
                  .columns = {"ns", "of memcpy"}};
  Course{settings, 1}.next("all variants, alternately");
  const auto loop = run_at({.cpu = cpu_of(settings)}, [&] {
    Copy copy;
    Pair latest{true, 1};
    Pair queue{true, 8};
    Pair shared_latest{false, 1};
    Pair shared_queue{false, 8};
    Pair unread{true, 8};
    Pair shared_unread{false, 8};
    Pair no_news{true, 1};
    Pair safe{true, 1, true};
    Pair safe_no_news{true, 1, true};
    safe_no_news.write_and_read();
    Pair shared_safe{false, 1, true};
    const std::vector<std::pair<const char*, std::function<void()>>> steps{
        {"memcpy to a buffer and back", [&] { copy.write_and_read(); }},
        {"in a host, latest: write and read", [&] { latest.write_and_read(); }},
        {"in a host, latest, with a safe value", [&] { safe.write_and_read(); }},
        {"in a host, queue: write and read", [&] { queue.write_and_read(); }},
        {"in a host, queue: write to a full queue", [&] { unread.write(); }},
        {"in a host, latest: read without a new sample", [&] { TAKT_CHECK(!no_news.read()); }},
        {"in a host, latest: read without a new sample, with a safe value",
         [&] { TAKT_CHECK(!safe_no_news.read()); }},
        {"shared memory, latest: write and read", [&] { shared_latest.write_and_read(); }},
        {"shared memory, latest, with a safe value", [&] { shared_safe.write_and_read(); }},
        {"shared memory, queue: write and read", [&] { shared_queue.write_and_read(); }},
        {"shared memory, queue: write to a full queue", [&] { shared_unread.write(); }}};
    std::vector<std::function<void()>> functions;
    for (const auto& [name, step] : steps) functions.push_back(step);
    const std::vector<double> times = each_by_turns(settings.length(kPortSeconds), functions);
    for (std::size_t i = 0; i < steps.size(); ++i)
      section.rows.push_back({steps[i].first, {times[i], times[i] / times[0]}});
    return Loop{};
  });
  if (!loop) return loop.problems();
  add_once(refused, loop->refused);
  section.notes.emplace_back(
      "Between two processes, the sample must also move from the caches of one CPU to those of another.");
  return std::vector<Section>{std::move(section)};
}

}  // namespace takt::bench
