#include <takt/dds/commands.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <takt/wire/taktPubSubTypes.h>
#include <takt/wire/assembly.hpp>
#include <takt/wire/compression.hpp>
#include <takt/wire/question.hpp>
#include <takt/wire/rate_limit.hpp>
#include <takt/wire/validation.hpp>
#include <takt/wire/words.hpp>
#include "discovery_listener.hpp"
#include "inside.hpp"
#include "workarounds/checked_type.hpp"

namespace takt::dds {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::int32_t kDepth = 128;
constexpr std::size_t kPaced = kDepth / 2;  // number of parts that are sent before the sender waits for
                                            // acknowledgements
constexpr std::size_t kRemembered = 256;    // maximum number of commands that the server remembers: waiting,
                                            // executing or answered
// The limit, in bytes, for the data of all waiting commands. The same limit applies to the data of all kept
// replies.
constexpr std::size_t kMostWaitingBytes = 4 * wire::kMaxData;
constexpr auto kResend = milliseconds{1000};
constexpr auto kSlowestResend = milliseconds{8000};  // each pause is twice as long as the one before
constexpr auto kAcknowledge = milliseconds{2000};
// The time that the server waits for the client's reader to match. After this time, the server sends the
// reply without a match.
constexpr auto kMatchWait = milliseconds{3000};
constexpr Nanoseconds kCommandHeartbeat = milliseconds{10};

std::int64_t wall_ns() {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

template <class Qos>
void set_command_quality(Qos& qos) {
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kDepth;
  qos.resource_limits().max_samples = kDepth;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kDepth;
  qos.resource_limits().allocated_samples = 4;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
}

/// Writes a command or reply in parts. Waits for acknowledgements after every kPaced parts, because the
/// writer's history keeps only kDepth samples.
template <class Whole>
bool write_parts(fast::DataWriter& writer, const Whole& whole) {
  auto head = whole.head;
  const std::size_t parts = std::max<std::size_t>(1, (whole.data.size() + wire::kPart - 1) / wire::kPart);
  head.parts(static_cast<std::uint32_t>(parts));
  for (std::size_t i = 0; i < parts; ++i) {
    head.part(static_cast<std::uint32_t>(i));
    const auto begin = whole.data.begin() + static_cast<std::ptrdiff_t>(i * wire::kPart);
    const auto end =
        whole.data.begin() + static_cast<std::ptrdiff_t>(std::min(whole.data.size(), (i + 1) * wire::kPart));
    head.data(std::vector<std::uint8_t>(begin, end));
    if (!write_sample(writer, &head)) return false;
    if (i % kPaced == kPaced - 1) wait_for_readers(writer, kAcknowledge);
  }
  return true;
}

/// The two ends of a command connection: a writer of one topic and a reader of one or two other topics.
class Ends {
 public:
  explicit Ends(std::shared_ptr<Participant> participant) : participant_(std::move(participant)) {}
  ~Ends() { end(); }

  /// Creates a writer of topic `out` and a reader of topic `in`. `also_in` is another topic to read, with the
  /// same type as `in`, or null.
  Result<void> begin(const char* out, const fast::TypeSupport& out_type, const char* in,
                     const fast::TypeSupport& in_type, const char* also_in,
                     fast::DataWriterListener* writer_listener, fast::DataReaderListener* reader_listener) {
    OwnParticipant& mine = own(*participant_);
    auto topic = mine.topic(out, out_type);
    if (!topic) return topic.problems();
    out_topic_ = *topic;
    topic = mine.topic(in, in_type);
    if (!topic) return topic.problems();
    in_topic_ = *topic;
    if (also_in != nullptr) {
      topic = mine.topic(also_in, in_type);
      if (!topic) return topic.problems();
      also_in_topic_ = *topic;
    }
    undecoded_ = &undecoded(mine.participant(), *in_topic_);
    return make(writer_listener, reader_listener);
  }

  /// Deletes the writer and the readers. When this function has returned, no listener is called any more.
  void end() {
    own(*participant_).end(reader_);
    own(*participant_).end(also_reader_);
    own(*participant_).end(writer_);
    for (fast::Topic** topic : {&in_topic_, &also_in_topic_, &out_topic_}) {
      if (*topic != nullptr) own(*participant_).release(*topic);
      *topic = nullptr;
    }
  }

  template <class Whole>
  void write(const Whole& whole) {
    write_parts(*writer_, whole);
  }
  [[nodiscard]] OwnParticipant& participant() noexcept { return own(*participant_); }
  [[nodiscard]] std::uint64_t not_decoded() const {
    return undecoded_->count.load(std::memory_order_relaxed);
  }

 private:
  Result<void> make(fast::DataWriterListener* writer_listener, fast::DataReaderListener* reader_listener) {
    OwnParticipant& mine = own(*participant_);
    fast::DataWriterQos writer_qos;
    set_command_quality(writer_qos);
    writer_qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
    set_times(writer_qos, kCommandHeartbeat);
    writer_ =
        mine.make_writer(out_topic_, writer_qos, writer_listener, fast::StatusMask::publication_matched());
    fast::DataReaderQos reader_qos;
    set_command_quality(reader_qos);
    set_times(reader_qos, Nanoseconds{0});
    reader_ = mine.make_reader(in_topic_, reader_qos, reader_listener, fast::StatusMask::data_available(),
                               Receives::alone);
    if (also_in_topic_ != nullptr) {
      also_reader_ = mine.make_reader(also_in_topic_, reader_qos, reader_listener,
                                      fast::StatusMask::data_available(), Receives::alone);
    }
    if (writer_ == nullptr || reader_ == nullptr || (also_in_topic_ != nullptr && also_reader_ == nullptr))
      return fail("DDS could not create a writer and a reader for commands",
                  "see the message that DDS printed");
    return {};
  }

  std::shared_ptr<Participant> participant_;
  fast::Topic* out_topic_ = nullptr;
  fast::Topic* in_topic_ = nullptr;
  fast::Topic* also_in_topic_ = nullptr;
  fast::DataWriter* writer_ = nullptr;
  fast::DataReader* reader_ = nullptr;
  fast::DataReader* also_reader_ = nullptr;
  Undecoded* undecoded_ = nullptr;
};

std::uint64_t participant_of(const rtps::InstanceHandle_t& handle) {
  rtps::GuidPrefix_t prefix;
  for (std::size_t i = 0; i < 12; ++i) prefix.value[i] = handle.value[i];
  return number_of(prefix);
}

}  // namespace

// ---- CommandServer, in a node

struct CommandServer::Inside final : fast::DataReaderListener, fast::DataWriterListener {
  struct Asked {
    std::uint64_t client = 0;  // identifies the client's participant
    bool answered = false;
    wire::WholeReply reply;
  };
  struct Outgoing {
    wire::WholeReply reply;
    std::uint64_t client = 0;
    Clock::time_point since;
  };

