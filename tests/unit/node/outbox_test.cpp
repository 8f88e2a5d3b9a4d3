#include "outbox.hpp"

#include <gmock/gmock.h>

#include <thread>
#include <vector>

namespace takt::node::outbox_test {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

/// Records the calls that it receives. Readers acknowledge its statuses if `acknowledges` is true.
class FakeSink final : public LifecycleSink {
 public:
  bool write(const LifecycleStatus& status) override {
    written.push_back(status.path().to_string() + std::to_string(status.sequence_number()));
    return true;
  }
  void dispose(const LifecycleStatus& key) override { written.push_back("no " + key.path().to_string()); }
  bool wait_acknowledged(milliseconds limit) override {
    written.push_back("wait " + std::to_string(limit.count()));
    return acknowledges;
  }

  std::vector<std::string> written;
  bool acknowledges = true;
};

LifecycleStatus status(const std::string& path, std::uint64_t sequence) {
  LifecycleStatus s;
  s.path(path);
  s.sequence_number(sequence);
  return s;
}

const std::string kPatientWait = "wait " + std::to_string(Outbox::kPatient.count());
const std::string kImpatientWait = "wait " + std::to_string(Outbox::kImpatient.count());

TEST(Outbox, SendsNothingWhenItIsEmpty) {
  Outbox outbox;
  FakeSink sink;
  EXPECT_FALSE(outbox.serve(sink, milliseconds{0}));
  EXPECT_TRUE(sink.written.empty());
}

TEST(Outbox, SendsStatesOfDifferentModulesWithoutWaitingForAcknowledgement) {
  Outbox outbox;
  FakeSink sink;
  for (const char* path : {"b", "a", "c"}) outbox.put(status(path, 1));
  while (outbox.serve(sink, milliseconds{0})) {
  }
  EXPECT_THAT(sink.written, ElementsAre("b1", "a1", "c1"));
}

TEST(Outbox, SendsAModulesNextStateOnlyAfterThePreviousIsAcknowledged) {
  Outbox outbox;
  FakeSink sink;
  outbox.put(status("a", 1));
  outbox.put(status("b", 1));
  outbox.put(status("a", 2));
  outbox.put(status("b", 2));  // the wait for status 1 of a has also covered status 1 of b
  outbox.put_disposal(status("a", 0));
  while (outbox.serve(sink, milliseconds{0})) {
  }
  EXPECT_THAT(sink.written, ElementsAre("a1", "b1", kPatientWait, "a2", "b2", kPatientWait, "no a"));
}

TEST(Outbox, WaitsOnlyBrieflyAfterAMissingAcknowledgement) {
  Outbox outbox;
  FakeSink sink;
  sink.acknowledges = false;
  for (std::uint64_t i = 1; i <= 3; ++i) outbox.put(status("a", i));
  while (outbox.serve(sink, milliseconds{0})) {
  }
  EXPECT_THAT(sink.written, ElementsAre("a1", kPatientWait, "a2", kImpatientWait, "a3"));
  sink.acknowledges = true;
  for (std::uint64_t i = 4; i <= 5; ++i) outbox.put(status("a", i));
  while (outbox.serve(sink, milliseconds{0})) {
  }
  EXPECT_EQ(sink.written.back(), "a5");
  EXPECT_EQ(sink.written[sink.written.size() - 2], kPatientWait) << "the wait is long again";
}

TEST(Outbox, SendsAnEntryThatArrivesWhileItWaits) {
  Outbox outbox;
  FakeSink sink;
  std::thread other{[&] { outbox.put(status("a", 1)); }};
  EXPECT_TRUE(outbox.serve(sink, milliseconds{60'000}));
  other.join();
  EXPECT_THAT(sink.written, ElementsAre("a1"));
  std::thread third{[&] { outbox.wake(); }};
  EXPECT_FALSE(outbox.serve(sink, milliseconds{60'000}));
  third.join();
}

}  // namespace
}  // namespace takt::node::outbox_test
