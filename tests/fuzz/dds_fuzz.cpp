// Gives packets that rtps_grammar.hpp makes to the packet filter and to Fast DDS, in a participant like that
// of a node, with readers and writers that the senders of the packets match.
//
//   dds_fuzz [--secured] [--seed SEED] [--packets COUNT] [--batch NUMBER]
//
// --packets: how many packets (20000); with TAKT_FUZZ_SECONDS, as many as that time allows
// --batch: only this batch of packets, as an earlier run has printed it
//
// It checks that
// - the filter passes each valid packet and drops each packet that breaks a rule;
// - nothing reads beyond a packet: the packet ends where a page without access begins;
// - no packet takes more than kMostCpu of CPU time, or kMostTime in all;
// - the memory of the process stays below kMostMemory;
// - after each batch of packets, a sample of another participant arrives, and a command is answered.
//
// The packets depend only on the seed. The timers of Fast DDS run beside them.
#include <arpa/inet.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <takt/wire/takt.h>
#include <takt/wire/taktPubSubTypes.h>
#include <takt/core/check.hpp>
#include <takt/dds/commands.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/dds/topics.hpp>
#include <takt/os/clock.hpp>
#include <takt/security/authority.hpp>
#include "inside.hpp"
#include "raw.hpp"
#include "udp_transport.hpp"
#include "workarounds/replaced_function.hpp"

#include "rtps_grammar.hpp"

extern "C" void __sanitizer_set_death_callback(void (*)()) __attribute__((weak));
// Fast DDS deletes statistics with another size than it allocates, and frees some memory only at the end.
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "new_delete_type_mismatch=0:quarantine_size_mb=64:detect_leaks=0";
}