  std::string device;
  std::string node;
  std::function<void(const wire::WholeCommand&)> handle;

  std::mutex mutex;
  std::condition_variable changed;
  bool ending = false;
  wire::Assembly<Command, wire::WholeCommand> assembly;
  std::deque<wire::WholeCommand> to_handle;
  std::size_t to_handle_bytes = 0;
  std::deque<Outgoing> to_send;
  std::map<std::string, Asked> asked;
  std::deque<std::string> asked_order;
  std::size_t answer_bytes = 0;
  std::uint64_t invalid = 0;
  std::uint64_t over_limit = 0;
  wire::RateLimit rate_limit;
  std::multiset<std::uint64_t> matched;  // the participant of each matched reader of replies
  std::thread handler;
  std::thread sender;
  Ends ends;

  explicit Inside(std::shared_ptr<Participant> participant) : ends(std::move(participant)) {}
  ~Inside() override {
    {
      const std::lock_guard lock{mutex};
      ending = true;
    }
    changed.notify_all();
    if (handler.joinable()) handler.join();
    if (sender.joinable()) sender.join();
    ends.end();
  }

  void on_data_available(fast::DataReader* from) override {
    Command command;
    fast::SampleInfo info;
    while (take_sample(*from, &command, info)) {
      if (!info.valid_data) continue;
      const std::lock_guard lock{mutex};
      if (!wire::validate(command)) {
        ++invalid;
        continue;
      }
      if (device != command.device().c_str()) continue;
      if (command.node().size() != 0 && node != command.node().c_str()) continue;
      const rtps::GuidPrefix_t& prefix = info.sample_identity.writer_guid().guidPrefix;
      const std::uint64_t client = number_of(prefix);
      // The rate limit counts only the first part of a command. If the first part is rejected, the other
      // parts have no effect.
      if (command.part() == 0 && !rate_limit.admit(client, Clock::now())) {
        ++over_limit;
        ends.participant().notices().tell(
            "rejected a command: more than " +
            std::to_string(static_cast<int>(wire::RateLimit::kEach.per_second)) +
            " commands per second from one client, or " +
            std::to_string(static_cast<int>(wire::RateLimit::kAll.per_second)) + " in total");
        continue;
      }
      wire::WholeCommand whole;
      if (!assembly.add(command, std::to_string(client) + '/' + command.id().c_str(), whole)) continue;
      DiscoveryListener* const listener = ends.participant().discovery_listener();
      if (listener != nullptr) whole.who = listener->who(prefix);
      const bool is_observer = from->get_topicdescription()->get_name() == security::kQuestionTopic;
      if (is_observer && listener != nullptr && !wire::is_question(command.kind()))
        refuse(std::move(whole), client, listener->who(prefix));
      else
        arrived(std::move(whole), client);
    }
  }

