// A thread module in C++: computes the set points of a six-axis arm that moves parts on request.
#include <takt/component.hpp>

#include <cmath>
#include <optional>
#include <string>
#include <variant>

#include <basic.hpp>
#include <motion.hpp>

#include "../common/enabled.hpp"
#include "path.hpp"

class Trajectory : public takt::Component {
  takt::InPort<motion::PickRequest> request{
      *this, "request", {.text = "Parts to move; connect it as a queue."}};
  takt::InPort<motion::JointState> measured{
      *this,
      "measured",
      {.text = "Position of the arm. If not connected, the arm starts at home and follows its set points."}};
  takt::InPort<basic::Flag> enable{
      *this,
      "enable",
      {.text = "False: come to rest on the path and wait. Counts as true before the first sample."}};
  takt::InPort<basic::Flag> holding{
      *this, "holding", {.text = "The gripper holds a part. Always true if not connected."}};
  takt::OutPort<motion::JointState> setpoint{*this, "setpoint", {.text = "Set points of the axes."}};
  takt::OutPort<basic::Flag> grip{*this, "grip", {.text = "True: the gripper must be closed."}};
  takt::OutPort<motion::PickPlan> plan{
      *this, "plan", {.text = "How long a request will take; written when the arm begins the request."}};
  takt::OutPort<motion::PickDone> done{
      *this, "done", {.text = "Result of a request: placed, rejected with the reason, or lost."}};

  takt::Property<std::string> model{
      *this, "model", "", {.text = "File with the arm's parameters; empty: the built-in arm."}};
  takt::Property<double> speed{
      *this, "speed", 1, {.min = 0.05, .max = 1, .text = "Fraction of the axes' velocities to use."}};
  takt::Property<double> line_speed{
      *this,
      "line_speed",
      0.6,
      {.unit = "m/s", .min = 0.01, .max = 5, .text = "Maximum speed of the tool on straight lines."}};
  takt::Property<double> approach{
      *this,
      "approach",
      0.15,
      {.unit = "m",
       .min = 0.01,
       .max = 1,
       .text = "Length of the straight lines above the part and its target place."}};
  takt::Property<double> grip_time{
      *this,
      "grip_time",
      0.3,
      {.unit = "s", .min = 0, .max = 10, .text = "Time to close or open the gripper."}};
  takt::Property<double> following{
      *this,
      "following",
      0.08,
      {.unit = "rad",
       .min = 0.001,
       .max = 3,
       .text = "If an axis is farther than this from its set point, the arm goes home."}};

  takt::Property<double> enable_timeout{
      *this,
      "enable_timeout",
      0,
      {.unit = "s",
       .min = 0,
       .max = 3600,
       .text = "A missing enable, or one older than this, counts as false; 0: enable never expires."}};

  arm_model::Parameters arm_;
  arm_model::Joints home_{};
  arm_model::Joints most_acceleration_{};
  std::optional<trajectory::Planner> planner_;
  trajectory::Plan plan_;
  trajectory::Path path_;
  bool began_ = false;
  bool planning_ = false;
  bool lost_ = false;
  bool answered_ = true;
  double since_request_ = 0;  // s, since the last request began
  motion::JointState state_;
  basic::Flag closed_;
  motion::PickPlan times_;
  motion::PickDone report_;  // result of the last request

  takt::Result<void> initialize() override {
    auto read = arm_model::read(model);
    if (const auto* problem = std::get_if<std::string>(&read))
      return takt::fail(*problem, "correct the file, or set property 'model' to another file");
    arm_ = std::get<arm_model::Parameters>(read);
    home_ = arm_model::home(arm_);
    most_acceleration_ = trajectory::Path::most_acceleration(arm_);
    path_ = trajectory::Path{home_};
    planner_.emplace(arm_);
    report_.result(motion::PICK_REFUSED);  // any result but PICK_PLACED: no part has been placed yet
    began_ = planning_ = false;
    return {};
  }

  void run(const takt::Cycle& cycle) noexcept override {
    if (measured.read() && (!began_ || is_off_the_path())) go_home_from(measured.value().position());
    if (!began_ && measured.connected()) return;  // wait for the first measured position
    began_ = true;
    enable.read();
    holding.read();
    if (!path_.busy() && !planning_ && request.read()) begin_request(request.value());
    since_request_ += cycle.seconds();
    if (planning_) continue_planning();
    path_.advance(common::is_enabled(enable, enable_timeout), most_acceleration_, cycle.seconds());
    if (path_.busy()) watch_part();
    if (path_.ended().any) end_leg(path_.ended().step);
    state_.position() = path_.position();
    state_.velocity() = path_.velocity();
    setpoint.write(state_);
    grip.write(closed_);
  }