namespace fuzz {

namespace dds = takt::dds;
namespace rtps = takt::dds::rtps;

// Handles a packet for the object that receives the packets of one port.
#define RECEIVE TAKT_RTPS "16ReceiverResource14OnDataReceivedEPKhjRKNS1_9Locator_tES7_"
using Receive = void(void* receiver, const rtps::octet*, std::uint32_t, const rtps::Locator_t& port,
                     const rtps::Locator_t& from);
Receive receive asm(RECEIVE);

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kBatch = 1000;
constexpr auto kMostCpu = 10s;
constexpr auto kMostTime = 120s;
constexpr auto kMostWait = 60s;
constexpr std::size_t kMostMemory = std::size_t{2} << 30U;
constexpr std::size_t kLargest = 65536;
constexpr Prefix kHonest{1, 15, 'h', 'o', 'n', 'e', 's', 't'};

// ---- The packet that is being handled, for the report of a failure

struct Current {
  std::uint64_t seed = 0;
  std::uint64_t batch = 0;
  std::uint64_t in_batch = 0;
  bool secured = false;
  Packet packet;
} current;

void report() {
  std::fprintf(
      stderr,
      "dds_fuzz: failed at packet %llu of a batch. Repeat with: dds_fuzz%s --seed %llu --batch %llu\n",
      static_cast<unsigned long long>(current.in_batch), current.secured ? " --secured" : "",
      static_cast<unsigned long long>(current.seed), static_cast<unsigned long long>(current.batch));
  static const char* const kKinds[] = {"valid", "broken", "damaged"};
  std::fprintf(stderr, "%s packet, rule %s, to port %u:\n", kKinds[static_cast<int>(current.packet.kind)],
               to_text(current.packet.rule), unsigned{current.packet.port});
  for (const std::uint8_t byte : current.packet.bytes) std::fprintf(stderr, "%02x", unsigned{byte});
  std::fprintf(stderr, "\n");
  std::fflush(stderr);
}

[[noreturn]] void fail(const std::string& why) {
  std::fprintf(stderr, "dds_fuzz: %s\n", why.c_str());
  report();
  std::_Exit(1);
}

void on_signal(int number) {
  std::fprintf(stderr, "dds_fuzz: signal %d\n", number);
  report();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

// ---- The participant's ports

std::mutex handling;  // Fast DDS handles one packet at a time: one of the fuzzer or one from a socket
std::mutex ports_mutex;
std::condition_variable port_found;
struct Port {
  void* receiver = nullptr;
  rtps::Locator_t locator;
};
std::map<std::uint32_t, Port> open_ports;

Receive* original() {
  static Receive* const found = dds::replaced<Receive>(RECEIVE);
  return found;
}

/// A network of this process alone, with a loopback interface.
void leave_network() {
  if (::unshare(CLONE_NEWNET) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
    std::perror("dds_fuzz: cannot create a network namespace");
    std::exit(1);
  }
  const int any = ::socket(AF_INET, SOCK_DGRAM, 0);
  ifreq loopback{};
  std::strcpy(loopback.ifr_name, "lo");
  TAKT_CHECK(::ioctl(any, SIOCGIFFLAGS, &loopback) == 0);
  loopback.ifr_flags |= IFF_UP;
  TAKT_CHECK(::ioctl(any, SIOCSIFFLAGS, &loopback) == 0);
  ::close(any);
}

/// The socket of all peers, to which the participant sends.
class Peers {
 public:
  Peers() {
    sockaddr_in me{};
    me.sin_family = AF_INET;
    me.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    TAKT_CHECK(::bind(udp_, reinterpret_cast<sockaddr*>(&me), sizeof me) == 0);
    socklen_t size = sizeof me;
    TAKT_CHECK(::getsockname(udp_, reinterpret_cast<sockaddr*>(&me), &size) == 0);
    port_ = ntohs(me.sin_port);
  }
  Peers(const Peers&) = delete;
  Peers& operator=(const Peers&) = delete;
  ~Peers() { ::close(udp_); }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  void send(std::uint16_t port, const Octets& bytes) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(port);
    ::sendto(udp_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  void empty() {
    while (::recv(udp_, buffer_.data(), buffer_.size(), MSG_DONTWAIT) >= 0) {
    }
  }
  /// Waits at most so long for a packet that contains the text.
  bool receives(const std::string& text, std::chrono::milliseconds most) {
    const auto end = std::chrono::steady_clock::now() + most;
    for (;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      pollfd ready{.fd = udp_, .events = POLLIN, .revents = 0};
      if (left <= 0ms || ::poll(&ready, 1, static_cast<int>(left.count())) <= 0) return false;
      const auto size = ::recv(udp_, buffer_.data(), buffer_.size(), 0);
      if (size > 0 && std::string_view{buffer_.data(), static_cast<std::size_t>(size)}.find(text) !=
                          std::string_view::npos)
        return true;
    }
  }

 private:
  int udp_ = ::socket(AF_INET, SOCK_DGRAM, 0);
  std::uint16_t port_ = 0;
  std::vector<char> buffer_ = std::vector<char>(kLargest);
};

/// Memory for one packet, before a page without access.
class Edge {
 public:
  Edge() {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    void* const memory =
        ::mmap(nullptr, kLargest + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    TAKT_CHECK(memory != MAP_FAILED);
    end_ = static_cast<std::uint8_t*>(memory) + kLargest;
    TAKT_CHECK(::mprotect(end_, page, PROT_NONE) == 0);
  }
  std::uint8_t* put(const std::uint8_t* bytes, std::size_t size) const {
    TAKT_CHECK(size <= kLargest);
    if (size > 0) std::memmove(end_ - size, bytes, size);
    return end_ - size;
  }

 private:
  std::uint8_t* end_;
};

// ---- The readers and writers under attack

takt::model::Type sample_type() {
  return {.name = "test::Sample",
          .fields = {{.name = "number", .scalar = takt::model::Scalar::uint64},
                     {.name = "data", .scalar = takt::model::Scalar::octet, .sequence = 60000}}};
}

dds::Flow flow(const std::string& topic, bool reliable, bool kept = false) {
  return {.topic = topic,
          .type = sample_type(),
          .quality = {.reliable = reliable, .depth = 32, .deadline = {}, .lifespan = {}, .kept = kept}};
}

Octets sample_of(std::uint64_t number, std::uint32_t size) {
  Body body{true};
  body.u32(number).u32(number >> 32U).u32(size).zeros(size);
  Octets all{0, 1, 0, 0};
  all.insert(all.end(), body.bytes.begin(), body.bytes.end());
  return all;
}

template <class Generated, class T>
Octets encoded(T value) {
  Generated type;
  rtps::SerializedPayload_t payload{dds::max_size_of(type)};
  TAKT_CHECK(dds::encode_sample(type, &value, payload));
  return {payload.data, payload.data + payload.length};
}

template <class T>
T must(takt::Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "dds_fuzz: %s\n", takt::to_text(result.problems()).c_str());
  std::exit(1);
}

takt::DeviceStatus device_status() {
  takt::DeviceStatus status;
  status.path("fuzz/robot");
  status.cell("fuzz");
  status.device("robot");
  status.node("robot-1");
  status.host_name("here");
  status.time_ns(1);
  return status;
}
takt::LifecycleStatus lifecycle_status() {
  takt::LifecycleStatus status;
  status.path("fuzz/robot/arm");
  status.cell("fuzz");
  status.device("robot");
  status.name("arm");
  status.sequence_number(1);
  status.time_ns(1);
  return status;
}
takt::Command command(const std::string& id, const std::string& device) {
  takt::Command one;
  one.id(id);
  one.device(device);
  one.kind(takt::COMMAND_REPORT);
  one.deadline_ns(takt::os::wall_ns() + 3'600'000'000'000);
  one.parts(1);
  return one;
}

class Participant {
 public:
  Participant(const std::string& security, int domain) {
    dds::ParticipantOptions options{
        .name = "fuzz", .domain = domain, .discovery = {}, .interfaces = {"127.0.0.1"}};
    options.security = security;
    participant_ = must(dds::Participant::create(options));
    lifecycle_.emplace(
        must(dds::Reader<takt::LifecycleStatus>::create(participant_, {.sample = [](const auto&, auto) {}})));
    devices_.emplace(
        must(dds::Reader<takt::DeviceStatus>::create(participant_, {.sample = [](const auto&, auto) {}})));
    if (!security.empty()) return;
    statistics_.emplace(must(
        dds::Reader<takt::ModuleStatistics>::create(participant_, {.sample = [](const auto&, auto) {}})));
    faults_.emplace(
        must(dds::Reader<takt::FaultEvent>::create(participant_, {.sample = [](const auto&, auto) {}})));
    server_.emplace(must(dds::CommandServer::create(participant_, "robot", "robot-1",
                                                    [this](const takt::wire::WholeCommand& got) {
                                                      takt::wire::WholeReply answer;
                                                      answer.head.id(got.head.id());
                                                      const std::lock_guard lock{made_};
                                                      server_->reply(answer);
                                                    })));
    const std::lock_guard lock{made_};
    client_.emplace(must(dds::CommandClient::create(participant_, [](const takt::wire::WholeReply&) {})));
    for (const char* topic : {"reliable", "best_effort"})
      taps_.push_back(must(dds::Tap::create(participant_, flow(topic, topic[0] == 'r'),
                                            [](const std::byte*, std::size_t, std::int64_t) {})));
    taps_.push_back(must(dds::Tap::create(participant_, flow("honest", true),
                                          [this](const std::byte* bytes, std::size_t, std::int64_t) {
                                            std::uint64_t number = 0;
                                            std::memcpy(&number, bytes + 4, sizeof number);
                                            if (number == expected_) ++arrived_;
                                          })));
    feeds_.push_back(must(dds::Feed::create(participant_, flow("out", true))));
    feeds_.push_back(must(dds::Feed::create(participant_, flow("kept", true, true))));
    own_device_.emplace(must(dds::Writer<takt::DeviceStatus>::create(participant_)));
    own_modules_.emplace(must(dds::Writer<takt::LifecycleStatus>::create(participant_)));
  }

  /// Writes samples of all sizes, so that the writers have something to repeat.
  void write() {
    if (!own_device_) return;
    own_device_->write(device_status());
    own_modules_->write(lifecycle_status());
    for (auto& feed : feeds_) {
      for (const std::uint32_t size : {0U, 50000U}) {
        const Octets bytes = sample_of(1, size);
        feed->write(reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
      }
    }
  }
  /// Returns true if `give`, which gives the participant this sample of another one, makes it arrive.
  template <class Give>
  bool receives(std::uint64_t number, Give&& give) {
    arrived_ = 0;
    expected_ = number;
    give();
    return arrived_ == 1;
  }

  /// Returns how many samples of peers have arrived that are valid.
  [[nodiscard]] std::uint64_t samples() const {
    std::uint64_t sum = 0;
    for (const auto& each : taps_) sum += each->health().samples;
    return sum;
  }
  [[nodiscard]] Prefix prefix() const {
    Prefix prefix;
    const auto& guid = dds::own(*participant_).participant().guid();
    std::copy_n(guid.guidPrefix.value, prefix.size(), prefix.begin());
    return prefix;
  }
  std::pair<std::vector<Endpoint>, std::vector<Endpoint>> endpoints();
  [[nodiscard]] dds::PacketFilter& filter() const {
    for (const auto& each : dds::own(*participant_).participant().get_qos().transport().user_transports) {
      if (const auto* transport = dynamic_cast<const dds::UdpTransportDescriptor*>(each.get()))
        return *transport->filter();
    }
    std::abort();
  }

 private:
  std::mutex made_;
  std::shared_ptr<dds::Participant> participant_;
  std::optional<dds::Reader<takt::LifecycleStatus>> lifecycle_;
  std::optional<dds::Reader<takt::DeviceStatus>> devices_;
  std::optional<dds::Reader<takt::ModuleStatistics>> statistics_;
  std::optional<dds::Reader<takt::FaultEvent>> faults_;
  std::optional<dds::CommandServer> server_;
  std::optional<dds::CommandClient> client_;
  std::vector<std::unique_ptr<dds::Tap>> taps_;
  std::vector<std::unique_ptr<dds::Feed>> feeds_;
  std::optional<dds::Writer<takt::DeviceStatus>> own_device_;
  std::optional<dds::Writer<takt::LifecycleStatus>> own_modules_;
  std::atomic<std::uint64_t> expected_{0};
  std::atomic<int> arrived_{0};
};

std::uint32_t number_of_entity(const rtps::GUID_t& guid) {
  std::uint32_t id = 0;
  for (const auto byte : guid.entityId.value) id = id << 8U | byte;
  return id;
}

// Only a reader and a writer lead to the lists of all readers and writers.
std::pair<std::vector<Endpoint>, std::vector<Endpoint>> Participant::endpoints() {
  // With DDS Security, no packet of a peer leads to a reader or writer of a topic.
  if (taps_.empty())
    return {{{.id = 0x107, .topic = "takt/device", .type = "takt::DeviceStatus"}},
            {{.id = 0x203, .topic = "x", .type = "x"}}};
  dds::OwnParticipant& own = dds::own(*participant_);
  dds::fast::DataReaderQos reader_qos;
  dds::fast::DataWriterQos writer_qos;
  reader_qos.data_sharing().off();
  writer_qos.data_sharing().off();
  auto* topic = must(own.topic("list", dds::fast::TypeSupport{new dds::RawType{"list", 64}}));
  auto* reader =
      own.make_reader(topic, reader_qos, nullptr, dds::fast::StatusMask::none(), dds::Receives::alone);
  auto* writer = own.make_writer(topic, writer_qos, nullptr, dds::fast::StatusMask::none());
  TAKT_CHECK(reader != nullptr && writer != nullptr);
  std::vector<dds::fast::DataReader*> readers;
  std::vector<dds::fast::DataWriter*> writers;
  reader->get_subscriber()->get_datareaders(readers);
  writer->get_publisher()->get_datawriters(writers);
  std::pair<std::vector<Endpoint>, std::vector<Endpoint>> found;
  const auto add = [](std::vector<Endpoint>& to, const auto& each, const std::string& name,
                      const std::string& type) {
    Endpoint one{.id = number_of_entity(each.guid()),
                 .topic = name,
                 .type = type,
                 .reliable = each.get_qos().reliability().kind == dds::fast::RELIABLE_RELIABILITY_QOS,
                 .kept = each.get_qos().durability().kind != dds::fast::VOLATILE_DURABILITY_QOS};
    if (type == "takt::DeviceStatus") one.samples = {encoded<takt::DeviceStatusPubSubType>(device_status())};
    if (type == "takt::LifecycleStatus")
      one.samples = {encoded<takt::LifecycleStatusPubSubType>(lifecycle_status())};
    if (type == "takt::Command")
      one.samples = {encoded<takt::CommandPubSubType>(command("1", "robot")),
                     encoded<takt::CommandPubSubType>(command("2", "line"))};
    if (type == "takt::Reply") one.samples = {encoded<takt::ReplyPubSubType>(takt::Reply{})};
    if (type == "takt::ModuleStatistics")
      one.samples = {encoded<takt::ModuleStatisticsPubSubType>(takt::ModuleStatistics{})};
    if (type == "takt::FaultEvent") one.samples = {encoded<takt::FaultEventPubSubType>(takt::FaultEvent{})};
    if (type == "test::Sample")
      one.samples = {sample_of(1, 0), sample_of(2, 100), sample_of(3, 4000), sample_of(4, 60000),
                     sample_of(5, 9)};
    to.push_back(std::move(one));
  };
  for (const auto* each : readers) {
    if (each != reader)
      add(found.first, *each, each->get_topicdescription()->get_name(),
          each->get_topicdescription()->get_type_name());
  }
  for (const auto* each : writers) {
    if (each != writer)
      add(found.second, *each, each->get_topic()->get_name(), each->get_topic()->get_type_name());
  }
  own.end(reader);
  own.end(writer);
  own.release(topic);
  const auto by_id = [](const Endpoint& a, const Endpoint& b) { return a.id < b.id; };
  std::sort(found.first.begin(), found.first.end(), by_id);
  std::sort(found.second.begin(), found.second.end(), by_id);
  return found;
}

// ---- The run

struct Wanted {
  bool secured = false;
  std::uint64_t seed = 1;
  std::uint64_t packets = 20'000;
  std::optional<std::uint64_t> batch;
  std::chrono::seconds time{0};
};

/// Ends the process if a packet takes too long.
class Watch {
 public:
  Watch() {
    thread_ = std::jthread{[this](const std::stop_token& end) {
      std::uint64_t seen = 0;
      auto since = std::chrono::steady_clock::now();
      auto cpu = now();
      while (!end.stop_requested()) {
        std::this_thread::sleep_for(100ms);
        if (const std::uint64_t step = steps_; step != seen) {
          seen = step;
          since = std::chrono::steady_clock::now();
          cpu = now();
          continue;
        }
        if (now() - cpu > kMostCpu) fail("a packet takes too much CPU time");
        if (std::chrono::steady_clock::now() - since > kMostTime) fail("a packet takes too long");
      }
    }};
  }
  void step() { ++steps_; }

 private:
  // The CPU time of all threads: this one may wait for one that does not end.
  static std::chrono::nanoseconds now() {
    timespec time{};
    TAKT_CHECK(::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) == 0);
    return std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec};
  }
  std::atomic<std::uint64_t> steps_{0};
  std::jthread thread_;
};

std::size_t resident_bytes() {
  std::ifstream file{"/proc/self/statm"};
  std::size_t all = 0;
  std::size_t resident = 0;
  file >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

class Run {
 public:
  Run(const Wanted& wanted, const std::string& security, const Octets& certificate)
      : wanted_(wanted), secured_(wanted.secured), participant_(security, kDomain) {
    for (const std::uint16_t port : {kPorts.group, kPorts.discovery, kPorts.samples}) {
      std::unique_lock lock{ports_mutex};
      while (!open_ports.contains(port)) {
        const Prefix nobody{9};
        Octets pad{'R', 'T', 'P', 'S', 2, 3, 1, 15};
        pad.insert(pad.end(), nobody.begin(), nobody.end());
        pad.insert(pad.end(), {1, 1, 0, 0});
        peers_.send(port, pad);
        port_found.wait_for(lock, 100ms);
      }
    }
    const auto endpoints = participant_.endpoints();
    const auto& readers = endpoints.first;
    const auto& writers = endpoints.second;
    Grammar::Ports to = kPorts;
    to.peers = peers_.port();
    begin_batch_ = [=, this] { grammar_.emplace(to, participant_.prefix(), readers, writers, certificate); };
    honest_.emplace(to, participant_.prefix(), readers, writers, certificate);
  }

  void run() {
    if (!secured_) {
      for (const Packet& each : honest_->introduction(kHonest)) give(each);
    }
    if (wanted_.batch) return batch(*wanted_.batch);
    const auto begin = std::chrono::steady_clock::now();
    std::uint64_t number = 0;
    const auto is_over = [&] {
      return wanted_.time > 0s ? std::chrono::steady_clock::now() - begin >= wanted_.time
                               : number * kBatch >= wanted_.packets;
    };
    for (; !is_over(); ++number) batch(number);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    std::printf(
        "%llu packets%s: %llu valid, %llu broken, %llu damaged (%llu of them passed), %llu samples arrived, "
        "in %.1f s; %.0f packets/s; %zu MB\n",
        static_cast<unsigned long long>(number * kBatch), secured_ ? " with DDS Security" : "",
        static_cast<unsigned long long>(counts_[0]), static_cast<unsigned long long>(counts_[1]),
        static_cast<unsigned long long>(counts_[2]), static_cast<unsigned long long>(damaged_passed_),
        static_cast<unsigned long long>(participant_.samples()), took.count(),
        static_cast<double>(number * kBatch) / took.count(), resident_bytes() >> 20U);
  }

 private:
  static constexpr int kDomain = 0;
  static constexpr Grammar::Ports kPorts{};

  void batch(std::uint64_t number) {
    current.batch = number;
    current.in_batch = 0;
    Dice dice{wanted_.seed * 1'000'003 + number};
    begin_batch_();
    for (std::size_t i = 0; i < Grammar::kPeers; ++i) {
      for (const Packet& each : grammar_->introduction(Grammar::peer(i))) give(each);
    }
    participant_.write();
    for (std::size_t i = 0; i < kBatch; ++i) {
      const Packet packet = grammar_->packet(dice);
      ++counts_[static_cast<std::size_t>(packet.kind)];
      give(packet);
      if (i % 64 == 0) peers_.empty();
    }
    if (!secured_) is_alive();
    if (resident_bytes() > kMostMemory) fail("the process needs too much memory");
  }

  void give(const Packet& packet) {
    current.packet = packet;
    ++current.in_batch;
    watch_.step();
    std::optional<std::size_t> passed;
    // A process that was halted leaves and authenticates again, and receives nothing in between.
    do {
      while (participant_.filter().is_silent(true)) std::this_thread::sleep_for(10ms);
      passed = pass(packet);
    } while (!passed && participant_.filter().is_silent(true));
    watch_.step();
    if (packet.kind == Packet::Kind::valid && passed != packet.readable)
      fail(passed ? "the filter passes another part of a valid packet" : "the filter drops a valid packet");
    if (packet.kind == Packet::Kind::broken && passed)
      fail(std::string{"the filter passes a packet that breaks the rule "} + to_text(packet.rule));
    if (packet.kind == Packet::Kind::damaged && passed) ++damaged_passed_;
  }

  /// Returns how many bytes of a packet the filter passes, if any.
  std::optional<std::size_t> pass(const Packet& packet) {
    std::optional<std::size_t> passed;
    // The bytes of a packet are read only in front of the page without access.
    std::uint8_t* const bytes = edge_.put(packet.bytes.data(), packet.bytes.size());
    // With DDS Security, the number of unauthenticated participants of one address is limited.
    const takt::os::Ipv4 from =
        packet.kind == Packet::Kind::damaged ? takt::os::Ipv4{10, 0, 0, 1} : takt::os::Ipv4{127, 0, 0, 1};
    participant_.filter().pass(
        {bytes, packet.bytes.size()}, {.from = from, .here = true}, [&](std::size_t readable) {
          passed = readable;
          const std::uint8_t* const part = edge_.put(bytes, readable);  // pass() may have changed it
          rtps::Locator_t sender{LOCATOR_KIND_UDPv4, peers_.port()};
          sender.address[12] = 127;
          sender.address[15] = 1;
          const std::lock_guard lock{handling};
          const Port& port = open_ports.at(packet.port);
          original()(port.receiver, part, static_cast<std::uint32_t>(readable), port.locator, sender);
        });
    return passed;
  }

  /// Checks that the participant still receives samples and answers commands.
  void is_alive() {
    const std::uint64_t number = 0x5afe'0000'0000 + ++samples_;
    const Packet sample =
        honest_->sample(kHonest, "honest", static_cast<std::int64_t>(samples_), sample_of(number, 16));
    if (!participant_.receives(number, [&] { give(sample); }))
      fail("a sample of another participant does not arrive");
    const std::string id = "honest-" + std::to_string(samples_);
    peers_.empty();
    const auto end = std::chrono::steady_clock::now() + kMostWait;
    do {
      if (std::chrono::steady_clock::now() > end) fail("a command is not answered");
      give(honest_->sample(kHonest, "takt/command", ++commands_,
                           encoded<takt::CommandPubSubType>(command(id, "robot"))));
    } while (!peers_.receives(id, 1000ms));
  }

  const Wanted wanted_;
  const bool secured_;
  Peers peers_;
  Participant participant_;
  std::function<void()> begin_batch_;  // makes a new grammar_, so that a batch can be repeated alone
  std::optional<Grammar> grammar_;
  std::optional<Grammar> honest_;
  Edge edge_;
  Watch watch_;
  std::uint64_t samples_ = 0;
  std::int64_t commands_ = 0;
  std::array<std::uint64_t, 3> counts_{};
  std::uint64_t damaged_passed_ = 0;
};

/// An identity for the participant, in a folder that the object removes.
class Identity {
 public:
  Identity()
      : folder_(std::filesystem::temp_directory_path() / ("takt-dds-fuzz-" + std::to_string(::getpid()))) {
    takt::security::Plan plan;
    plan.cell.name = "fuzz";
    plan.cell.devices.emplace_back().name = "robot";
    const std::int64_t now = takt::os::wall_ns() / 1'000'000'000;
    auto authority = must(takt::security::Authority::create(folder_.string(), "fuzz", now));
    TAKT_CHECK(authority.issue({"fuzz", takt::security::Role::device, "robot"}, plan, 100, now).ok());
  }
  Identity(const Identity&) = delete;
  Identity& operator=(const Identity&) = delete;
  ~Identity() { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string robot() const { return (folder_ / "devices" / "robot").string(); }
  [[nodiscard]] Octets certificate() const {
    std::ifstream file{robot() + "/" + takt::security::kCertificate, std::ios::binary};
    return {std::istreambuf_iterator<char>{file}, {}};
  }

 private:
  std::filesystem::path folder_;
};

int run(const Wanted& wanted) {
  current.seed = wanted.seed;
  current.secured = wanted.secured;
  std::printf("seed %llu\n", static_cast<unsigned long long>(wanted.seed));
  std::fflush(stdout);
  leave_network();
  std::optional<Identity> identity;
  if (wanted.secured) identity.emplace();
  Run{wanted, identity ? identity->robot() : "", identity ? identity->certificate() : Octets{}}.run();
  return 0;
}

}  // namespace

void receive(void* receiver, const rtps::octet* bytes, std::uint32_t size, const rtps::Locator_t& port,
             const rtps::Locator_t& from) {
  {
    const std::lock_guard lock{ports_mutex};
    open_ports[port.port] = {receiver, port};
    port_found.notify_all();
  }
  const std::lock_guard lock{handling};
  original()(receiver, bytes, size, port, from);
}

}  // namespace fuzz

int main(int count, char** words) {
  fuzz::Wanted wanted;
  if (const char* seconds = std::getenv("TAKT_FUZZ_SECONDS")) {
    wanted.time = std::chrono::seconds{std::atoi(seconds)};
    wanted.seed = static_cast<std::uint64_t>(takt::os::wall_ns());
  }
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    const std::uint64_t number = i + 1 < count ? std::strtoull(words[i + 1], nullptr, 10) : 0;
    if (word == "--secured")
      wanted.secured = true;
    else if (word == "--seed")
      wanted.seed = number, ++i;
    else if (word == "--packets")
      wanted.packets = number, ++i;
    else if (word == "--batch")
      wanted.batch = number, ++i;
    else
      return 2;
  }
  if (__sanitizer_set_death_callback != nullptr)
    __sanitizer_set_death_callback(&fuzz::report);
  else
    std::signal(SIGSEGV, &fuzz::on_signal);
  std::signal(SIGABRT, &fuzz::on_signal);
  return fuzz::run(wanted);
}
