// Measures the latency from a module on one device to a module on another device: through link, gateway, DDS,
// gateway and link. For comparison, the benchmark alternately measures the same Fast DDS entities without
// Takt. Uses two processes on the loopback interface. Prints the results and asserts nothing.
//
//   dds_bench [ROUND TRIPS PER TURN]
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/platform.hpp>
#include "raw.hpp"

extern char** environ;

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kBytes = 4 + 64;
constexpr std::uint32_t kPingBit = channel::wake_bit(0);
constexpr int kTurns = 5;

model::Type ping_type() {
  return {.name = "bench::Ping",
          .fields = {{.name = "number", .scalar = model::Scalar::uint64},
                     {.name = "data", .scalar = model::Scalar::octet, .dimensions = {56}}}};
}

dds::Flow flow(const std::string& topic, bool reliable) {
  return {.topic = topic,
          .type = ping_type(),
          .quality = {.reliable = reliable, .depth = 8, .deadline = {}, .lifespan = {}}};
}

std::array<std::byte, kBytes> ping(std::uint64_t number) {
  std::array<std::byte, kBytes> bytes{};
  bytes[1] = std::byte{1};
  std::memcpy(bytes.data() + 4, &number, 8);
  return bytes;
}

std::uint64_t number_in(const std::byte* bytes) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes + 4, 8);
  return number;
}

class Memory {
 public:
  explicit Memory(const channel::Link::Options& options)
      : bytes_(static_cast<std::byte*>(
            ::operator new (channel::Link::layout(options).size(), std::align_val_t{64}))) {
    std::memset(bytes_, 0, channel::Link::layout(options).size());
    channel::Link::format(bytes_, options);
  }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() { ::operator delete (bytes_, std::align_val_t{64}); }
  [[nodiscard]] channel::Link link() const { return channel::Link{bytes_}; }

 private:
  std::byte* bytes_;
};

channel::Link::Options queue(std::uint32_t wake_bits) {
  return {.depth = 8, .payload = kBytes, .is_queue = true, .wake_bits = wake_bits};
}

void ring(channel::WakeWord& wake_word, std::uint32_t bits) {
  wake_word.rings.fetch_add(1, std::memory_order_seq_cst);
  os::futex_wake(wake_word.rings, bits);
}

/// Writes a sample as a module does, and then wakes the readers as the executor does at the end of a cycle.
void write(channel::LinkWriter& writer, channel::WakeWord& wake_word, const std::byte* bytes) {
  std::memcpy(writer.link().payload(writer.buffer()), bytes, kBytes);
  writer.publish(kBytes, to_ns(os::now()));
  wake_word.note(writer.link().block().wake_bits);
  if (const std::uint32_t bits = wake_word.take_pending(); bits != 0) ring(wake_word, bits);
}

/// A writer and a reader of Fast DDS with the QoS of a Takt flow, but without any other part of Takt.
class Bare final : dds::fast::DataReaderListener, dds::Taker {
 public:
  Bare(const std::shared_ptr<dds::Participant>& participant, const std::string& out, const std::string& in,
       bool reliable, std::function<void(Bare&, const std::byte*)> heard)
      : participant_(participant), heard_(std::move(heard)) {
    dds::OwnParticipant& mine = dds::own(*participant_);
    const dds::fast::TypeSupport type{
        new dds::RawType{flow(out, reliable).type.name, model::max_size(ping_type())}};
    out_ = *mine.topic(out, type);
    in_ = *mine.topic(in, type);
    dds::fast::DataWriterQos writer;
    set(writer, reliable);
    writer.endpoint().history_memory_policy = dds::rtps::PREALLOCATED_MEMORY_MODE;
    writer.publish_mode().kind = dds::fast::SYNCHRONOUS_PUBLISH_MODE;
    dds::set_times(writer, 10ms);
    writer_ = mine.make_writer(out_, writer, nullptr, dds::fast::StatusMask::none());
    dds::fast::DataReaderQos reader;
    set(reader, reliable);
    reader.endpoint().history_memory_policy = dds::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    dds::set_times(reader, 1ms);
    reader_ =
        mine.make_reader(in_, reader, this, dds::fast::StatusMask::data_available(), dds::Receives::alone);
  }
  ~Bare() override {
    dds::OwnParticipant& mine = dds::own(*participant_);
    mine.end(reader_);
    mine.end(writer_);
    mine.release(in_);
    mine.release(out_);
  }
  void write(const std::byte* bytes) {
    dds::Bytes sample{bytes, kBytes};
    dds::write_sample(*writer_, &sample);
  }

