#include <takt/component/service.hpp>

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <thread>

#include <long_enough.hpp>
#include <takt/model/type.hpp>
#include <takt/os/clock.hpp>
#include "executor_threads.hpp"
#include "service_thread.hpp"

#include "../../system/components/sample.hpp"
#include "connected_service.hpp"

namespace takt::service_test {
namespace {

using namespace std::chrono_literals;
using samples::Count;

Count count_of(std::uint64_t number) {
  Count count;
  fill(count, number);
  return count;
}

struct Polled : Plain {
  Service<Count, Count> answer{*this, "answer"};
};

struct Handled : Plain {
  explicit Handled(Service<Count, Count>::Handler handler) : answer{*this, "answer", std::move(handler)} {}
  Service<Count, Count> answer;
};

/// Runs each test twice: with samples passed as objects, and with samples passed as bytes.
class ServiceCall : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    serve_all(client, at_client);
    serve_all(other, at_client);
    serve_all(server, at_server);
  }
  void pass(Nanoseconds time) {
    at_client.start_ns += time.count();
    at_server.start_ns += time.count();
  }

  PortContext at_client{.start_ns = 1'000'000'000};
  PortContext at_server{.start_ns = 1'000'000'000};
  Asking<Count> client;
  Asking<Count> other;
  Polled server;
};
INSTANTIATE_TEST_SUITE_P(Ways, ServiceCall, testing::Bool(),
                         [](const auto& way) { return way.param ? "Objects" : "Bytes"; });

TEST_P(ServiceCall, ReturnsTheReplyOfTheServer) {
  const ConnectedService link{client, server, "answer", GetParam()};
  EXPECT_EQ(client.ask.poll(), CallStatus::idle);
  EXPECT_FALSE(server.answer.take());
  EXPECT_EQ(client.ask.call(count_of(21), 1s), CallStatus::pending);
  EXPECT_EQ(client.ask.poll(), CallStatus::pending);
  ASSERT_TRUE(server.answer.take());
  EXPECT_TRUE(server.answer.busy());
  EXPECT_TRUE(is_whole(server.answer.request()));
  EXPECT_EQ(server.answer.request().number(), 21U);
  server.answer.reply(count_of(42));
  EXPECT_FALSE(server.answer.busy());
  EXPECT_EQ(client.ask.poll(), CallStatus::replied);
  EXPECT_TRUE(is_whole(client.ask.reply()));
  EXPECT_EQ(client.ask.reply().number(), 42U);
  pass(1h);
  EXPECT_EQ(client.ask.poll(), CallStatus::replied) << "the reply stays";
  EXPECT_FALSE(server.answer.take());
}

TEST_P(ServiceCall, EachClientGetsItsOwnReply) {
  const ConnectedService first{client, server, "answer", GetParam()};
  const ConnectedService second{other, server, "answer", GetParam()};
  for (std::uint64_t i = 1; i <= 100; ++i) {
    client.ask.call(count_of(i), 1s);
    other.ask.call(count_of(1000 + i), 1s);
    int taken = 0;
    for (; server.answer.take(); ++taken) server.answer.reply(count_of(2 * server.answer.request().number()));
    EXPECT_EQ(taken, 2);
    ASSERT_EQ(client.ask.poll(), CallStatus::replied);
    ASSERT_EQ(other.ask.poll(), CallStatus::replied);
    EXPECT_EQ(client.ask.reply().number(), 2 * i);
    EXPECT_EQ(other.ask.reply().number(), 2 * (1000 + i));
  }
  EXPECT_EQ(first.replies.link.block().written.load(), 100U)
      << "a client's link carries no replies to others";
  EXPECT_EQ(client.ask.late() + other.ask.late(), 0U);
}

TEST_P(ServiceCall, ReportsTheReasonOfARejection) {
  const ConnectedService link{client, server, "answer", GetParam()};
  client.ask.call(count_of(1), 1s);
  ASSERT_TRUE(server.answer.take());
  server.answer.refuse(std::string(200, 'x').c_str());
  EXPECT_EQ(client.ask.poll(), CallStatus::refused);
  EXPECT_EQ(client.ask.reason(), std::string(127, 'x'));
  EXPECT_EQ(client.ask.call(count_of(2), 1s), CallStatus::pending);
  EXPECT_STREQ(client.ask.reason(), "");
}

TEST_P(ServiceCall, ReportsAMissingServerAtOnce) {
  EXPECT_EQ(client.ask.call(count_of(1), 1s), CallStatus::nobody);
  const ConnectedService link{client, server, "answer", GetParam()};
  link.requests.link.block().enabled = 0;  // the node clears this flag while the other device is lost
  EXPECT_EQ(client.ask.call(count_of(1), 1s), CallStatus::nobody);
  EXPECT_FALSE(client.ask.connected());
  link.requests.link.block().enabled = 1;
  EXPECT_EQ(client.ask.call(count_of(1), 1s), CallStatus::pending);
}

TEST_P(ServiceCall, TimesOutAfterItsLimitInCycleTime) {
  const ConnectedService link{client, server, "answer", GetParam()};
  client.ask.call(count_of(1), 10ms);
  ASSERT_TRUE(server.answer.take());
  pass(10ms - 1ns);
  EXPECT_EQ(client.ask.poll(), CallStatus::pending);
  pass(1ns);
  EXPECT_EQ(client.ask.poll(), CallStatus::timed_out);
  server.answer.reply(count_of(2));
  EXPECT_EQ(client.ask.poll(), CallStatus::timed_out);
  EXPECT_EQ(client.ask.late(), 1U);
  EXPECT_EQ(link.replies.link.block().late.load(), 1U);
  // A late reply to one call must not answer the next call.
  client.ask.call(count_of(3), 10ms);
  ASSERT_TRUE(server.answer.take());
  pass(10ms);
  EXPECT_EQ(client.ask.poll(), CallStatus::timed_out);
  client.ask.call(count_of(4), 10ms);
  server.answer.reply(count_of(6));
  EXPECT_EQ(client.ask.poll(), CallStatus::pending);
  EXPECT_EQ(client.ask.late(), 2U);
}

TEST_P(ServiceCall, IsRejectedIfItsRequestIsOlderThanItsTimeout) {
  const ConnectedService link{client, server, "answer", GetParam()};
  client.ask.call(count_of(1), 10ms);
  at_server.start_ns += 10'000'001;
  EXPECT_FALSE(server.answer.take());
  EXPECT_FALSE(server.answer.busy());
  EXPECT_EQ(client.ask.poll(), CallStatus::refused);
  EXPECT_NE(std::string{client.ask.reason()}.find("clocks"), std::string::npos);
  EXPECT_EQ(link.requests.link.block().late.load(), 1U);
}

TEST_P(ServiceCall, IgnoresAReplyToAFormerInstanceOfTheClient) {
  if (GetParam()) return;  // objects would have to stay in the same memory; only HostLinks ensures this
  const ConnectedService link{client, server, "answer", false};
  client.ask.call(count_of(1), 1s);
  ASSERT_TRUE(server.answer.take());
  Asking<Count> again;  // the client in the new instance of the reloaded module
  pass(1ms);
  serve_all(again, at_client);
  auto* out = &port_of(again, "ask/request");
  auto* in = &port_of(again, "ask/reply");
  out->connect(link.requests.link, nullptr);
  in->connect(link.replies.link, nullptr);
  EXPECT_EQ(again.ask.call(count_of(5), 1s), CallStatus::pending);
  server.answer.reply(count_of(2));
  EXPECT_EQ(again.ask.poll(), CallStatus::pending) << "although both calls have the number 1";
}

TEST_P(ServiceCall, IsRejectedIfItsRequestOrReplyIsTooLarge) {
  const ConnectedService link{client, server, "answer", GetParam()};
  Count large;
  large.few().resize(5);
  EXPECT_EQ(client.ask.call(large, 1s), CallStatus::refused);
  EXPECT_FALSE(server.answer.take());
  client.ask.call(count_of(1), 1s);
  ASSERT_TRUE(server.answer.take());
  server.answer.reply(large);
  EXPECT_EQ(client.ask.poll(), CallStatus::refused);
}

TEST(ServiceHandler, RejectsTheRequestWhenItFails) {
  Handled server{[](const Count& request) -> Result<Count> {
    if (request.number() == 1) return fail("one", "say two");
    if (request.number() == 2) throw std::runtime_error("two");
    if (request.number() == 3) throw 3;
    return count_of(2 * request.number());
  }};
  Asking<Count> client;
  const PortContext context{.start_ns = 1};
  serve_all(client, context);
  serve_all(server, context);
  const ConnectedService link{client, server, "answer", false};
  ASSERT_EQ(server.services().size(), 1U);
  ServiceBase& service = *server.services()[0];
  EXPECT_FALSE(service.handle(nullptr));
  const auto asked = [&](std::uint64_t number, const char* rejection) {
    client.ask.call(count_of(number), 1s);
    EXPECT_TRUE(service.has_request());
    EXPECT_TRUE(service.handle(rejection));
    return client.ask.poll();
  };
  EXPECT_EQ(asked(1, nullptr), CallStatus::refused);
  EXPECT_STREQ(client.ask.reason(), "one; say two");
  EXPECT_EQ(asked(2, nullptr), CallStatus::refused);
  EXPECT_STREQ(client.ask.reason(), "the handler threw: two");
  EXPECT_EQ(asked(3, nullptr), CallStatus::refused);
  EXPECT_EQ(asked(4, nullptr), CallStatus::replied);
  EXPECT_EQ(client.ask.reply().number(), 8U);
  EXPECT_EQ(asked(5, "not now"), CallStatus::refused);
  EXPECT_STREQ(client.ask.reason(), "not now");
}

TEST(ServiceHandler, DoesNotWakeASporadicModule) {
  Handled handled{[](const Count& count) { return count; }};
  EXPECT_EQ(port_of(handled, "answer/request").direction(), PortDirection::in);
  Polled polled;
  EXPECT_EQ(port_of(polled, "answer/request").direction(), PortDirection::event);
}

// A program that was compiled without the type uses the description of the type. So the description must
// match the encoding.
TEST(ServiceType, IsEncodedAccordingToItsDescription) {
  const auto check = [](const TypeInfo& info, const std::byte* bytes, std::uint32_t size) {
    const auto type = model::parse_type(info.description);
    ASSERT_TRUE(type.ok()) << to_text(type.problems());
    EXPECT_EQ(type->name, info.name);
    EXPECT_EQ(model::max_size(*type), info.max_size);
    EXPECT_TRUE(model::is_sample(*type, bytes, size));
    // Encodes the sample again from the values of its fields.
    const auto again = model::sample_bytes(*type, model::sample_json(*type, bytes, size));
    ASSERT_TRUE(again.ok()) << to_text(again.problems());
    EXPECT_EQ(*again, std::vector<std::byte>(bytes, bytes + size));
  };
  std::array<std::byte, 1024> bytes{};
  ServiceRequest<Count> request{
      .client = ~std::uint64_t{0}, .number = 2, .timeout_ns = -3, .request = count_of(4)};
  using Request = PortType<ServiceRequest<Count>>;
  std::uint32_t size = Request::encode(request, bytes.data(), Request::info.max_size);
  ASSERT_GT(size, 0U);
  check(Request::info, bytes.data(), size);
  EXPECT_STREQ(Request::info.name, "samples::Count_Request");
  ServiceRequest<Count> taken;
  Request::reserve(taken);
  ASSERT_TRUE(Request::decode(bytes.data(), size, taken));
  EXPECT_TRUE(taken.client == request.client && taken.number == 2 && taken.timeout_ns == -3);
  EXPECT_TRUE(is_whole(taken.request) && taken.request.number() == 4);
  EXPECT_FALSE(Request::decode(bytes.data(), size - 8, taken));

  ServiceReply<Count> reply{
      .client = 1, .number = 2, .reply = count_of(4), .code = ServiceCode::refused, .reason = {}};
  reply.reason.fill('y');
  reply.reason.back() = '\0';
  using Reply = PortType<ServiceReply<Count>>;
  size = Reply::encode(reply, bytes.data(), Reply::info.max_size);
  EXPECT_EQ(size, Reply::info.max_size) << "this reply has the maximum size";
  check(Reply::info, bytes.data(), size);
  ServiceReply<Count> answer;
  Reply::reserve(answer);
  ASSERT_TRUE(Reply::decode(bytes.data(), size, answer));
  EXPECT_TRUE(answer.client == 1 && answer.number == 2 && answer.code == ServiceCode::refused);
  EXPECT_EQ(answer.reason, reply.reason);
}

}  // namespace
}  // namespace takt::service_test

