// A thread module in C++: a conveyor belt that brings parts to a light barrier and waits until they are taken
// away.
#include <takt/component.hpp>

#include <basic.hpp>
#include <line.hpp>
#include <motion.hpp>

#include "belt.hpp"

class Conveyor : public takt::Component {
  takt::InPort<line::BeltCommand> command{*this, "command", {.text = "How fast the belt is to run."}};
  takt::InPort<motion::PickDone> taken{*this, "taken", {.text = "Parts that were taken away."}};
  takt::OutPort<line::BeltState> state{*this, "state", {.text = "What the belt does."}};
  takt::OutPort<line::PartSeen> part{*this, "part", {.text = "A part has come to the light barrier."}};
  takt::Service<basic::Count, basic::Count> count{
      *this, "count", {.text = "Goes on counting parts from this number; answers with the last one."}};
  takt::Property<double> acceleration{
      *this, "acceleration", 1, {.unit = "m/s^2", .min = 0.01, .max = 20, .text = "Of the belt."}};
  takt::Property<double> spacing{
      *this, "spacing", 0.3, {.unit = "m", .min = 0.05, .max = 10, .text = "From one part to the next."}};

  takt::Property<double> repeat{
      *this,
      "repeat",
      2,
      {.unit = "s", .min = 0.1, .max = 3600, .text = "A part that waits is told again after this."}};

  conveyor::Belt belt_;
  basic::Count counted_;
  double waited_ = 0;  // s, since the part was told
  line::BeltState state_;
  line::PartSeen seen_;

  void run(const takt::Cycle& cycle) noexcept override {
    belt_.acceleration = acceleration;
    belt_.spacing = spacing;
    command.read();
    while (taken.read()) belt_.taken(taken.value().number());
    if (count.take()) recount();
    waited_ += cycle.seconds();
    if (belt_.step(command.value().speed(), cycle.seconds()) || (belt_.holding && waited_ >= repeat)) {
      waited_ = 0;
      seen_.number(belt_.parts);
      seen_.kind(belt_.parts % 2 == 0 ? "box" : "bottle");
      seen_.offset(belt_.offset());
      part.write(seen_);
    }
    state_.mode(belt_.holding        ? line::BELT_HOLDING
                : belt_.speed > 1e-6 ? line::BELT_RUNNING
                                     : line::BELT_STOPPED);
    state_.speed(belt_.speed);
    state_.position(belt_.position);
    state_.parts(belt_.parts);
    state.write(state_);
  }

  void recount() noexcept {
    const std::int64_t number = count.request().value();
    if (number < 0 || number > 1'000'000'000) return count.refuse("a count is 0 to 1000000000");
    if (belt_.holding) return count.refuse("a part waits at the light barrier under its number");
    counted_.value(belt_.parts);
    belt_.recount(static_cast<std::uint32_t>(number));
    count.reply(counted_);
  }

  // The one thing a belt must do when nobody tells it how fast to run.
  void error(takt::ErrorType) override { belt_.speed = 0; }
};
TAKT_COMPONENT(Conveyor)