 private:
  template <class Qos>
  static void set(Qos& qos, bool reliable) {
    qos.reliability().kind =
        reliable ? dds::fast::RELIABLE_RELIABILITY_QOS : dds::fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = dds::fast::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::fast::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 8;
    qos.resource_limits().max_instances = 1;
    qos.resource_limits().max_samples = 8;
    qos.resource_limits().max_samples_per_instance = 8;
    qos.resource_limits().allocated_samples = 8;
    qos.data_sharing().off();
  }
  void take(const dds::Bytes& bytes) override { std::memcpy(bytes_.data(), bytes.data, kBytes); }
  void on_data_available(dds::fast::DataReader* from) override {
    dds::fast::SampleInfo info;
    while (dds::take_sample(*from, static_cast<dds::Taker*>(this), info)) heard_(*this, bytes_.data());
  }

  std::shared_ptr<dds::Participant> participant_;
  std::function<void(Bare&, const std::byte*)> heard_;
  dds::fast::Topic* out_ = nullptr;
  dds::fast::Topic* in_ = nullptr;
  dds::fast::DataWriter* writer_ = nullptr;
  dds::fast::DataReader* reader_ = nullptr;
  std::array<std::byte, kBytes> bytes_{};
};

/// Passes samples from the receive thread of Fast DDS to a sleeping thread, as applications do.
class Handover {
 public:
  void give(const std::byte* bytes) {
    std::memcpy(bytes_.data(), bytes, kBytes);
    count_.fetch_add(1);
    os::futex_wake(count_, ~0U);
  }
  /// Waits for the next sample. Returns false if none arrives within a second.
  bool take(std::uint32_t& seen) {
    const Instant end = os::now() + 1s;
    while (count_.load() == seen) {
      if (os::now() > end) return false;
      os::futex_wait(count_, seen, ~0U, end);
    }
    ++seen;
    return true;
  }
  [[nodiscard]] const std::byte* bytes() const { return bytes_.data(); }

 private:
  std::array<std::byte, kBytes> bytes_{};
  std::atomic<std::uint32_t> count_{0};
};

// ---- The second process, which sends every sample back

struct Way {
  const char* name;
  bool reliable;
  bool bare;
  bool thread;  // true: a thread at each end waits for the sample; false: the callback of DDS handles it
};
constexpr std::array<Way, 8> kWays{{{"bare/listener", false, true, false},
                                    {"gateway/links", false, false, false},
                                    {"bare/thread", false, true, true},
                                    {"gateway/thread", false, false, true},
                                    {"bare/listener/reliable", true, true, false},
                                    {"gateway/links/reliable", true, false, false},
                                    {"bare/thread/reliable", true, true, true},
                                    {"gateway/thread/reliable", true, false, true}}};

std::string there(const Way& way) { return std::string{"there/"} + way.name; }
std::string back(const Way& way) { return std::string{"back/"} + way.name; }

Result<std::shared_ptr<dds::Participant>> participate(const char* name) {
  const char* domain = std::getenv("TAKT_TEST_DOMAIN");
  return dds::Participant::create({.name = name,
                                   .domain = domain == nullptr ? 148 : std::atoi(domain),
                                   .discovery = {},
                                   .interfaces = {"127.0.0.1"}});
}

