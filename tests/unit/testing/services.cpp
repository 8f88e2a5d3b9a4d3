// A component with a client, a service that a handler answers, and a service that run() answers.
#include <takt/component.hpp>

#include <chrono>
#include <stdexcept>

#include <basic.hpp>

class Services : public takt::Component {
  takt::Service<basic::Count, basic::Number> half{
      *this, "half", [](const basic::Count& request) -> takt::Result<basic::Number> {
        if (request.value() == 13) throw std::runtime_error("not that one");
        if (request.value() < 0) return takt::fail("it is negative", "give a positive one");
        basic::Number result;
        result.value(static_cast<double>(request.value()) / 2);
        return result;
      }};
  takt::Service<basic::Count, basic::Number> slow{*this, "slow"};
  takt::Client<basic::Count, basic::Number> ask{*this, "ask"};
  takt::InPort<basic::Count> order{*this, "order"};
  takt::OutPort<basic::Number> got{*this, "got"};
  takt::OutPort<basic::Count> status{*this, "status"};
  takt::Property<std::int64_t> cycles{*this, "cycles", 3, {.text = "Number of cycles that slow takes."}};
  std::int64_t left_ = 0;

  void run(const takt::Cycle&) override {
    if (order.read()) {
      if (order.value().value() == 0) return fail("the order is 0");
      ask.call(order.value(), std::chrono::milliseconds{20});
    }
    basic::Count now;
    now.value(static_cast<std::int64_t>(ask.poll()));
    status.write(now);
    if (ask.status() == takt::CallStatus::replied) got.write(ask.reply());
    if (!slow.busy()) {
      if (slow.take()) left_ = cycles;
    } else if (--left_ == 0) {
      basic::Number reply;
      reply.value(static_cast<double>(slow.request().value()) * 10);
      slow.reply(reply);
    }
  }
};
TAKT_COMPONENT(Services)
