// Sends a node forged commands and forged states of other nodes, complete or in parts, while events happen on
// the device. The node must answer each valid command exactly once. Every message that the node publishes
// must pass the checks of validation.hpp.
//
// An input is a list of steps. Each step begins with a letter, which selects the action (see Play).
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include <takt/core/check.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/wire/assembly.hpp>
#include <takt/wire/validation.hpp>

#include "bytes.hpp"
#include "tests/cdr.hpp"
#include "tests/unit/agent/fake_device.hpp"

namespace {

using namespace takt;
/// Decodes a sample as the generated type support and dds/checked_type.hpp do. Returns false if the bytes are
/// invalid.
template <class T>
bool decode(std::string_view bytes, T& value) {
  try {
    cdr::decode(bytes, value);
    return true;
  } catch (...) {
    return false;
  }
}

template <class T>
void check_same_again(const T& value) {
  const auto bytes = cdr::encoded(value, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN);
  T again;
  TAKT_CHECK(decode({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, again) && again == value);
}

/// Decodes and validates a sample. Returns false if the sample is invalid.
template <class T>
bool take(std::string_view bytes, T& value) {
  if (!decode(bytes, value) || !wire::validate(value)) return false;
  T again = value;
  TAKT_CHECK(wire::validate(again) && again == value);
  check_same_again(value);
  return true;
}

template <class T>
void check_valid(const T& published) {
  T copy = published;
  TAKT_CHECK(wire::validate(copy));
  TAKT_CHECK(copy == published);
}

class Play {
 public:
  explicit Play(fuzz::Bytes bytes) : bytes_(bytes) {}

  void run() {
    for (std::size_t steps = 0; !bytes_.empty() && steps < kMostSteps; ++steps) step(bytes_.take<char>());
    end();
    check_published();
  }

 private:
  static constexpr std::size_t kMostSteps = 200;

  void step(char letter) {
    switch (letter) {
      case 'c':
        return command(bytes_.take_counted());
      case 'd':
        return other<DeviceStatus>();
      case 'm':
        return other<LifecycleStatus>();
      case 't':
        return device_.pass(std::chrono::milliseconds{1U << bytes_.take<std::uint8_t>() % 16});
      case 'i':
        return inspected(found());
      case 'f':
        return inspected(fail("a component is missing", "build it"));
      case 'r':
        return phase(agent::Supervised::Phase::ready);
      case 'e':
        return phase(agent::Supervised::Phase::ended);
      case 's':
        return stepped(static_cast<lifecycle::State>(bytes_.take<std::uint8_t>() % 6));
      case 'o':
        return outcomes(bytes_.take<std::uint8_t>());
      case 'g':
        device_.agent.others().remove(heard_, 1);
        return device_.agent.step();
      case 'l':
        device_.agent.others().lost(1);
        return device_.agent.step();
      default:
        return;
    }
  }

  void command(std::string_view bytes) {
    Command part;
    if (!take(bytes, part)) return;
    wire::WholeCommand whole;
    const bool all = assembly_.add(part, part.id().to_string(), whole);
    TAKT_CHECK(assembly_.bytes() <= assembly_.kMostBytes);
    if (!all) return;
    ++asked_;
    device_.receive(whole);
  }
  template <class Status>
  void other() {
    Status status;
    if (!take(bytes_.take_counted(), status)) return;
    if constexpr (std::is_same_v<Status, DeviceStatus>) {
      heard_ = status;
      device_.agent.receive(status, 1, device_.now);
    } else {
      device_.agent.others().receive(status);
    }
    device_.agent.step();
  }

  // Returns the result of an inspection as a real inspection would: one path for each module of the device.
  [[nodiscard]] agent::Inspected found() const {
    agent::Inspected inspected{
        .paths = {}, .description = R"({"modules":[{"name":"servo","properties":[{"name":"gain"}]}]})"};
    if (device_.work.inspections.empty()) return inspected;
    const agent::InspectionRequest& request = device_.work.inspections.back();
    const auto cell = descriptor::parse(request.text, request.file);
    for (const model::Device& device : cell ? cell->devices : std::vector<model::Device>{}) {
      for (const model::Module& module : device.modules)
        if (device.name == request.device) inspected.paths.push_back("/" + module.filename);
    }
    return inspected;
  }
  void inspected(Result<agent::Inspected> result) {
    device_.work.inspected = std::move(result);
    device_.agent.step();
    device_.work.inspected.reset();
  }
  // Moves the deployment to the phase `to`. Does nothing if the deployment has passed this phase.
  void phase(agent::Supervised::Phase to) {
    if (device_.work.supervised == 0 || device_.work.phase > to) return;
    // A deployment completes all pending requests before it ends.
    while (to == agent::Supervised::Phase::ended && !device_.work.done.empty()) outcomes(REPLY_FAILED);
    device_.work.phase = to;
    device_.agent.step();
    if (device_.work.supervised == 0) device_.work.phase = agent::Supervised::Phase::preparing;
  }
  void stepped(lifecycle::State state) {
    if (device_.work.supervised == 0 || device_.work.paths.empty()) return;
    device_.work.stepped({.module = 0, .transition = {.to = state}});
  }
  void outcomes(std::uint8_t code) {
    for (const auto& done : std::exchange(device_.work.done, {}))
      done({.code = static_cast<ReplyCode>(code % 3), .state = lifecycle::State::start, .text = "so it is"});
    device_.agent.step();
  }

  // Ends all deployments and completes all requests.
  void end() {
    device_.agent.end(true);
    inspected(fail("it ends"));
    phase(agent::Supervised::Phase::ended);
    outcomes(REPLY_FAILED);
    device_.agent.note_end();
  }

  void check_published() {
    TAKT_CHECK(device_.published.replies.size() == asked_);
    for (const wire::WholeReply& reply : device_.published.replies) {
      Reply head = reply.head;
      head.parts(1);
      check_valid(head);
      TAKT_CHECK(reply.data.size() <= wire::kMaxData);
      TAKT_CHECK(reply.data.empty() || nlohmann::json::accept(reply.data) ||
                 reply.data.find(" of ") != std::string::npos ||
                 reply.data.find("<device") != std::string::npos);  // the reply contains a descriptor
    }
    for (const DeviceStatus& status : device_.published.devices) check_valid(status);
    for (const LifecycleStatus& step : device_.published.steps) check_valid(step);
    std::uint64_t last = 0;
    for (const FaultEvent& event : device_.published.faults) {
      check_valid(event);
      TAKT_CHECK(event.sequence_number() == ++last);
      TAKT_CHECK(event.count() > 0);
    }
  }

  fuzz::Bytes bytes_;
  wire::Assembly<Command, wire::WholeCommand> assembly_;
  agent::FakeDevice device_;
  DeviceStatus heard_;
  std::size_t asked_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Play{fuzz::Bytes{data, size}}.run();
  return 0;
}