int echo() {
  auto participant = participate("echo");
  if (!participant) return 1;
  channel::WakeWord wake_word{};
  auto gateway = dds::Gateway::create(*participant, wake_word);
  if (!gateway) return 1;
  std::vector<std::unique_ptr<Memory>> memory;
  std::vector<std::unique_ptr<Bare>> bare;
  std::vector<std::unique_ptr<Handover>> hands;
  std::vector<std::thread> threads;
  std::atomic<bool> ending{false};
  for (const Way& way : kWays) {
    if (way.bare && !way.thread) {
      bare.push_back(std::make_unique<Bare>(*participant, back(way), there(way), way.reliable,
                                            [](Bare& self, const std::byte* bytes) { self.write(bytes); }));
    } else if (way.bare) {
      hands.push_back(std::make_unique<Handover>());
      Handover& hand = *hands.back();
      bare.push_back(std::make_unique<Bare>(*participant, back(way), there(way), way.reliable,
                                            [&hand](Bare&, const std::byte* bytes) { hand.give(bytes); }));
      threads.emplace_back([&hand, &ending, &self = *bare.back()] {
        std::uint32_t seen = 0;
        while (!ending) {
          if (hand.take(seen)) self.write(hand.bytes());
        }
      });
    } else if (!way.thread) {  // the gateway both writes this link and reads it
      memory.push_back(std::make_unique<Memory>(queue(channel::kGatewayBit)));
      if (!(*gateway)->add_outgoing(flow(back(way), way.reliable), memory.back()->link())) return 1;
      if (!(*gateway)->add_incoming(flow(there(way), way.reliable), {memory.back()->link()})) return 1;
    } else {
      memory.push_back(std::make_unique<Memory>(queue(channel::kGatewayBit)));
      const channel::Link out = memory.back()->link();
      memory.push_back(std::make_unique<Memory>(queue(way.reliable ? kPingBit << 1 : kPingBit)));
      const channel::Link in = memory.back()->link();
      if (!(*gateway)->add_outgoing(flow(back(way), way.reliable), out)) return 1;
      if (!(*gateway)->add_incoming(flow(there(way), way.reliable), {in})) return 1;
      threads.emplace_back([in, out, &wake_word, &ending] {
        channel::LinkReader reader{in};
        channel::LinkWriter writer{out};
        while (!ending) {
          const std::uint32_t rings = wake_word.rings.load();
          if (reader.take())
            write(writer, wake_word, in.payload(reader.buffer()));
          else
            os::futex_wait(wake_word.rings, rings, in.block().wake_bits, os::now() + 1s);
        }
      });
    }
  }
  std::puts("ready");
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  ending = true;
  ring(wake_word, ~0U);
  for (std::thread& each : threads) each.join();
  return 0;
}

// ---- The first process, which sends pings and measures

struct Times {
  std::vector<double> us;
  std::size_t lost = 0;
  [[nodiscard]] double quantile(double q) {
    if (us.empty()) return 0;
    const auto at = us.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(us.size() - 1));
    std::nth_element(us.begin(), at, us.end());
    return *at;
  }
};

/// Sends pings, one at a time, over one of the ways in kWays.
class Pinger {
 public:
  Pinger(const Way& way, const std::shared_ptr<dds::Participant>& participant, dds::Gateway& gateway,
         channel::WakeWord& wake_word)
      : wake_word_(wake_word) {
    if (way.bare) {
      bare_ = std::make_unique<Bare>(participant, there(way), back(way), way.reliable,
                                     [this](Bare&, const std::byte* bytes) { hand_.give(bytes); });
      return;
    }
    out_ = std::make_unique<Memory>(queue(channel::kGatewayBit));
    in_ = std::make_unique<Memory>(queue(kPingBit));
    const auto going = gateway.add_outgoing(flow(there(way), way.reliable), out_->link());
    const auto coming = gateway.add_incoming(flow(back(way), way.reliable), {in_->link()});
    if (!going || !coming) std::abort();
    writer_ = channel::LinkWriter{out_->link()};
    reader_ = channel::LinkReader{in_->link()};
  }

