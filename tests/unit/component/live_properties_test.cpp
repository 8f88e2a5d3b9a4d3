// Tests that the properties of a component can be set while it runs.
#include <takt/component/live_properties.hpp>

#include <takt/component.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <full_form.hpp>

#include <atomic>
#include <memory>
#include <random>
#include <thread>
#include <vector>

namespace takt::live_properties_test {
namespace {

using testing::HasSubstr;

struct Drive : Component {
  Property<std::int64_t> low{*this, "low", 0};
  Property<std::int64_t> high{*this, "high", 1, {.min = 1}};
  Property<double> gain{*this, "gain", 1.5, {.unit = "1/s", .min = 0.0, .max = 100.0}};
  Property<std::string> label{*this, "label", "0"};
  void run(const Cycle&) noexcept override {}
};

class PropertiesOfARunningModule : public testing::Test {
 protected:
  void SetUp() override { live.serve(drive.properties(), "component Drive"); }
  std::string reason(const LiveProperties::Values& values) {
    const auto set = live.set(values);
    return set ? "" : to_text(set.problems());
  }
  std::string value_of(const std::string& name) { return live.get(name).value(); }

  Drive drive;
  LiveProperties live;
};

TEST_F(PropertiesOfARunningModule, TakeEffectOnlyAtTheNextCall) {
  ASSERT_EQ(reason({{"gain", "2.5"}}), "");
  EXPECT_EQ(drive.gain, 1.5) << "a call may be in progress";
  EXPECT_EQ(value_of("gain"), "2.5");
  live.take_over();
  EXPECT_EQ(drive.gain, 2.5);
  EXPECT_EQ(value_of("gain"), "2.5");
  live.take_over();
  EXPECT_EQ(drive.gain, 2.5) << "a value is taken over only once";
}

TEST_F(PropertiesOfARunningModule, TakeEffectTogetherAtTheNextCall) {
  ASSERT_EQ(reason({{"gain", "2"}}), "");
  ASSERT_EQ(reason({{"label", "first"}}), "");
  ASSERT_EQ(reason({{"label", "second"}, {"low", "-4"}}), "");
  live.take_over();
  EXPECT_EQ(drive.gain, 2);
  EXPECT_EQ(drive.label.value(), "second");
  EXPECT_EQ(drive.low, -4);
}

TEST_F(PropertiesOfARunningModule, KeepAPendingValueIfTheNextValueIsRejected) {
  ASSERT_EQ(reason({{"gain", "2"}}), "");
  EXPECT_EQ(reason({{"gain", "100.5"}}),
            "error: property 'gain' cannot be '100.5'; it takes a number, 0 to 100, in 1/s");
  EXPECT_EQ(value_of("gain"), "2");
  live.take_over();
  EXPECT_EQ(drive.gain, 2);
}

TEST_F(PropertiesOfARunningModule, AreNotSetIfOneValueOfARequestIsRejected) {
  EXPECT_EQ(reason({{"gain", "3"}, {"high", "0"}, {"speed", "1"}, {"low", "7"}}),
            "error: property 'high' cannot be '0'; it takes a whole number, at least 1\n"
            "error: component Drive has no property 'speed'; use low, high, gain, label or log-level");
  live.take_over();
  EXPECT_EQ(drive.gain, 1.5);
  EXPECT_EQ(drive.low, 0);
  EXPECT_EQ(value_of("gain"), "1.5");
}

TEST_F(PropertiesOfARunningModule, CanBeReadByName) {
  EXPECT_EQ(value_of("low"), "0");
  const auto none = live.get("Gain\n");
  ASSERT_FALSE(none);
  EXPECT_EQ(to_text(none.problems()),
            R"(error: component Drive has no property 'Gain\n'; did you mean gain?)");
}

TEST_F(PropertiesOfARunningModule, DropPendingValuesWhenTheComponentIsReloaded) {
  ASSERT_EQ(reason({{"gain", "9"}}), "");
  Drive fresh;
  live.serve(fresh.properties(), "Drive");
  live.take_over();
  EXPECT_EQ(fresh.gain, 1.5);
  EXPECT_EQ(drive.gain, 1.5);
}

// One thread sets properties as fast as it can, sometimes before the component has taken over the previous
// values. A second thread calls the component.
TEST_F(PropertiesOfARunningModule, NeverChangeDuringACall) {
  // Adds many properties, so that taking over all values takes some time.
  std::vector<std::unique_ptr<Property<std::string>>> more;
  for (int i = 0; i < 30; ++i)
    more.push_back(std::make_unique<Property<std::string>>(drive, "more" + std::to_string(i), "0"));
  live.serve(drive.properties(), "component Drive");
  const std::int64_t requests = full_form() && !kSanitized ? 20'000 : 2'000;
  const auto text_of = [](std::int64_t n) {
    std::string text(static_cast<std::size_t>(n % 60), 'x');  // long strings are on the heap
    return text + std::to_string(n);
  };
  std::atomic<bool> end{false};
  std::atomic<std::int64_t> seen{0};
  std::uint64_t changes = 0;
  std::uint64_t wrong = 0;
  std::thread caller{[&] {
    std::int64_t last = 0;
    bool ending = false;
    while (!ending) {
      ending = end.load();
      live.take_over();
      const std::int64_t now = drive.low;
      const char* const bytes = drive.label.value().data();
      if (now < last || drive.high != now + 1 || drive.label.value() != text_of(now)) ++wrong;
      for (const auto& each : more) wrong += each->value() != drive.label.value() ? 1 : 0;
      if (drive.low != now || drive.label.value().data() != bytes) ++wrong;
      if (now != last) ++changes;
      last = now;
      seen.store(now);
    }
  }};
  std::mt19937 random{9};
  for (std::int64_t n = 1; n <= requests; ++n) {
    LiveProperties::Values values{
        {"low", std::to_string(n)}, {"high", std::to_string(n + 1)}, {"label", text_of(n)}};
    for (const auto& each : more) values.emplace_back(each->name(), text_of(n));
    ASSERT_TRUE(live.set(values).ok());
    // This request may arrive while the component takes over the values of the previous request.
    if (random() % 2 == 0) {
      ASSERT_TRUE(live.set({{"gain", std::to_string(n % 100)}}).ok());
    }
    ASSERT_EQ(value_of("label"), text_of(n));
    if (random() % 2 == 0) {
      while (seen.load() != n) std::this_thread::yield();
    }
  }
  end = true;
  caller.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_GE(changes, static_cast<std::uint64_t>(requests) / 3);
  EXPECT_EQ(drive.low, requests) << "the last value is not lost";
}

}  // namespace
}  // namespace takt::live_properties_test
