// A process with which the tests communicate over DDS.
//
//   peer DOMAIN COMMAND ...
//
// The process ends when its standard input is closed. Environment variables:
//
//   PEER_DISCOVERY    multicast, peers=HOST, server=HOST:PORT or serve=HOST:PORT
//   PEER_INTERFACES   addresses separated by commas, or "all"; the default is 127.0.0.1
//   PEER_SECURITY     the folder of an identity; without it, DDS Security is off
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <takt/dds/commands.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/dds/topics.hpp>
#include <takt/wire/words.hpp>
#include "raw.hpp"
#include "workarounds/replaced_function.hpp"

#include "sample.hpp"

namespace takt::dds_test {
namespace {

using namespace std::chrono_literals;
using Arguments = std::vector<std::string>;
using Participant = std::shared_ptr<dds::Participant>;

void print(const std::string& line) {
  static std::mutex mutex;
  const std::lock_guard lock{mutex};
  std::cout << line << std::endl;
}

template <class T>
T must(Result<T> result) {
  if (!result) {
    print(to_text(result.problems()));
    std::exit(3);
  }
  return std::move(*result);
}

/// Waits for the next line of standard input and returns it. Returns "end" if standard input is closed.
std::string next_line() {
  std::string line;
  return std::getline(std::cin, line) ? line : "end";
}

std::int64_t wall_ns() {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

DeviceStatus device_status(const std::string& name, std::uint64_t sequence) {
  DeviceStatus status;
  status.path("test/" + name);
  status.cell("test");
  status.device(name);
  status.node(name + "-" + std::to_string(::getpid()));
  status.host_name("here");
  status.state(DEVICE_RUNNING);
  status.health(HEALTH_OK);
  status.process_id(::getpid());
  status.sequence_number(sequence);
  status.time_ns(wall_ns());
  return status;
}

LifecycleStatus lifecycle_status(std::size_t module, std::uint64_t sequence) {
  LifecycleStatus status;
  const std::string name = "module" + std::to_string(module);
  status.path("test/device/" + name);
  status.cell("test");
  status.device("device");
  status.name(name);
  status.state(sequence % 2 == 0 ? STATE_START : STATE_EXECUTING);
  status.event(sequence % 2 == 0 ? EVENT_STOP : EVENT_RUN);
  status.sequence_number(sequence);
  status.time_ns(wall_ns());
  return status;
}

/// Calls a function every 100 ms, on its own thread, until the Heartbeat is destroyed.
class Heartbeat {
 public:
  explicit Heartbeat(std::function<void()> beat)
      : thread_([this, beat] {
          while (!ending_) {
            beat();
            std::this_thread::sleep_for(100ms);
          }
        }) {}
  ~Heartbeat() {
    ending_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

// Command `device NAME`: publishes the status of device NAME ten times a second
void device(const Participant& participant, const Arguments& arguments) {
  auto writer = must(dds::Writer<DeviceStatus>::create(participant));
  std::uint64_t sequence = 0;
  const Heartbeat beat{[&] { writer.write(device_status(arguments[0], ++sequence)); }};
  print("ready");
  next_line();
}

// Command `watch`: prints the name and the number of each status of a device that it receives
void watch(const Participant& participant, const Arguments&) {
  auto reader = must(dds::Reader<DeviceStatus>::create(
      participant, {.sample = [](const DeviceStatus& status, wire::WriterId) {
        print(status.device().to_string() + " " + std::to_string(status.sequence_number()));
      }}));
  next_line();
}

// Command `stop DEVICE`: sends a stop command to DEVICE and prints the answer
void stop(const Participant& participant, const Arguments& arguments) {
  std::mutex mutex;
  std::condition_variable came;
  std::optional<wire::WholeReply> answer;
  auto client = must(dds::CommandClient::create(participant, [&](const wire::WholeReply& reply) {
    const std::lock_guard lock{mutex};
    answer = reply;
    came.notify_all();
  }));
  wire::WholeCommand command;
  command.head.id("stop-" + std::to_string(::getpid()));
  command.head.device(arguments[0]);
  command.head.kind(COMMAND_STOP);
  command.head.deadline_ns(wall_ns() + 20'000'000'000);
  client.send(command);
  std::unique_lock lock{mutex};
  came.wait_for(lock, 8s, [&] { return answer.has_value(); });
  print(answer ? "answer " + std::to_string(answer->head.code()) + " " + answer->head.text().to_string()
               : "no answer");
}

// Command `ask DEVICE`: for each line of standard input, stops a module that DEVICE does not have, and prints
// the answer. The deadline of the command is a year later, so that the clock of DEVICE may be set.
void ask(const Participant& participant, const Arguments& arguments) {
  std::mutex mutex;
  std::condition_variable came;
  std::map<std::string, std::string> answers;
  auto client = must(dds::CommandClient::create(participant, [&](const wire::WholeReply& reply) {
    const std::lock_guard lock{mutex};
    answers[reply.head.id().to_string()] = reply.head.text().to_string();
    came.notify_all();
  }));
  print("ready");
  int sent = 0;
  for (std::string line; std::getline(std::cin, line);) {
    wire::WholeCommand command;
    const std::string id = "ask-" + std::to_string(::getpid()) + "-" + std::to_string(++sent);
    command.head.id(id);
    command.head.device(arguments[0]);
    command.head.module_name("nobody");
    command.head.kind(COMMAND_STOP);
    command.head.deadline_ns(wall_ns() + std::chrono::nanoseconds{24h}.count() * 365);
    client.send(command);
    std::unique_lock lock{mutex};
    const bool answered = came.wait_for(lock, 5s, [&] { return answers.contains(id); });
    print(answered ? "answer " + answers[id] : "no answer");
  }
}

// Command `state MODULES`: publishes the states of MODULES modules twice. Then only asserts the liveliness of
// its writer, and disposes of the states when it reads the line "dispose"
void state(const Participant& participant, const Arguments& arguments) {
  auto writer = must(dds::Writer<LifecycleStatus>::create(participant));
  const std::size_t modules = std::stoul(arguments[0]);
  for (const std::uint64_t sequence : {1, 2}) {
    for (std::size_t module = 0; module < modules; ++module) writer.write(lifecycle_status(module, sequence));
  }
  print("failures " + std::to_string(writer.failures()));
  const Heartbeat beat{[&] { writer.assert_liveliness(); }};
  while (next_line() == "dispose") {
    for (std::size_t module = 0; module < modules; ++module) writer.dispose(lifecycle_status(module, 0));
    print("disposed");
  }
}

// Command `keys LENGTH`: publishes one state for each key length from 1 to LENGTH
void keys(const Participant& participant, const Arguments& arguments) {
  auto writer = must(dds::Writer<LifecycleStatus>::create(participant));
  std::vector<LifecycleStatus> states;
  for (std::size_t length = 1; length <= std::stoul(arguments[0]); ++length) {
    states.push_back(lifecycle_status(length, 1));
    states.back().path(std::string(length, 'k'));
  }
  for (LifecycleStatus& state : states) writer.write(state);
  const Heartbeat beat{[&] { writer.assert_liveliness(); }};
  print("ready");
  if (next_line() == "dispose") {
    for (const LifecycleStatus& state : states) writer.dispose(state);
    next_line();
  }
}

// Command `transitions MODULES COUNT`: publishes the first state of each module. After a line on standard
// input, publishes further states, until it has published COUNT states in total
void transitions(const Participant& participant, const Arguments& arguments) {
  auto writer = must(dds::Writer<LifecycleStatus>::create(participant));
  const std::size_t modules = std::stoul(arguments[0]);
  const std::size_t count = std::stoul(arguments[1]);
  for (std::size_t module = 0; module < modules; ++module) writer.write(lifecycle_status(module, 1));
  const Heartbeat beat{[&] { writer.assert_liveliness(); }};
  print("ready");
  next_line();
  std::size_t timeouts = 0;
  for (std::size_t written = modules; written < count; written += modules) {
    timeouts += writer.wait_acknowledged(5s) ? 0 : 1;
    for (std::size_t module = 0; module < modules; ++module)
      writer.write(lifecycle_status(module, written / modules + 1));
  }
  writer.wait_acknowledged(5s);
  print("written; failures " + std::to_string(writer.failures()) + ", timeouts " + std::to_string(timeouts));
  next_line();
}

// Command `server DEVICE BYTES [MS]`: answers each command to DEVICE after MS milliseconds, with BYTES bytes
// of data
void server(const Participant& participant, const Arguments& arguments) {
  const std::string data(std::stoul(arguments[1]), 'r');
  dds::CommandServer* self = nullptr;
  std::mutex mutex;
  std::unique_lock lock{mutex};
  auto server = must(
      dds::CommandServer::create(participant, arguments[0], "node", [&](const wire::WholeCommand& command) {
        const std::lock_guard created{mutex};
        print("handled " + command.head.id().to_string() + " " + std::to_string(command.data.size()));
        wire::WholeReply reply{.head = {}, .data = data};
        reply.head.id(command.head.id());
        reply.head.code(REPLY_OK);
        reply.head.value("for " + command.head.id().to_string());
        if (arguments.size() > 2)
          std::this_thread::sleep_for(std::chrono::milliseconds{std::stoi(arguments[2])});
        self->reply(reply);
      }));
  self = &server;
  lock.unlock();
  print("ready");
  while (next_line() == "refused") print("refused " + std::to_string(server.refused()));
}

// Command `client DEVICE ID BYTES`: sends DEVICE one command with BYTES bytes of data. Exits with 0 if the
// answer arrives
int client(const Participant& participant, const Arguments& arguments) {
  std::mutex mutex;
  std::condition_variable came;
  std::vector<wire::WholeReply> answers;
  auto client = must(dds::CommandClient::create(participant, [&](const wire::WholeReply& reply) {
    const std::lock_guard lock{mutex};
    answers.push_back(reply);
    came.notify_all();
  }));
  wire::WholeCommand command{.head = {}, .data = std::string(std::stoul(arguments[2]), 'c')};
  command.head.id(arguments[1]);
  command.head.device(arguments[0]);
  command.head.kind(COMMAND_REPORT);
  command.head.deadline_ns(wall_ns() + 20'000'000'000);
  const auto begin = std::chrono::steady_clock::now();
  client.send(command);
  std::unique_lock lock{mutex};
  if (!came.wait_for(lock, 20s, [&] { return !answers.empty(); })) return 1;
  if (answers[0].head.value() != "for " + arguments[1]) return 2;
  const auto time = std::chrono::steady_clock::now() - begin;
  print("answered " + std::to_string(answers[0].data.size()) + " after " +
        std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()));
  return 0;
}

std::vector<std::byte> nonsense(std::mt19937& random, const std::vector<std::byte>& good) {
  std::vector<std::byte> bytes = good;
  switch (random() % 4) {
    case 0:  // random bytes
      bytes.resize(4 + random() % 400);
      for (auto& each : bytes) each = static_cast<std::byte>(random());
      break;
    case 1:  // only the beginning of the valid sample
      bytes.resize(4 + random() % (bytes.size() - 4));
      break;
    case 2:  // the valid sample with up to four changed bytes
      for (int i = 0; i < 4; ++i) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
      break;
    default:  // the valid sample with impossible lengths
      for (std::size_t at = 4; at + 4 <= bytes.size(); at += 4) {
        if (random() % 8 == 0)
          std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), 4, std::byte{0xff});
      }
  }
  return bytes;
}

/// A DDS type that takes the name of another type, and whose samples are arbitrary bytes.
class ForgedType final : public dds::RawType {
 public:
  ForgedType(const std::string& name, bool keyed) : RawType(name, 70000, keyed) {}

 private:
  dds::rtps::InstanceHandle_t key_of(const dds::Bytes& bytes) override {
    dds::rtps::InstanceHandle_t key;
    for (std::size_t i = 0; i < 16; ++i)
      key.value[i] =
          static_cast<unsigned char>(i < bytes.size ? bytes.data[bytes.size - 1 - i] : std::byte{1});
    return key;
  }
};

std::vector<std::byte> bytes_of_hex(const std::string& hex) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

// Command `forge TOPIC TYPE KEYED COUNT HEX`: writes COUNT damaged variants of the valid sample HEX
// (hexadecimal digits). The type has a key if KEYED is "keyed"
void forge(const Participant& participant, const Arguments& arguments) {
  dds::OwnParticipant& mine = dds::own(*participant);
  const bool keyed = arguments[2] == "keyed";
  auto* topic = must(mine.topic(arguments[0], dds::fast::TypeSupport{new ForgedType{arguments[1], keyed}}));
  dds::fast::DataWriterQos qos;
  qos.reliability().kind = dds::fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind =
      keyed ? dds::fast::TRANSIENT_LOCAL_DURABILITY_QOS : dds::fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 32;
  qos.resource_limits().max_samples = 16384 * 32;
  qos.resource_limits().max_instances = 16384;
  qos.resource_limits().max_samples_per_instance = 32;
  qos.resource_limits().allocated_samples = 32;
  qos.data_sharing().off();
  dds::set_times(qos, 5ms);
  if (keyed) {
    qos.liveliness().kind = dds::fast::MANUAL_BY_TOPIC_LIVELINESS_QOS;
    qos.liveliness().lease_duration = dds::duration(300ms);
    qos.liveliness().announcement_period = dds::duration(100ms);
  }
  auto* writer = mine.make_writer(topic, qos, nullptr, dds::fast::StatusMask::none());
  dds::fast::PublicationMatchedStatus status;
  do {
    std::this_thread::sleep_for(10ms);
    writer->get_publication_matched_status(status);
  } while (status.current_count < 1);
  const std::vector<std::byte> good = bytes_of_hex(arguments[4]);
  std::mt19937 random{1};
  const int count = std::stoi(arguments[3]);
  for (int i = 0; i < count; ++i) {
    const auto bytes = nonsense(random, good);
    const dds::Bytes sample{bytes.data(), bytes.size()};
    dds::write_sample(*writer, &sample);
    if (i % 8 == 7) dds::wait_for_readers(*writer, 1s);
  }
  dds::wait_for_readers(*writer, 5s);
  print("forged");
  next_line();
  mine.end(writer);
  mine.release(topic);
}

/// Sends RTPS messages, which need not be valid, to all participants on loopback.
class Forger {
 public:
  Forger(unsigned domain, const dds::rtps::GuidPrefix_t& prefix) : domain_(domain), prefix_(prefix) {}
  Forger(const Forger&) = delete;
  Forger& operator=(const Forger&) = delete;
  ~Forger() { ::close(udp_); }

  /// Sends a message in the name of the participant with `prefix`. The message is one submessage that begins
  /// with `head` (its kind and flags) and contains `content`. Other submessages may come first in `head`.
  void send(const std::vector<std::byte>& head, const std::vector<std::byte>& content) const {
    std::vector<std::byte> message = bytes_of_hex("525450530203010f");
    const auto add = [&message](const auto& bytes) {
      for (const auto byte : bytes) message.push_back(static_cast<std::byte>(byte));
    };
    add(prefix_.value);
    add(head);
    add(std::array{content.size() & 0xff, content.size() >> 8});
    add(content);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (unsigned port = 0; port < 240; ++port) {
      to.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain_ + 10 + port));
      ::sendto(udp_, message.data(), message.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
  }

 private:
  unsigned domain_;
  dds::rtps::GuidPrefix_t prefix_;
  int udp_ = ::socket(AF_INET, SOCK_DGRAM, 0);
};

// Command `returning NAME`: publishes the status of device NAME ten times a second, and sends a HEARTBEAT of
// each writer with which this participant announces its other writers and readers, 300 times a second. Other
// participants that lose and rediscover this participant receive such a HEARTBEAT before they ask for
// anything
void returning(const Participant& participant, const Arguments& arguments) {
  dds::OwnParticipant& mine = dds::own(*participant);
  auto writer = must(dds::Writer<DeviceStatus>::create(participant));
  std::uint64_t sequence = 0;
  const Heartbeat beat{[&] { writer.write(device_status(arguments[0], ++sequence)); }};
  const Forger forger{mine.participant().get_domain_id(), mine.participant().guid().guidPrefix};
  std::atomic<bool> ending{false};
  std::thread heartbeats{[&] {
    while (!ending) {
      for (const std::string announcer : {"000003c2", "000004c2"}) {
        const std::string number = "0000000001000000";
        forger.send(bytes_of_hex("0701"),
                    bytes_of_hex("00000000" + announcer + number + number + "01000000"));
      }
      std::this_thread::sleep_for(3ms);
    }
  }};
  print("ready");
  next_line();
  ending = true;
  heartbeats.join();
}

// Command `deceive TOPIC RELIABILITY [TYPE]`: creates a writer of test::Sample, or of TYPE, which has a key
// and is kept for readers that join later. It writes no sample. For each input line "KIND FLAGS BEFORE AFTER
// ZEROS [TIME]", sends an RTPS message in the name of this writer to all participants on loopback. The
// message is one submessage that contains the bytes BEFORE, the ids of all readers and of the writer, the
// bytes AFTER, and ZEROS bytes of value 0. TIME, in seconds, is the time in the INFO_TS before it. KIND,
// FLAGS, BEFORE and AFTER are hexadecimal; BEFORE may be "-"
void deceive(const Participant& participant, const Arguments& arguments) {
  dds::OwnParticipant& mine = dds::own(*participant);
  const bool keyed = arguments.size() > 2;
  auto* topic = must(mine.topic(
      arguments[0], dds::fast::TypeSupport{new ForgedType{keyed ? arguments[2] : "test::Sample", keyed}}));
  dds::fast::DataWriterQos qos;
  if (keyed) qos.durability().kind = dds::fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.reliability().kind = arguments[1] == "reliable" ? dds::fast::RELIABLE_RELIABILITY_QOS
                                                      : dds::fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.data_sharing().off();
  auto* writer = mine.make_writer(topic, qos, nullptr, dds::fast::StatusMask::none());
  const dds::rtps::GUID_t& guid = writer->guid();
  const Forger forger{mine.participant().get_domain_id(), guid.guidPrefix};
  print("ready");
  for (std::string line = next_line(); line != "end"; line = next_line()) {
    std::istringstream words{line};
    std::string kind, flags, before, after;
    std::size_t zeros = 0;
    words >> kind >> flags >> before >> after >> zeros;
    std::vector<std::byte> content = bytes_of_hex(before);
    content.resize(content.size() + 4);
    for (const auto byte : guid.entityId.value) content.push_back(static_cast<std::byte>(byte));
    for (const std::byte byte : bytes_of_hex(after)) content.push_back(byte);
    content.resize(content.size() + zeros);
    std::vector<std::byte> head;
    if (std::uint32_t time = 0; words >> time) {
      head = bytes_of_hex("09010800");
      for (int i = 0; i < 8; ++i) head.push_back(static_cast<std::byte>(i < 4 ? time >> 8 * i : 0));
    }
    for (const std::byte byte : bytes_of_hex(kind + flags)) head.push_back(byte);
    forger.send(head, content);
    print("sent");
  }
  mine.end(writer);
  mine.release(topic);
}

// Command `doubt TOPIC`: creates a reader of test::Sample that acknowledges nothing, and waits for its
// writer. For each input line "KIND FLAGS AFTER", sends a submessage like `deceive`, in the name of this
// reader: the ids of the reader and of the writer, and the bytes AFTER
void doubt(const Participant& participant, const Arguments& arguments) {
  dds::OwnParticipant& mine = dds::own(*participant);
  auto* topic = must(mine.topic(arguments[0], dds::fast::TypeSupport{new ForgedType{"test::Sample", false}}));
  dds::fast::DataReaderQos qos;
  qos.reliability().kind = dds::fast::RELIABLE_RELIABILITY_QOS;
  qos.data_sharing().off();
  dds::set_times(qos, 1h);
  auto* reader = mine.make_reader(topic, qos, nullptr, dds::fast::StatusMask::none(), dds::Receives::alone);
  dds::fast::SubscriptionMatchedStatus status;
  do {
    std::this_thread::sleep_for(10ms);
    reader->get_subscription_matched_status(status);
  } while (status.current_count < 1);
  const dds::rtps::GUID_t writer = dds::rtps::iHandle2GUID(status.last_publication_handle);
  const dds::rtps::GUID_t guid = reader->guid();
  const Forger forger{mine.participant().get_domain_id(), guid.guidPrefix};
  print("ready");
  for (std::string line = next_line(); line != "end"; line = next_line()) {
    std::istringstream words{line};
    std::string kind, flags, after;
    words >> kind >> flags >> after;
    std::vector<std::byte> content;
    for (const auto* id : {&guid.entityId, &writer.entityId})
      for (const auto byte : id->value) content.push_back(static_cast<std::byte>(byte));
    for (const std::byte byte : bytes_of_hex(after)) content.push_back(byte);
    forger.send(bytes_of_hex(kind + flags), content);
    print("sent");
  }
  mine.end(reader);
  mine.release(topic);
}

dds::Quality quality(const std::string& reliability, const std::string& depth) {
  return {.reliable = reliability == "reliable",
          .depth = static_cast<std::uint32_t>(std::stoul(depth)),
          .deadline = {},
          .lifespan = {}};
}

// Command `tap TOPIC RELIABILITY DEPTH`: prints the number in each sample that it receives
void tap(const Participant& participant, const Arguments& arguments) {
  auto tap = must(dds::Tap::create(participant, flow(arguments[0], quality(arguments[1], arguments[2])),
                                   [](const std::byte* bytes, std::size_t size, std::int64_t) {
                                     print((is_whole(bytes, size) ? "sample " : "torn ") +
                                           std::to_string(number_in(bytes)));
                                   }));
  print("ready");
  while (next_line() == "health") {
    const wire::FlowHealth health = tap->health();
    print("matched " + std::to_string(health.matched) + " samples " + std::to_string(health.samples) +
          " lost " + std::to_string(health.lost) + " refused " + std::to_string(health.refused) +
          " incompatible " + health.incompatible);
  }
}

// Command `feed TOPIC RELIABILITY DEPTH`: for each input line "N", writes N samples without data; for each
// line "N BYTES", writes N samples with BYTES bytes of data
void feed(const Participant& participant, const Arguments& arguments) {
  auto feed = must(dds::Feed::create(participant, flow(arguments[0], quality(arguments[1], arguments[2]))));
  print("ready");
  std::uint64_t number = 0;
  for (std::string line = next_line(); line != "end"; line = next_line()) {
    std::istringstream words{line};
    std::uint64_t count = 0;
    std::uint32_t data = 0;
    words >> count >> data;
    for (; count > 0; --count) {
      ++number;
      const auto bytes = bytes_of(number, static_cast<std::int64_t>(number), data);
      feed->write(bytes.data(), bytes.size());
      if (data == 0) std::this_thread::sleep_for(100us);
    }
    const wire::FlowHealth health = feed->health();
    print("written " + std::to_string(number) + " failures " + std::to_string(health.failures) + " matched " +
          std::to_string(health.matched) + " incompatible " + health.incompatible);
  }
}

dds::Flow flow_of_file(const Arguments& arguments) {
  std::ifstream file{arguments[3]};
  const std::string text{std::istreambuf_iterator<char>{file}, {}};
  return {.topic = arguments[0],
          .type = must(model::parse_type(text)),
          .quality = quality(arguments[1], arguments[2])};
}

// Command `show TOPIC RELIABILITY DEPTH FILE`: prints each received sample as JSON. FILE describes the type
void show(const Participant& participant, const Arguments& arguments) {
  const dds::Flow flow = flow_of_file(arguments);
  auto tap = must(
      dds::Tap::create(participant, flow, [&flow](const std::byte* bytes, std::size_t size, std::int64_t) {
        print(model::sample_json(flow.type, bytes, size));
      }));
  print("ready");
  while (next_line() == "health") print("refused " + std::to_string(tap->health().refused));
}

// Command `give TOPIC RELIABILITY DEPTH FILE`: writes the samples that it reads as JSON, one per input line.
// FILE describes the type
void give(const Participant& participant, const Arguments& arguments) {
  const dds::Flow flow = flow_of_file(arguments);
  auto feed = must(dds::Feed::create(participant, flow));
  print("ready");
  for (std::string line = next_line(); line != "end"; line = next_line()) {
    const auto bytes = must(model::sample_bytes(flow.type, line));
    print(feed->write(bytes.data(), bytes.size()) ? "written" : "failed");
  }
}

// Command `statistics MODULE`: publishes the statistics of MODULE every 100 ms
void statistics(const Participant& participant, const Arguments& arguments) {
  auto writer = must(dds::Writer<ModuleStatistics>::create(participant));
  ModuleStatistics sample;
  sample.path("test/device/" + arguments[0]);
  sample.cell("test");
  sample.device("device");
  sample.name(arguments[0]);
  sample.overruns(7);
  sample.jitter_us().mean(-1.5);
  sample.run_us().p99(12.25);
  const Heartbeat beat{[&] {
    sample.cycles(sample.cycles() + 100);
    writer.write(sample);
  }};
  print("ready");
  next_line();
}

// Command `echo TOPIC BACK RELIABILITY`: sends each sample of TOPIC back on the topic BACK, in the receive
// thread of Fast DDS
void echo(const Participant& participant, const Arguments& arguments) {
  const dds::Quality same = quality(arguments[2], "1");
  auto back = must(dds::Feed::create(participant, flow(arguments[1], same)));
  auto there = must(dds::Tap::create(
      participant, flow(arguments[0], same),
      [&back](const std::byte* bytes, std::size_t size, std::int64_t) { back->write(bytes, size); }));
  print("ready");
  next_line();
}

// Command `all`: creates an entity of each kind, and prints "ready" after its readers have received 20
// samples
void all(const Participant& participant, const Arguments&) {
  auto devices = must(dds::Writer<DeviceStatus>::create(participant));
  auto modules = must(dds::Writer<LifecycleStatus>::create(participant));
  auto statistics = must(dds::Writer<ModuleStatistics>::create(participant));
  std::atomic<int> heard{0};
  auto reader = must(dds::Reader<DeviceStatus>::create(
      participant, {.sample = [&heard](const DeviceStatus&, wire::WriterId) { ++heard; }}));
  auto back = must(dds::Feed::create(
      participant, flow("all", {.reliable = true, .depth = 8, .deadline = {}, .lifespan = {}})));
  auto tap = must(dds::Tap::create(
      participant, flow("all", {.reliable = true, .depth = 8, .deadline = {}, .lifespan = {}}),
      [&heard](const std::byte*, std::size_t, std::int64_t) { ++heard; }));
  std::uint64_t sequence = 0;
  const Heartbeat beat{[&] {
    ++sequence;
    devices.write(device_status("all", sequence));
    modules.write(lifecycle_status(1, sequence));
    const auto bytes = bytes_of(sequence, 0, 30000);
    back->write(bytes.data(), bytes.size());
  }};
  while (heard < 20) std::this_thread::sleep_for(10ms);
  print("ready");
  next_line();
}

Result<Participant> participate(int domain) {
  dds::ParticipantOptions options{
      .name = "peer", .domain = domain, .discovery = {}, .interfaces = {"127.0.0.1"}};
  if (const char* given = std::getenv("PEER_INTERFACES")) {
    options.interfaces.clear();
    std::istringstream list{given};
    for (std::string each; std::getline(list, each, ',');) {
      if (each != "all") options.interfaces.push_back(each);
    }
  }
  if (const char* given = std::getenv("PEER_DISCOVERY")) {
    const std::string text{given};
    const std::string kind = text.substr(0, text.find('='));
    const std::string place = text.substr(std::min(text.size(), kind.size() + 1));
    if (kind == "peers") {
      options.discovery.kind = model::Discovery::Kind::peers;
      options.discovery.peers = {place};
    } else if (kind == "server" || kind == "serve") {
      options.discovery.kind = model::Discovery::Kind::server;
      options.discovery.server = place;
      options.discovery.serve = kind == "serve";
    }
  }
  if (const char* given = std::getenv("PEER_SECURITY")) options.security = given;
  options.refused = [](const std::string& text) { print("notice " + text); };
  return dds::Participant::create(options);
}

int run(int domain, const std::string& command, const Arguments& arguments) {
  const Participant participant = must(participate(domain));
  const std::map<std::string, std::function<void(const Participant&, const Arguments&)>> commands{
      {"device", device},
      {"stop", stop},
      {"ask", ask},
      {"state", state},
      {"transitions", transitions},
      {"server", server},
      {"forge", forge},
      {"tap", tap},
      {"feed", feed},
      {"echo", echo},
      {"show", show},
      {"give", give},
      {"statistics", statistics},
      {"all", all},
      {"keys", keys},
      {"deceive", deceive},
      {"doubt", doubt},
      {"returning", returning},
      {"watch", watch}};
  int status = 0;
  if (command == "client") {
    status = client(participant, arguments);
  } else if (const auto found = commands.find(command); found != commands.end()) {
    found->second(participant, arguments);
  } else {
    status = 2;
  }
  return status;
}

}  // namespace
}  // namespace takt::dds_test

// Replaces the function of Fast DDS that checks whether a participant may create a writer. If PEER_CHEATS is
// set, this process ignores its own permissions, as a manipulated program would. Then other participants must
// reject its samples.
#define CHECK_WRITER                                                                                     \
  TAKT_RTPS                                                                                              \
  "8security11Permissions23check_create_datawriterERKNS2_6HandleEjRKNSt7__cxx1112basic_stringIcSt11char" \
  "_traitsIcESaIcEEERKSt6vectorISC_SaISC_EERNS2_17SecurityExceptionE"
extern "C" bool ignores_own_permissions(const void* permissions, const void* handle, std::uint32_t domain,
                                        const std::string& topic, const std::vector<std::string>& partitions,
                                        void* why) __asm__(CHECK_WRITER);
extern "C" __attribute__((visibility("default"))) bool ignores_own_permissions(
    const void* permissions, const void* handle, std::uint32_t domain, const std::string& topic,
    const std::vector<std::string>& partitions, void* why) {
  if (std::getenv("PEER_CHEATS") != nullptr) return true;
  static auto* const original =
      takt::dds::replaced<bool(const void*, const void*, std::uint32_t, const std::string&,
                               const std::vector<std::string>&, void*)>(CHECK_WRITER);
  return original(permissions, handle, domain, topic, partitions, why);
}

int main(int count, char** words) {
  if (count < 3) return 2;
  return takt::dds_test::run(std::atoi(words[1]), words[2], {words + 3, words + count});
}