  /// Returns false if the ping does not return within a second.
  bool ping(double& us) {
    const auto bytes = bench::ping(++number_);
    const Instant begin = os::now();
    if (bare_) {
      bare_->write(bytes.data());
      do {
        if (!hand_.take(seen_)) return false;
      } while (number_in(hand_.bytes()) != number_);
    } else {
      write(writer_, wake_word_, bytes.data());
      const Instant end = begin + 1s;
      for (;;) {
        const std::uint32_t rings = wake_word_.rings.load();
        if (reader_.take()) {
          if (number_in(in_->link().payload(reader_.buffer())) == number_) break;
        } else {
          if (os::now() > end) return false;
          os::futex_wait(wake_word_.rings, rings, kPingBit, end);
        }
      }
    }
    us = static_cast<double>((os::now() - begin).count()) / 1000.0;
    return true;
  }

 private:
  channel::WakeWord& wake_word_;
  Handover hand_;
  std::uint32_t seen_ = 0;
  std::uint64_t number_ = 0;
  std::unique_ptr<Bare> bare_;
  std::unique_ptr<Memory> out_;
  std::unique_ptr<Memory> in_;
  channel::LinkWriter writer_;
  channel::LinkReader reader_;
};

void round_trips(const std::shared_ptr<dds::Participant>& participant, dds::Gateway& gateway,
                 channel::WakeWord& wake_word, int count) {
  std::vector<std::unique_ptr<Pinger>> pingers;
  for (const Way& way : kWays)
    pingers.push_back(std::make_unique<Pinger>(way, participant, gateway, wake_word));
  std::array<Times, kWays.size()> times;
  for (std::size_t way = 0; way < kWays.size(); ++way) {  // warm-up: repeats until a ping returns
    double us = 0;
    for (int i = 0; i < 20 && !pingers[way]->ping(us); ++i) continue;
  }
  for (int turn = 0; turn < kTurns; ++turn) {
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      for (int i = 0; i < count; ++i) {
        double us = 0;
        if (pingers[way]->ping(us))
          times[way].us.push_back(us);
        else
          ++times[way].lost;
      }
    }
  }
  std::printf("\nround trip of 64 bytes, us         p50      p99   p99.9      max   lost   of bare\n");
  for (std::size_t way = 0; way < kWays.size(); ++way) {
    const double p50 = times[way].quantile(0.5);
    std::printf("%-30s %7.1f  %7.1f %7.1f  %7.1f  %5zu", kWays[way].name, p50, times[way].quantile(0.99),
                times[way].quantile(0.999), times[way].quantile(1), times[way].lost);
    if (!kWays[way].bare) std::printf("     %.2f", p50 / times[way - 1].quantile(0.5));
    std::printf("\n");
  }
}

/// Measures, in one process, the time from writing an event to incrementing the wake word of the module that
/// receives the event.
void event_to_ring(const std::shared_ptr<dds::Participant>& participant, dds::Gateway& gateway,
                   channel::WakeWord& wake_word, int count) {
  const Memory in{queue(channel::kSporadicBit)};
  auto feed = dds::Feed::create(participant, flow("event", true));
  const auto coming = gateway.add_incoming(flow("event", true), {in.link()});
  if (!feed || !coming) return;
  while ((*feed)->health().matched == 0) std::this_thread::sleep_for(1ms);
  Times times;
  channel::LinkReader reader{in.link()};
  for (int i = 0; i < count; ++i) {
    const auto bytes = ping(static_cast<std::uint64_t>(i));
    const std::uint32_t rings = wake_word.rings.load();
    const Instant begin = os::now();
    (*feed)->write(bytes.data(), bytes.size());
    while (wake_word.rings.load() == rings && os::now() - begin < 100ms) continue;
    if (reader.take())
      times.us.push_back(static_cast<double>((os::now() - begin).count()) / 1000.0);
    else
      ++times.lost;
  }
  std::printf("\nevent, from DataWriter::write() to the ring, us: p50 %.1f, p99 %.1f, lost %zu\n",
              times.quantile(0.5), times.quantile(0.99), times.lost);
}

