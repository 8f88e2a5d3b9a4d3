// What peers send to a node: commands, and what other nodes say of themselves, forged as they like, in parts
// or whole, while things happen on the device. Each command that is one is answered once; and whatever the
// node says to that makes sense to others, as they hold it against sensible.hpp.
//
// An input is steps of a letter each: see Play.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include <fastcdr/Cdr.h>

#include <takt/core/check.hpp>
#include <takt/dds/assembly.hpp>
#include <takt/dds/validation.hpp>
#include <takt/descriptor/descriptor.hpp>

#include "bytes.hpp"
#include "tests/unit/node/fake_device.hpp"

namespace {

using namespace takt;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

/// As the generated type support does it, and whoever calls that (dds/guarded.hpp).
template <class T>
bool decode(std::string_view bytes, T& value) {
  std::string copy{bytes};
  FastBuffer buffer{copy.data(), copy.size()};
  Cdr cdr{buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR};
  try {
    cdr.read_encapsulation();
    value.deserialize(cdr);
    return true;
  } catch (...) {
    return false;
  }
}

template <class T>
void check_same_again(const T& value) {
  FastBuffer buffer;
  Cdr cdr{buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR};
  cdr.serialize_encapsulation();
  value.serialize(cdr);
  T again;
  TAKT_CHECK(decode({buffer.getBuffer(), cdr.getSerializedDataLength()}, again) && again == value);
}

/// What came, cleaned; false where it is refused.
template <class T>
bool take(std::string_view bytes, T& value) {
  if (!decode(bytes, value) || !dds::validate(value)) return false;
  T again = value;
  TAKT_CHECK(dds::validate(again) && again == value);
  check_same_again(value);
  return true;
}

template <class T>
void check_sensible(const T& said) {
  T copy = said;
  TAKT_CHECK(dds::validate(copy));
  TAKT_CHECK(copy == said);
}

class Play {
 public:
  explicit Play(fuzz::Bytes bytes) : bytes_(bytes) {}

  void run() {
    for (std::size_t steps = 0; !bytes_.empty() && steps < kMostSteps; ++steps) step(bytes_.take<char>());
    end();
    check_said();
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
        return phase(node::Supervised::Phase::ready);
      case 'e':
        return phase(node::Supervised::Phase::ended);
      case 's':
        return stepped(static_cast<lifecycle::State>(bytes_.take<std::uint8_t>() % 6));
      case 'o':
        return outcomes(bytes_.take<std::uint8_t>());
      case 'g':
        device_.agent.others().gone(heard_, 1);
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
    dds::WholeCommand whole;
    const bool all = assembly_.add(part, part.id().to_string(), whole);
    TAKT_CHECK(assembly_.bytes() <= assembly_.kMostBytes);
    if (!all) return;
    ++asked_;
    device_.hear(whole);
  }
  template <class Status>
  void other() {
    Status status;
    if (!take(bytes_.take_counted(), status)) return;
    if constexpr (std::is_same_v<Status, DeviceStatus>) {
      heard_ = status;
      device_.agent.others().heard(status, 1);
    } else {
      device_.agent.others().heard(status);
    }
    device_.agent.step();
  }

  // As the real one finds it: a file for each module.
  [[nodiscard]] node::Inspected found() const {
    node::Inspected inspected{
        .paths = {}, .description = R"({"modules":[{"name":"servo","properties":[{"name":"gain"}]}]})"};
    if (device_.work.inspections.empty()) return inspected;
    const node::InspectionRequest& request = device_.work.inspections.back();
    const auto cell = descriptor::parse(request.text, request.file);
    for (const model::Device& device : cell ? cell->devices : std::vector<model::Device>{}) {
      for (const model::Module& module : device.modules)
        if (device.name == request.device) inspected.paths.push_back("/" + module.filename);
    }
    return inspected;
  }
  void inspected(Result<node::Inspected> result) {
    device_.work.inspected = std::move(result);
    device_.agent.step();
    device_.work.inspected.reset();
  }
  // Only from one to a later one.
  void phase(node::Supervised::Phase to) {
    if (device_.work.supervised == 0 || device_.work.phase > to) return;
    // Nothing that it was told stays without an outcome.
    while (to == node::Supervised::Phase::ended && !device_.work.done.empty()) outcomes(REPLY_FAILED);
    device_.work.phase = to;
    device_.agent.step();
    if (device_.work.supervised == 0) device_.work.phase = node::Supervised::Phase::preparing;
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

  // Whatever is under way ends.
  void end() {
    device_.agent.end(true);
    inspected(fail("it ends"));
    phase(node::Supervised::Phase::ended);
    outcomes(REPLY_FAILED);
    device_.agent.goes_down();
  }

  void check_said() {
    TAKT_CHECK(device_.said.replies.size() == asked_);
    for (const dds::WholeReply& reply : device_.said.replies) {
      Reply head = reply.head;
      head.parts(1);
      check_sensible(head);
      TAKT_CHECK(reply.data.size() <= dds::kMaxData);
      TAKT_CHECK(reply.data.empty() || nlohmann::json::accept(reply.data) ||
                 reply.data.find(" of ") != std::string::npos ||
                 reply.data.find("<device") != std::string::npos);  // a descriptor
    }
    for (const DeviceStatus& status : device_.said.devices) check_sensible(status);
    for (const LifecycleStatus& step : device_.said.steps) check_sensible(step);
    std::uint64_t last = 0;
    for (const FaultEvent& event : device_.said.faults) {
      check_sensible(event);
      TAKT_CHECK(event.sequence_number() == ++last);
      TAKT_CHECK(event.count() > 0);
    }
  }

  fuzz::Bytes bytes_;
  dds::Assembly<Command, dds::WholeCommand> assembly_;
  node::FakeDevice device_;
  DeviceStatus heard_;
  std::size_t asked_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Play{fuzz::Bytes{data, size}}.run();
  return 0;
}