  void refuse(wire::WholeCommand command, std::uint64_t client, const std::string& who) {
    ends.participant().notices().tell("rejected: " + who + " asked to " + to_text(command.head.kind()) +
                                      ", which only an operator may do");
    const std::string id = command.head.id().to_string();
    if (asked.contains(id)) return arrived(std::move(command), client);  // sends the first reply again
    if (!make_room(0)) return;
    asked[id].client = client;
    asked_order.push_back(id);
    wire::WholeReply reply;
    reply.head.id(id);
    reply.head.code(REPLY_REFUSED);
    reply.head.text((who + " may only observe, not " + to_text(command.head.kind())).substr(0, 255));
    answered(reply);
  }

  void damaged(const Command& command) {
    ++invalid;
    wire::WholeReply reply;
    reply.head.id(command.id());
    reply.head.code(REPLY_REFUSED);
    reply.head.text("the data of the command are damaged, or longer than 16 MiB");
    answered(reply);
  }

  void arrived(wire::WholeCommand command, std::uint64_t client) {
    const std::string id = command.head.id().to_string();
    if (const auto found = asked.find(id); found != asked.end()) {
      found->second.client = client;
      if (found->second.answered) to_send.push_back({found->second.reply, client, Clock::now()});
    } else if (make_room(command.data.size())) {
      asked[id].client = client;
      asked_order.push_back(id);
      to_handle_bytes += command.data.size();
      to_handle.push_back(std::move(command));
    }  // otherwise the server drops the command, and the client sends it again
    changed.notify_all();
  }

  // Forgets an answered command if necessary, so that one more command can be accepted. Returns false if too
  // many commands are still unanswered.
  bool make_room(std::size_t bytes) {
    if (to_handle_bytes + bytes > kMostWaitingBytes) return false;
    if (asked_order.size() < kRemembered) return true;
    return forget_an_answer();
  }
  bool forget_an_answer() {
    const auto oldest = std::find_if(asked_order.begin(), asked_order.end(),
                                     [this](const std::string& id) { return asked[id].answered; });
    if (oldest == asked_order.end()) return false;
    answer_bytes -= asked[*oldest].reply.data.size();
    asked.erase(*oldest);
    asked_order.erase(oldest);
    return true;
  }

  void answered(const wire::WholeReply& reply) {
    const auto found = asked.find(reply.head.id().to_string());
    if (found == asked.end() || found->second.answered) return;
    wire::WholeReply full = reply;
    full.head.device(device.c_str());
    full.head.node(node.c_str());
    if (full.data.size() > wire::kMaxData) {
      full.data.clear();
      full.head.code(REPLY_FAILED);
      full.head.text("the reply is longer than 16 MiB");
    }
    to_send.push_back({full, found->second.client, Clock::now()});
    answer_bytes += full.data.size();
    found->second.reply = std::move(full);
    while (answer_bytes > kMostWaitingBytes && forget_an_answer()) {
    }
    found->second.answered = true;  // set last, so that the loop above does not forget this reply
    changed.notify_all();
  }

  void on_publication_matched(fast::DataWriter*, const fast::PublicationMatchedStatus& status) override {
    const std::lock_guard lock{mutex};
    const std::uint64_t who = participant_of(status.last_subscription_handle);
    if (status.current_count_change > 0) {
      matched.insert(who);
    } else if (const auto found = matched.find(who); found != matched.end()) {
      matched.erase(found);
    }
    changed.notify_all();
  }

