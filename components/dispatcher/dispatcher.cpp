// A sporadic thread module in C++: a part has come, so the robot is asked to take it away. Runs when the
// event arrives.
#include <takt/component.hpp>

#include <line.hpp>
#include <motion.hpp>

class Dispatcher : public takt::Component {
  takt::EventPort<line::PartSeen> part{*this, "part", {.text = "A part has come to the light barrier."}};
  takt::OutPort<motion::PickRequest> request{*this, "request", {.text = "What the robot is asked to take."}};
  takt::Property<bool> bottles{*this, "bottles", true, {.text = "Whether bottles are taken too, or left."}};

  motion::PickRequest request_;

  void run(const takt::Cycle&) noexcept override {
    while (part.read()) {
      if (!bottles && part.value().kind() == "bottle") continue;
      request_.number(part.value().number());
      request_.offset(part.value().offset());
      request.write(request_);
    }
  }
};
TAKT_COMPONENT(Dispatcher)
