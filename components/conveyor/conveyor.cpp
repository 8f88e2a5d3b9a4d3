// A thread module in C++: simulates a conveyor belt that brings parts to a light barrier and holds each part
// until it is taken away.
#include <takt/component.hpp>

#include <algorithm>

#include <basic.hpp>
#include <line.hpp>
#include <motion.hpp>

#include "../common/enabled.hpp"
#include "belt.hpp"

class Conveyor : public takt::Component {
  takt::InPort<line::BeltCommand> command{*this, "command", {.text = "Wanted speed of the belt."}};
  takt::InPort<basic::Flag> enable{
      *this,
      "enable",
      {.text = "False stops the belt. Counts as true before the first value and if not connected."}};
  takt::InPort<motion::PickDone> taken{
      *this,
      "taken",
      {.text = "Results of pick requests, which tell that a part was taken away; connect it as a queue."}};
  takt::OutPort<line::BeltState> state{*this, "state", {.text = "State of the belt."}};
  takt::OutPort<line::Part> part{*this, "part", {.text = "Event: a part has arrived at the light barrier."}};
  takt::OutPort<basic::Flag> barrier{*this, "barrier", {.text = "A part is at the light barrier."}};
  takt::OutPort<line::Scene> scene{
      *this, "scene", {.text = "The parts before the light barrier, for a camera."}};
  takt::Service<basic::Count, basic::Count> count{
      *this, "count", {.text = "Sets the count of parts to this number; returns the previous count."}};
  takt::Property<double> acceleration{
      *this,
      "acceleration",
      1,
      {.unit = "m/s^2", .min = 0.01, .max = 20, .text = "Acceleration and braking of the belt."}};
  takt::Property<double> spacing{
      *this, "spacing", 0.3, {.unit = "m", .min = 0.05, .max = 10, .text = "Distance between two parts."}};
  takt::Property<double> view{
      *this,
      "view",
      0.5,
      {.unit = "m",
       .min = 0,
       .max = 10,
       .text = "The scene shows parts up to this distance before the light barrier."}};
  takt::Property<double> enable_timeout{
      *this,
      "enable_timeout",
      0,
      {.unit = "s",
       .min = 0,
       .max = 3600,
       .text = "A missing enable, or one older than this, counts as false; 0: enable never expires."}};
  takt::Property<double> repeat{*this,
                                "repeat",
                                2,
                                {.unit = "s",
                                 .min = 0.1,
                                 .max = 3600,
                                 .text = "Time after which a part that still waits is announced again."}};

  conveyor::Belt belt_;
  basic::Count counted_;
  double waited_ = 0;  // s, since the last announcement of the part
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
    if (came || (belt_.holding && waited_ >= repeat)) announce_part();
    write_state();
    write_scene();
  }

  void recount() noexcept {
    const std::int64_t number = count.request().value();
    if (number < 0 || number > 1'000'000'000) return count.refuse("the count must be 0 to 1000000000");
    if (belt_.holding)
      return count.refuse(
          "a part waits at the light barrier, and its number cannot change; try again when the part is gone");
    counted_.value(belt_.parts);
    belt_.recount(static_cast<std::uint32_t>(number));
    count.reply(counted_);
  }

  // After an error, the module has no valid command, so the belt must stop.
  void error(takt::ErrorType) override { belt_.speed = 0; }

  void announce_part() noexcept {
    waited_ = 0;
    line::Part announced;
    set(announced, belt_.laid(belt_.parts));
    part.write(announced);
  }

  static void set(line::Part& part, const conveyor::Laid& laid) noexcept {
    part.number(laid.number);
    part.kind(laid.kind);
    part.x(laid.x);
    part.y(laid.y);
    part.angle(laid.angle);
  }

  void write_state() noexcept {
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

  void write_scene() noexcept {
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
TAKT_COMPONENT(Conveyor, "Simulates a belt that brings parts to a light barrier.")