  void serve() {
    std::unique_lock lock{mutex};
    while (!ending) {
      if (to_handle.empty()) {
        changed.wait(lock);
        continue;
      }
      wire::WholeCommand command = std::move(to_handle.front());
      to_handle.pop_front();
      to_handle_bytes -= command.data.size();
      lock.unlock();
      // Not on the thread of DDS, because anyone on the network may send a short stream of very long data.
      auto data = wire::unpacked(std::move(command.data));
      if (data) {
        command.data = *std::move(data);
        handle(command);
      }
      lock.lock();
      if (!data) damaged(command.head);
    }
  }

  // Sends the replies. Holds each reply until the client's reader has matched, because a reply sent before
  // the match would be lost.
  void send() {
    std::unique_lock lock{mutex};
    while (!ending) {
      const auto now = Clock::now();
      const auto found = std::find_if(to_send.begin(), to_send.end(), [&](const Outgoing& each) {
        return matched.count(each.client) > 0 || now - each.since > kMatchWait;
      });
      if (found == to_send.end()) {
        if (to_send.empty())
          changed.wait(lock);
        else
          changed.wait_for(lock, milliseconds{50});
        continue;
      }
      const wire::WholeReply reply = std::move(found->reply);
      to_send.erase(found);
      lock.unlock();
      ends.write(reply);
      lock.lock();
    }
  }
};

Result<CommandServer> CommandServer::create(std::shared_ptr<Participant> participant, std::string device,
                                            std::string node,
                                            std::function<void(const wire::WholeCommand&)> handle) {
  auto inside = std::make_unique<Inside>(std::move(participant));
  inside->device = std::move(device);
  inside->node = std::move(node);
  inside->handle = std::move(handle);
  // Without security, all clients have the same rights and use takt/command, so the server does not read
  // takt/question.
  const char* questions =
      inside->ends.participant().discovery_listener() == nullptr ? nullptr : security::kQuestionTopic;
  if (auto made = inside->ends.begin("takt/reply", fast::TypeSupport{new CheckedType<ReplyPubSubType>},
                                     "takt/command", fast::TypeSupport{new CheckedType<CommandPubSubType>},
                                     questions, inside.get(), inside.get());
      !made) {
    return made.problems();
  }
  inside->handler = std::thread{[me = inside.get()] { me->serve(); }};
  inside->sender = std::thread{[me = inside.get()] { me->send(); }};
  return CommandServer{std::move(inside)};
}

CommandServer::CommandServer(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}
CommandServer::CommandServer(CommandServer&&) noexcept = default;
CommandServer& CommandServer::operator=(CommandServer&&) noexcept = default;
CommandServer::~CommandServer() = default;

void CommandServer::reply(const wire::WholeReply& reply) {
  const std::lock_guard lock{inside_->mutex};
  inside_->answered(reply);
}

std::uint64_t CommandServer::refused() const {
  const std::lock_guard lock{inside_->mutex};
  return inside_->invalid + inside_->over_limit + inside_->assembly.refused() + inside_->ends.not_decoded();
}

// ---- CommandClient, in a client

struct CommandClient::Inside final : fast::DataReaderListener, fast::DataWriterListener {
  struct Open {
    wire::WholeCommand command;
    Clock::time_point again;
    milliseconds pause = kResend;
    int sent = 0;  // number of times that the command was sent
  };

  std::function<void(const wire::WholeReply&)> on_reply;
  std::mutex mutex;
  std::condition_variable changed;
  bool ending = false;
  int matched = 0;
  wire::Assembly<Reply, wire::WholeReply> assembly;
  std::map<std::string, Open> open;
  std::thread sender;
  Ends ends;

  explicit Inside(std::shared_ptr<Participant> participant) : ends(std::move(participant)) {}
  ~Inside() override {
    {
      const std::lock_guard lock{mutex};
      ending = true;
    }
    changed.notify_all();
    if (sender.joinable()) sender.join();
    ends.end();
  }

