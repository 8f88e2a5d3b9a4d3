// A sporadic thread module in C++: when a part arrives, it asks the robot to take the part away.
#include <takt/component.hpp>

#include <cmath>
#include <numbers>

#include <line.hpp>
#include <motion.hpp>

#include "station.hpp"

class Dispatcher : public takt::Component {
  takt::EventPort<line::Part> part{*this, "part", {.text = "Event: a part waits at the light barrier."}};
  takt::OutPort<motion::PickRequest> request{
      *this, "request", {.text = "Poses at which the robot picks and places the part."}};
  takt::Property<bool> bottles{
      *this,
      "bottles",
      true,
      {.text = "True: the robot picks bottles too; false: it leaves them on the belt."}};

  // All positions are in the frame of the robot's foot. The belt runs along y; x is across the belt.
  takt::Property<double> belt_x{*this,
                                "belt_x",
                                0.75,
                                {.unit = "m",
                                 .min = -5,
                                 .max = 5,
                                 .text = "x coordinate of the belt's centre line at the light barrier."}};
  takt::Property<double> belt_y{
      *this,
      "belt_y",
      0.45,
      {.unit = "m", .min = -5, .max = 5, .text = "y coordinate of the light barrier."}};
  takt::Property<double> belt_z{
      *this,
      "belt_z",
      0.3,
      {.unit = "m", .min = -5, .max = 5, .text = "Height at which the gripper holds a part on the belt."}};
  takt::Property<double> pallet_x{
      *this,
      "pallet_x",
      0.45,
      {.unit = "m", .min = -5, .max = 5, .text = "x coordinate of the first place of the pallet."}};
  takt::Property<double> pallet_y{
      *this,
      "pallet_y",
      -0.85,
      {.unit = "m", .min = -5, .max = 5, .text = "y coordinate of the first place of the pallet."}};
  takt::Property<double> pallet_z{
      *this,
      "pallet_z",
      0.2,
      {.unit = "m", .min = -5, .max = 5, .text = "Height at which the gripper holds a part on the pallet."}};
  takt::Property<std::int64_t> columns{
      *this, "columns", 4, {.min = 1, .max = 100, .text = "Number of places along x."}};
  takt::Property<std::int64_t> rows{
      *this, "rows", 3, {.min = 1, .max = 100, .text = "Number of places along y."}};
  takt::Property<double> pitch{
      *this,
      "pitch",
      0.12,
      {.unit = "m", .min = 0.01, .max = 2, .text = "Distance between neighbouring places."}};

  motion::PickRequest request_;
  std::uint64_t asked_ = 0;  // number of parts requested so far; a repeated part counts once

  void run(const takt::Cycle&) noexcept override {
    while (part.read()) {
      const line::Part& seen = part.value();
      if (!bottles && seen.kind() == "bottle") continue;
      // If the number is the same as before, the same part is still waiting.
      if (asked_ == 0 || seen.number() != request_.number()) ++asked_;
      const dispatcher::Pallet pallet{{pallet_x, pallet_y, pallet_z}, columns, rows, pitch};
      const dispatcher::Position place = pallet.slot(asked_ - 1);
      request_.number(seen.number());
      // The fingers close across the longer side of the part. A half turn of the gripper makes no difference.
      set(request_.pick(), {belt_x + seen.y(), belt_y - seen.x(), belt_z},
          -std::remainder(seen.angle(), std::numbers::pi));
      set(request_.place(), place, 0);
      request.write(request_);
    }
  }

  // Sets a pose at which the tool points downwards.
  static void set(motion::Pose& pose, const dispatcher::Position& place, double yaw) noexcept {
    pose.x(place.x);
    pose.y(place.y);
    pose.z(place.z);
    pose.roll(std::numbers::pi);
    pose.yaw(yaw);
  }
};
TAKT_COMPONENT(Dispatcher, "Requests that a robot move each part that arrives.")