namespace takt::host {
namespace {

using namespace std::chrono_literals;

/// Starts the service thread of a module as the host does.
class HandlerThread : public testing::Test {
 protected:
  void start(std::function<bool()> serve) {
    thread = std::make_unique<ServiceThread>(
        ServiceThread::Options{
            .index = 4, .name = "serve", .cpus = {}, .activity = activity, .wake_word = wake_word},
        [this] { return waiting.load() > 0; }, std::move(serve));
  }
  void until(const std::function<bool()>& holds) {
    const Instant limit = os::now() + long_enough();
    while (!holds() && os::now() < limit) std::this_thread::sleep_for(1ms);
    ASSERT_TRUE(holds());
  }

  channel::Activity activity{};
  channel::WakeWord wake_word{};
  std::atomic<int> waiting{0};
  std::atomic<int> served{0};
  std::atomic<bool> let_go{false};
  std::unique_ptr<ServiceThread> thread;
};

TEST_F(HandlerThread, ShowsItsActivityWhileItServesRequests) {
  std::atomic<std::uint32_t> seen{0};
  start([&] {
    seen = activity.module.load();
    --waiting;
    ++served;
    return true;
  });
  waiting = 3;
  until([&] { return served == 3; });
  EXPECT_EQ(seen, 5U);
  until([&] { return activity.module.load() == 0; });
}

TEST_F(HandlerThread, CallsNoHandlerWhileHandlersAreExcluded) {
  start([&] {
    --waiting;
    ++served;
    return true;
  });
  {
    const auto excluded = thread->exclude();
    waiting = 1;
    std::this_thread::sleep_for(250ms);
    EXPECT_EQ(served, 0);
  }
  until([&] { return served == 1; });
}

// Two clients run on the thread of the test, and the handler runs on its own thread.
TEST_F(HandlerThread, AnswersRequestsWhileItsClientsRun) {
  struct Server : Plain {
    Service<samples::Count, samples::Count> answer{*this, "answer", [](const samples::Count& request) {
                                                     samples::Count reply;
                                                     fill(reply, 2 * request.number());
                                                     return reply;
                                                   }};
  } server;
  std::array<Asking<samples::Count>, 2> clients;
  PortContext context{.start_ns = to_ns(os::now()), .wake_word = &wake_word};
  PortContext of_handler{.start_ns = to_ns(os::now()), .wake_word = &wake_word};
  for (auto& client : clients) serve_all(client, context);
  serve_all(server, of_handler);
  const ConnectedService objects{clients[0], server, "answer", true, channel::kServiceBit};
  const ConnectedService bytes{clients[1], server, "answer", false, channel::kServiceBit};
  ServiceBase& service = *server.services()[0];
  ServiceThread serving{
      {.index = 0, .name = "serve", .cpus = {}, .activity = activity, .wake_word = wake_word},
      [&] {
        of_handler.start_ns = to_ns(os::now());
        return service.has_request();
      },
      [&] { return service.handle(nullptr); }};
  std::array<std::uint64_t, 2> replied{};
  std::uint64_t number = 0;
  samples::Count count;
  const Instant limit = os::now() + long_enough();
  while ((replied[0] < 500 || replied[1] < 500) && os::now() < limit) {
    context.start_ns = to_ns(os::now());
    for (std::size_t i = 0; i < clients.size(); ++i) {
      auto& ask = clients[i].ask;
      const CallStatus status = ask.poll();
      if (status == CallStatus::pending) continue;
      ASSERT_NE(status, CallStatus::refused) << ask.reason();
      if (status == CallStatus::replied) {
        ++replied[i];
        ASSERT_TRUE(is_whole(ask.reply()));
        ASSERT_EQ(ask.reply().number() % 2, 0U);
      }
      fill(count, ++number);
      ask.call(count, 20s);
    }
    ring_pending(wake_word);
    std::this_thread::yield();
  }
  EXPECT_GE(replied[0], 500U);
  EXPECT_GE(replied[1], 500U);
}

TEST_F(HandlerThread, WaitsForTheRunningHandlerBeforeItEnds) {
  start([&] {
    --waiting;
    while (!let_go) std::this_thread::sleep_for(1ms);
    ++served;
    return true;
  });
  waiting = 1;
  until([&] { return thread->serves(); });
  std::thread other{[&] {
    std::this_thread::sleep_for(50ms);
    let_go = true;
  }};
  thread.reset();
  EXPECT_EQ(served, 1) << "the thread still uses the module, its activity and the wake word";
  other.join();
}

TEST_F(HandlerThread, GivesUpAHandlerThatNeverReturns) {
  start([&] {
    --waiting;
    while (!let_go) std::this_thread::sleep_for(1ms);
    ++served;
    return true;
  });
  EXPECT_FALSE(thread->serves());
  waiting = 1;
  until([&] { return thread->serves(); });
  EXPECT_EQ(activity.module.load(), 5U);
  thread->give_up();
  EXPECT_EQ(activity.module.load(), 0U);
  thread.reset();  // reset() does not wait for the handler
  EXPECT_EQ(served, 0);
  activity.begin(6, channel::Doing::serve, 0);  // now another thread uses the same activity record
  let_go = true;
  until([&] { return served == 1; });
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(activity.module.load(), 7U);
}

}  // namespace
}  // namespace takt::host