  void on_data_available(fast::DataReader* from) override {
    Reply reply;
    fast::SampleInfo info;
    while (take_sample(*from, &reply, info)) {
      if (!info.valid_data || !wire::validate(reply)) continue;
      DiscoveryListener* const listener = ends.participant().discovery_listener();
      const rtps::GUID_t& writer = info.sample_identity.writer_guid();
      if (listener != nullptr && !listener->is_device(writer, reply.device().to_string())) {
        listener->impostor(writer, "takt/reply", reply.device().to_string());
        continue;
      }
      wire::WholeReply whole;
      {
        const std::lock_guard lock{mutex};
        // Every client receives the replies to all clients. Ignore replies to commands that this client did
        // not send.
        const auto mine = open.find(reply.id().c_str());
        if (mine == open.end()) continue;
        const std::string key = std::string{reply.id().c_str()} + '/' + reply.node().c_str();
        if (!assembly.add(reply, key, whole)) continue;
        open.erase(mine);
      }
      on_reply(whole);
    }
  }

  void on_publication_matched(fast::DataWriter*, const fast::PublicationMatchedStatus& status) override {
    const std::lock_guard lock{mutex};
    matched = status.current_count;
    if (status.current_count_change > 0) {  // a new node gets the open commands at once
      for (auto& each : open) each.second.again = Clock::now();
    }
    changed.notify_all();
  }

  void send() {
    std::unique_lock lock{mutex};
    while (!ending) {
      const auto now = Clock::now();
      const std::int64_t wall = wall_ns();
      // A command that was sent before its deadline is repeated even after the deadline, because a node may
      // have executed the command while its reply was lost.
      const auto due = std::find_if(open.begin(), open.end(), [&](const auto& each) {
        const Open& one = each.second;
        return matched > 0 && one.again <= now && (one.sent > 0 || one.command.head.deadline_ns() >= wall);
      });
      if (due == open.end()) {
        if (open.empty())
          changed.wait(lock);
        else
          changed.wait_for(lock, milliseconds{20});
        continue;
      }
      const wire::WholeCommand command = due->second.command;
      // Over a slow link, the reply may be on its way; each copy of the command causes a copy of the reply.
      due->second.again = now + due->second.pause;
      due->second.pause = std::min(2 * due->second.pause, kSlowestResend);
      ++due->second.sent;
      lock.unlock();
      ends.write(command);
      lock.lock();
    }
  }
};

Result<CommandClient> CommandClient::create(std::shared_ptr<Participant> participant,
                                            std::function<void(const wire::WholeReply&)> on_reply) {
  auto inside = std::make_unique<Inside>(std::move(participant));
  inside->on_reply = std::move(on_reply);
  DiscoveryListener* const listener = inside->ends.participant().discovery_listener();
  const bool is_observer = listener != nullptr && listener->mine().subject.role == security::Role::observer;
  const char* const topic = is_observer ? security::kQuestionTopic : "takt/command";
  if (auto made = inside->ends.begin(topic, fast::TypeSupport{new CheckedType<CommandPubSubType>},
                                     "takt/reply", fast::TypeSupport{new CheckedType<ReplyPubSubType>},
                                     nullptr, inside.get(), inside.get());
      !made) {
    return made.problems();
  }
  inside->sender = std::thread{[me = inside.get()] { me->send(); }};
  return CommandClient{std::move(inside)};
}

CommandClient::CommandClient(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}
CommandClient::CommandClient(CommandClient&&) noexcept = default;
CommandClient& CommandClient::operator=(CommandClient&&) noexcept = default;
CommandClient::~CommandClient() = default;

bool CommandClient::send(const wire::WholeCommand& command) {
  if (command.data.size() > wire::kMaxData) return false;
  const wire::WholeCommand sent{.head = command.head, .data = wire::packed(command.data)};
  const std::lock_guard lock{inside_->mutex};
  inside_->open[command.head.id().to_string()] = {
      .command = sent,
      .again = Clock::now(),
      .pause = sent.data.size() > wire::kPart ? 2 * kResend : kResend};
  inside_->changed.notify_all();
  return true;
}

int CommandClient::sent(const std::string& id) const {
  const std::lock_guard lock{inside_->mutex};
  const auto found = inside_->open.find(id);
  return found == inside_->open.end() ? 0 : found->second.sent;
}

bool CommandClient::is_too_late(const std::string& id) {
  const std::lock_guard lock{inside_->mutex};
  const auto found = inside_->open.find(id);
  if (found == inside_->open.end() || found->second.sent > 0 ||
      found->second.command.head.deadline_ns() >= wall_ns())
    return false;
  inside_->open.erase(found);
  return true;
}

void CommandClient::forget(const std::string& id) {
  const std::lock_guard lock{inside_->mutex};
  inside_->open.erase(id);
}

}  // namespace takt::dds