/// Measures how long a write takes on the thread that runs a module.
void real_time_write(dds::Gateway& gateway, channel::WakeWord& wake_word) {
  const Memory out{{.depth = 8, .payload = kBytes, .is_queue = true, .wake_bits = channel::kGatewayBit}};
  if (!gateway.add_outgoing(flow("cost", false), out.link())) return;
  channel::LinkWriter writer{out.link()};
  const auto bytes = ping(1);
  for (const bool in_a_burst : {false, true}) {
    Times write_ns;
    Times ring_ns;
    for (int i = 0; i < 20000; ++i) {
      if (!in_a_burst) std::this_thread::sleep_for(50us);
      const Instant begin = os::now();
      std::memcpy(writer.link().payload(writer.buffer()), bytes.data(), kBytes);
      writer.publish(kBytes, to_ns(begin));
      wake_word.note(channel::kGatewayBit);
      const Instant written = os::now();
      if (const std::uint32_t bits = wake_word.take_pending(); bits != 0) {
        ring(wake_word, bits);
        ring_ns.us.push_back(static_cast<double>((os::now() - written).count()));
      }
      write_ns.us.push_back(static_cast<double>((written - begin).count()));
    }
    std::printf(
        "write of 64 bytes and note, %-24s ns: p50 %.0f, p99 %.0f; ring at the end of the cycle, %zu of "
        "20000, ns: p50 %.0f, p99 %.0f\n",
        in_a_burst ? "back to back," : "one each 100 us or so,", write_ns.quantile(0.5),
        write_ns.quantile(0.99), ring_ns.us.size(), ring_ns.quantile(0.5), ring_ns.quantile(0.99));
  }
}

int run(const char* self, int count) {
  std::array<int, 2> to{};
  std::array<int, 2> from{};
  if (::pipe2(to.data(), O_CLOEXEC) != 0 || ::pipe2(from.data(), O_CLOEXEC) != 0) return 1;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, to[0], 0);
  ::posix_spawn_file_actions_adddup2(&actions, from[1], 1);
  std::string program{self};
  std::string argument{"echo"};
  std::array<char*, 3> words{program.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (::posix_spawn(&child, self, &actions, nullptr, words.data(), environ) != 0) return 1;
  ::close(to[0]);
  ::close(from[1]);
  std::array<char, 16> said{};
  if (::read(from[0], said.data(), said.size()) <= 0) return 1;

  const os::Platform machine = os::describe_platform();
  const Nanoseconds stolen = os::stolen_time();
  const Instant began = os::now();
  int status = 1;
  if (auto participant = participate("ping"); participant) {
    channel::WakeWord wake_word{};
    auto gateway = dds::Gateway::create(*participant, wake_word);
    if (gateway) {
      std::printf("load %s; kernel %s\n", machine.load.c_str(), machine.kernel.c_str());
      round_trips(*participant, **gateway, wake_word, count);
      event_to_ring(*participant, **gateway, wake_word, count);
      real_time_write(**gateway, wake_word);
      status = 0;
    }
  }
  const std::chrono::duration<double> all = (os::now() - began) * machine.processors;
  std::printf("stolen by other machines: %.1f %% of the time\n",
              100.0 * std::chrono::duration<double>(os::stolen_time() - stolen).count() / all.count());
  ::close(to[1]);
  ::waitpid(child, nullptr, 0);
  return status;
}

}  // namespace
}  // namespace takt::bench

int main(int count, char** words) {
  if (count == 2 && std::string{words[1]} == "echo") return takt::bench::echo();
  return takt::bench::run("/proc/self/exe", count == 2 ? std::atoi(words[1]) : 2000);
}
