// A thread module in C++: a conveyor belt that brings parts to a light barrier and waits until they are taken
// away.
#include <takt/component.hpp>

#include <algorithm>

#include <basic.hpp>
#include <line.hpp>
#include <motion.hpp>

#include "../common/enabled.hpp"
#include "belt.hpp"

class Conveyor : public takt::Component {
  takt::InPort<line::BeltCommand> command{*this, "command", {.text = "How fast the belt is to run."}};
  takt::InPort<basic::Flag> enable{
      *this, "enable", {.text = "The belt may run; false stops it. It may where nobody says anything."}};
  takt::InPort<motion::PickDone> taken{*this, "taken", {.text = "Parts that were taken away."}};
  takt::OutPort<line::BeltState> state{*this, "state", {.text = "What the belt does."}};
  takt::OutPort<line::Part> part{*this, "part", {.text = "A part has come to the light barrier."}};
  takt::OutPort<basic::Flag> barrier{*this, "barrier", {.text = "A part is at the light barrier."}};
  takt::OutPort<line::Scene> scene{*this, "scene", {.text = "The parts near the light barrier."}};
  takt::Service<basic::Count, basic::Count> count{
      *this, "count", {.text = "Goes on counting parts from this number; answers with the last one."}};
  takt::Property<double> acceleration{
      *this, "acceleration", 1, {.unit = "m/s^2", .min = 0.01, .max = 20, .text = "Of the belt."}};
  takt::Property<double> spacing{
      *this, "spacing", 0.3, {.unit = "m", .min = 0.05, .max = 10, .text = "From one part to the next."}};
  takt::Property<double> view{
      *this,
      "view",
      0.5,
      {.unit = "m", .min = 0, .max = 10, .text = "How far before the light barrier parts are in the scene."}};
  takt::Property<double> enable_timeout{
      *this,
      "enable_timeout",
      0,
      {.unit = "s",
       .min = 0,
       .max = 3600,
       .text = "An older `enable`, or none yet, counts as false; 0: it holds for ever."}};
  takt::Property<double> repeat{
      *this,
      "repeat",
      2,
      {.unit = "s", .min = 0.1, .max = 3600, .text = "A part that waits is told again after this."}};

  conveyor::Belt belt_;
  basic::Count counted_;
  double waited_ = 0;  // s, since the part was told
  line::BeltState state_;
  line::Scene scene_;
  basic::Flag barrier_;

  takt::Result<void> initialize() override {
    scene_.parts().reserve(line::MAX_PARTS);
    return {};
  }

  void run(const takt::Cycle& cycle) noexcept override {
    belt_.acceleration = acceleration;
    belt_.spacing = spacing;
    command.read();
    enable.read();
    while (taken.read()) {
      if (taken.value().result() != motion::PICK_REFUSED) belt_.taken(taken.value().number());
    }
    if (count.take()) recount();
    waited_ += cycle.seconds();
    const bool came =
        belt_.step(common::is_enabled(enable, enable_timeout) ? command.value().speed() : 0, cycle.seconds());
    if (came || (belt_.holding && waited_ >= repeat)) tell_part();
    tell_state();
    tell_scene();
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

  void tell_part() noexcept {
    waited_ = 0;
    line::Part told;
    set(told, belt_.laid(belt_.parts));
    part.write(told);
  }

  static void set(line::Part& part, const conveyor::Laid& laid) noexcept {
    part.number(laid.number);
    part.kind(laid.kind);
    part.x(laid.x);
    part.y(laid.y);
    part.angle(laid.angle);
  }

  void tell_state() noexcept {
    state_.mode(belt_.holding        ? line::BELT_HOLDING
                : belt_.speed > 1e-6 ? line::BELT_RUNNING
                                     : line::BELT_STOPPED);
    state_.speed(belt_.speed);
    state_.position(belt_.position);
    state_.parts(belt_.parts);
    state.write(state_);
    barrier_.value(belt_.holding);
    barrier.write(barrier_);
  }

  void tell_scene() noexcept {
    scene_.position(belt_.position);
    scene_.parts().clear();
    for (std::uint32_t number = belt_.first(); scene_.parts().size() < line::MAX_PARTS; ++number) {
      const conveyor::Laid laid = belt_.laid(number);
      if (laid.x > view) break;
      scene_.parts().emplace_back();
      set(scene_.parts().back(), laid);
    }
    scene.write(scene_);
  }
};
TAKT_COMPONENT(Conveyor, "A belt with a light barrier, simulated.")
