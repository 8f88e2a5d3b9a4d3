// Tests the test harness with a component that has services and a client.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/component/service.hpp>
#include <takt/testing.hpp>

#include <basic.hpp>

namespace services_test {
namespace {

using namespace std::chrono_literals;
using takt::CallStatus;
using takt::lifecycle::State;
using takt::testing::Error;
using takt::testing::Module;
using ::testing::HasSubstr;

basic::Count count(std::int64_t value) {
  basic::Count result;
  result.value(value);
  return result;
}
basic::Number number(double value) {
  basic::Number result;
  result.value(value);
  return result;
}

takt::testing::Called<basic::Number> call(Module& module, const std::string& service, std::int64_t value,
                                          takt::Nanoseconds timeout = 1s) {
  return module.call<basic::Count, basic::Number>(service, count(value), timeout);
}
std::string reason(const takt::testing::Called<basic::Number>& answer) {
  return answer.ok() ? "it was answered" : answer.text();
}

template <class Call>
std::string error_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(TestedService, AnswersThroughItsHandlerAfterTheRow) {
  Module module;
  ASSERT_TRUE(module.start());
  const auto answer = call(module, "half", 7);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->value(), 3.5);
  EXPECT_EQ(module.runs(), 1U);
  EXPECT_EQ(call(module, "half", 8)->value(), 4) << "the answer of this call, not of the one before";
}

TEST(TestedService, RejectsWithTheReasonOfItsHandler) {
  Module module;
  ASSERT_TRUE(module.start());
  EXPECT_EQ(reason(call(module, "half", -1)), "it is negative; give a positive one");
  EXPECT_EQ(reason(call(module, "half", 13)), "the handler threw: not that one");
  EXPECT_EQ(module.state(), State::executing);
}

TEST(TestedService, RejectsCallsWhileTheModuleIsNotExecuting) {
  Module module;
  ASSERT_TRUE(module.start());
  module.step();
  ASSERT_TRUE(module.stop());
  EXPECT_EQ(reason(call(module, "half", 7)), "the module of the service is not in EXECUTING");
  ASSERT_TRUE(module.start());
  EXPECT_TRUE(call(module, "half", 7).ok());
}

TEST(TestedService, CanAnswerSeveralCyclesLater) {
  Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("cycles", "5"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(call(module, "slow", 4)->value(), 40);
  EXPECT_EQ(module.runs(), 6U);
}

TEST(TestedService, TimesOutWhenItDoesNotAnswerInTime) {
  Module module;
  ASSERT_TRUE(module.set("cycles", "30"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(reason(call(module, "slow", 4, 20ms)), "no reply came within 20 ms");
  EXPECT_EQ(module.runs(), 21U);
  EXPECT_EQ(call(module, "slow", 5, 100ms)->value(), 50) << "the late answer belongs to the previous call";
}

TEST(TestedService, ListsTheKnownServicesForAnUnknownName) {
  Module module;
  ASSERT_TRUE(module.start());
  const std::string all =
      "; it has service half (basic::Count -> basic::Number), service slow (basic::Count -> basic::Number), "
      "client ask (basic::Count -> basic::Number)";
  EXPECT_EQ(error_of([&] { static_cast<void>(call(module, "quarter", 7)); }),
            "testing_services.so has no service quarter (basic::Count -> basic::Number)" + all);
  EXPECT_EQ(error_of([&] { static_cast<void>(module.call<basic::Count, basic::Flag>("half", count(7))); }),
            "testing_services.so has no service half (basic::Count -> basic::Flag)" + all);
  EXPECT_EQ(error_of([&] { static_cast<void>(call(module, "ask", 7)); }),
            "testing_services.so has no service ask (basic::Count -> basic::Number)" + all);
  EXPECT_EQ(error_of([&] {
              module.serve<basic::Count, basic::Number>("half",
                                                        [](const basic::Count&) { return number(1); });
            }),
            "testing_services.so has no client half (basic::Count -> basic::Number)" + all);
}

TEST(TestedService, ThrowsTheReasonWhenAMissingReplyIsRead) {
  Module module;
  ASSERT_TRUE(module.start());
  const auto rejected = call(module, "half", -1);
  EXPECT_EQ(error_of([&] { static_cast<void>(rejected->value()); }),
            "there is no reply: it is negative; give a positive one");
}

class TestedClient : public ::testing::Test {
 protected:
  Module module;
  takt::testing::In<basic::Count>& order = module.in<basic::Count>("order");
  takt::testing::Out<basic::Count>& status = module.out<basic::Count>("status");
  takt::testing::Out<basic::Number>& got = module.out<basic::Number>("got");
  static constexpr auto kDouble = [](const basic::Count& request) -> takt::Result<basic::Number> {
    if (request.value() < 0) return takt::fail("it is negative", "give a positive one");
    return number(2.0 * static_cast<double>(request.value()));
  };
  CallStatus after(std::uint64_t releases) {
    module.step(releases);
    return static_cast<CallStatus>(status.value().value());
  }
};

TEST_F(TestedClient, GetsItsReplyInTheNextCycle) {
  auto& server = module.serve<basic::Count, basic::Number>("ask", kDouble);
  ASSERT_TRUE(module.start());
  EXPECT_EQ(after(1), CallStatus::idle);
  EXPECT_EQ(server.asked(), 0U);
  order.write(count(21));
  EXPECT_EQ(after(1), CallStatus::pending);
  EXPECT_EQ(server.request().value(), 21);
  EXPECT_EQ(after(1), CallStatus::replied);
  EXPECT_EQ(got.value().value(), 42);
  EXPECT_EQ(after(10), CallStatus::replied);
  EXPECT_EQ(server.asked(), 1U);
  order.write(count(-21));
  EXPECT_EQ(after(2), CallStatus::refused);
  EXPECT_EQ(server.asked(), 2U);
}

TEST_F(TestedClient, GetsADelayedReply) {
  module.serve<basic::Count, basic::Number>("ask", kDouble, 10ms);
  ASSERT_TRUE(module.start());
  order.write(count(1));
  EXPECT_EQ(after(11), CallStatus::pending);
  EXPECT_EQ(after(1), CallStatus::replied);
}

TEST_F(TestedClient, TimesOutWithoutAReply) {
  module.serve<basic::Count, basic::Number>("ask", kDouble, 30ms);
  ASSERT_TRUE(module.start());
  order.write(count(1));
  EXPECT_EQ(after(20), CallStatus::pending);
  EXPECT_EQ(after(1), CallStatus::timed_out);
  EXPECT_EQ(after(20), CallStatus::timed_out) << "a late answer is ignored";
}

TEST_F(TestedClient, IgnoresALateReplyToAnEarlierCall) {
  auto& server = module.serve<basic::Count, basic::Number>("ask", kDouble, 30ms);
  ASSERT_TRUE(module.start());
  order.write(count(1));
  EXPECT_EQ(after(25), CallStatus::timed_out);
  order.write(count(2));
  EXPECT_EQ(after(15), CallStatus::pending) << "the answer to the first call has arrived by now";
  EXPECT_EQ(server.asked(), 2U);
  EXPECT_EQ(after(10), CallStatus::timed_out);
  EXPECT_FALSE(got.has_value());
}

TEST_F(TestedClient, ReportsAMissingServer) {
  ASSERT_TRUE(module.start());
  order.write(count(1));
  EXPECT_EQ(after(1), CallStatus::nobody);
}

TEST_F(TestedClient, RejectsASecondServer) {
  module.serve<basic::Count, basic::Number>("ask", kDouble);
  EXPECT_THROW((module.serve<basic::Count, basic::Number>("ask", kDouble)), Error);
}

TEST_F(TestedClient, CanCallAgainAfterRecovery) {
  auto& server = module.serve<basic::Count, basic::Number>("ask", kDouble);
  ASSERT_TRUE(module.start());
  order.write(count(0));
  module.step();
  EXPECT_EQ(module.state(), State::recover);
  ASSERT_TRUE(module.recover());
  order.write(count(3));
  EXPECT_EQ(after(2), CallStatus::replied);
  EXPECT_EQ(got.value().value(), 6);
  EXPECT_EQ(server.asked(), 1U);
}

}  // namespace
}  // namespace services_test
