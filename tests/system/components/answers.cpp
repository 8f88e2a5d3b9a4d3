// A module with two services that answer a number with its double: `handled` in a handler, `polled` in run().
// Both reject multiples of 7. The handler also throws for multiples of 11, hangs at the number `hang_at`, and
// crashes at the number `crash_at`.
#include <takt/component.hpp>

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "sample.hpp"

class Answers : public takt::Component {
  takt::Service<samples::Count, samples::Count> handled{
      *this, "handled", [this](const auto& request) { return answer(request); }};
  takt::Service<samples::Count, samples::Count> polled{*this, "polled", {.text = "Twice as much."}};
  takt::Property<std::int64_t> hang_at{*this, "hang_at", 0};
  takt::Property<std::int64_t> crash_at{*this, "crash_at", 0};

  std::uint64_t hang_at_ = 0;
  std::uint64_t crash_at_ = 0;
  samples::Count count_;

  takt::Result<void> initialize() override {
    count_.few().reserve(4);
    hang_at_ = static_cast<std::uint64_t>(hang_at.value());
    crash_at_ = static_cast<std::uint64_t>(crash_at.value());
    return {};
  }

  takt::Result<samples::Count> answer(const samples::Count& request) {
    if (!is_whole(request)) return takt::fail("it is torn");
    if (hang_at_ != 0 && request.number() == hang_at_) std::this_thread::sleep_for(std::chrono::hours{1});
    if (crash_at_ != 0 && request.number() == crash_at_) std::abort();
    if (request.number() % 7 == 0) return takt::fail("a multiple of 7", "ask for another");
    if (request.number() % 11 == 0) throw std::runtime_error("a multiple of 11");
    samples::Count reply;
    fill(reply, 2 * request.number());
    return reply;
  }

  void run(const takt::Cycle&) noexcept override {
    while (polled.take()) {
      if (polled.request().number() % 7 == 0) {
        polled.refuse("a multiple of 7");
      } else {
        fill(count_, 2 * polled.request().number());
        polled.reply(count_);
      }
    }
  }
};
TAKT_COMPONENT(Answers)
