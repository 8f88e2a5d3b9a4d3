// A sporadic thread module in C++: a part has come, so the robot is asked to take it away. Runs when the
// event arrives.
#include <takt/component.hpp>

#include <cmath>
#include <numbers>

#include <line.hpp>
#include <motion.hpp>

#include "station.hpp"

class Dispatcher : public takt::Component {
  takt::EventPort<line::Part> part{*this, "part", {.text = "A part waits at the light barrier."}};
  takt::OutPort<motion::PickRequest> request{*this, "request", {.text = "What the robot is asked to take."}};
  takt::Property<bool> bottles{*this, "bottles", true, {.text = "Whether bottles are taken too, or left."}};

  // All in the robot's foot. The belt runs along y, and what is right of it lies along x.
  takt::Property<double> belt_x{
      *this, "belt_x", 0.75, {.unit = "m", .min = -5, .max = 5, .text = "The belt's middle at the barrier."}};
  takt::Property<double> belt_y{
      *this, "belt_y", 0.45, {.unit = "m", .min = -5, .max = 5, .text = "The belt's middle at the barrier."}};
  takt::Property<double> belt_z{
      *this, "belt_z", 0.3, {.unit = "m", .min = -5, .max = 5, .text = "Where a part is held, there."}};
  takt::Property<double> pallet_x{
      *this, "pallet_x", 0.45, {.unit = "m", .min = -5, .max = 5, .text = "The first place of the pallet."}};
  takt::Property<double> pallet_y{
      *this, "pallet_y", -0.85, {.unit = "m", .min = -5, .max = 5, .text = "The first place of the pallet."}};
  takt::Property<double> pallet_z{
      *this, "pallet_z", 0.2, {.unit = "m", .min = -5, .max = 5, .text = "Where a part is held, there."}};
  takt::Property<std::int64_t> columns{
      *this, "columns", 4, {.min = 1, .max = 100, .text = "Places of the pallet along x."}};
  takt::Property<std::int64_t> rows{
      *this, "rows", 3, {.min = 1, .max = 100, .text = "Places of the pallet along y."}};
  takt::Property<double> pitch{
      *this, "pitch", 0.12, {.unit = "m", .min = 0.01, .max = 2, .text = "From place to place."}};

  motion::PickRequest request_;
  std::uint64_t asked_ = 0;  // parts, each once

  void run(const takt::Cycle&) noexcept override {
    while (part.read()) {
      const line::Part& seen = part.value();
      if (!bottles && seen.kind() == "bottle") continue;
      if (asked_ == 0 || seen.number() != request_.number()) ++asked_;  // else it still waits
      const dispatcher::Pallet pallet{{pallet_x, pallet_y, pallet_z}, columns, rows, pitch};
      const dispatcher::Place place = pallet.slot(asked_ - 1);
      request_.number(seen.number());
      // The fingers close across the longer side, which has no direction.
      set(request_.pick(), {belt_x + seen.y(), belt_y - seen.x(), belt_z},
          -std::remainder(seen.angle(), std::numbers::pi));
      set(request_.place(), place, 0);
      request.write(request_);
    }
  }

  // The tool points downwards.
  static void set(motion::Pose& pose, const dispatcher::Place& place, double yaw) noexcept {
    pose.x(place.x);
    pose.y(place.y);
    pose.z(place.z);
    pose.roll(std::numbers::pi);
    pose.yaw(yaw);
  }
};
TAKT_COMPONENT(Dispatcher, "Asks a robot to take the parts that come.")