  [[nodiscard]] bool is_off_the_path() const noexcept {
    for (std::size_t i = 0; i < arm_model::kAxes; ++i)
      if (!(std::abs(measured.value().position()[i] - path_.position()[i]) <= following)) return true;
    return false;
  }

  // Sends the arm home from `position`: after the start, and after something has moved or blocked the arm.
  void go_home_from(const arm_model::Joints& position) noexcept {
    for (const double joint : position)
      if (!std::isfinite(joint)) return fail("a measured position is not a finite number");
    planning_ = false;
    path_ = trajectory::Path{position};
    plan_.leg(trajectory::Step::home) = trajectory::Leg::turn(position, home_, limits());
    path_.begin(plan_, trajectory::Step::home);
    began_ = true;
    if (!answered_) finish(motion::PICK_LOST, motion::REFUSAL_NONE);
  }

  [[nodiscard]] trajectory::Limits limits() const noexcept {
    return trajectory::Path::limits(arm_, speed, line_speed);
  }

  static std::optional<KDL::Frame> frame(const motion::Pose& pose) noexcept {
    for (const double number : {pose.x(), pose.y(), pose.z(), pose.roll(), pose.pitch(), pose.yaw()})
      if (!(std::abs(number) < 1e3)) return {};
    return arm_model::frame({pose.x(), pose.y(), pose.z(), pose.roll(), pose.pitch(), pose.yaw()});
  }

  // Begins to plan a request. A request for the part that was placed last means that the network has lost the
  // result. In this case, sends the result again.
  void begin_request(const motion::PickRequest& part) noexcept {
    if (part.number() == report_.number() && report_.result() == motion::PICK_PLACED) {
      done.write(report_);
      return;
    }
    report_.number(part.number());
    since_request_ = 0;
    lost_ = answered_ = false;
    const auto pick = frame(part.pick());
    const auto place = frame(part.place());
    if (!pick || !place) {
      finish(motion::PICK_REFUSED, motion::REFUSAL_NO_POSE);
      return;
    }
    planner_->begin(
        {.pick = *pick, .place = *place, .approach = approach, .grip = grip_time, .limits = limits()}, home_,
        plan_);
    planning_ = true;
  }

  void continue_planning() noexcept {
    using State = trajectory::Planner::State;
    const State state = planner_->step();
    if (state == State::planning) return;
    planning_ = false;
    if (state == State::out_of_reach) finish(motion::PICK_REFUSED, motion::REFUSAL_OUT_OF_REACH);
    if (state == State::joint_limit) finish(motion::PICK_REFUSED, motion::REFUSAL_JOINT_LIMIT);
    if (state == State::singular) finish(motion::PICK_REFUSED, motion::REFUSAL_SINGULARITY);
    if (state != State::planned) return;
    path_.begin(plan_, trajectory::Step::to_pick);
    times_.number(report_.number());
    times_.placed(since_request_ + plan_.until(trajectory::Step::release));
    times_.ended(since_request_ + plan_.until(trajectory::Step::home));
    plan.write(times_);
  }

  // Notices the loss of a part. The gripper must hold the part from the end of gripping until the release.
  void watch_part() noexcept {
    using trajectory::Step;
    const Step step = path_.step();
    if (!holding.connected() || lost_ || step < Step::up || step > Step::lower) return;
    if (holding.value().value()) return;
    lost_ = true;
    if (step == Step::up) path_.give_up();
  }

  void end_leg(trajectory::Step step) noexcept {
    using trajectory::Step;
    if (step == Step::down) closed_.value(true);
    if (step == Step::lower || step == Step::home || (step == Step::up && path_.step() == Step::give_up))
      closed_.value(false);
    if (step == Step::release) finish(lost_ ? motion::PICK_LOST : motion::PICK_PLACED, motion::REFUSAL_NONE);
    if (step == Step::give_up) finish(motion::PICK_LOST, motion::REFUSAL_NONE);
  }

  void finish(motion::PickResult result, motion::PickRefusal refusal) noexcept {
    report_.result(result);
    report_.refusal(refusal);
    report_.duration(since_request_);
    done.write(report_);
    answered_ = true;
  }
};
TAKT_COMPONENT(Trajectory, "Set points of a six-axis arm that moves parts from one pose to another.")
