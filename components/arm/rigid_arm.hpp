// The simulation of the component arm: six driven links as rigid bodies under gravity, with joint friction,
// using the forward dynamics of Orocos KDL. SI units, rad. The constructor allocates memory; real-time
// threads may call all other functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <kdl/chainfdsolver_recursive_newton_euler.hpp>

#include "arm_model/kinematics.hpp"

namespace arm {

using arm_model::Joints;
using arm_model::kAxes;

class RigidArm {
 public:
  static constexpr double kLongestStep = 1e-3;  ///< s; step() divides longer times
  static constexpr double kDryBand = 0.05;      ///< rad/s; below this speed, dry friction fades out
  static constexpr double kBraking = 15;        ///< rad/s^2, deceleration of every axis by its brake
  /// 1/s, maximum ratio of friction to rotor inertia. Above this ratio, the integration of an axis is
  /// unstable.
  static constexpr double kMostFriction = 1500;

  explicit RigidArm(const arm_model::Parameters& parameters)
      : position(arm_model::home(parameters)),
        parameters_(parameters),
        chain_(arm_model::chain(parameters)) {}
  RigidArm(const RigidArm&) = delete;
  RigidArm& operator=(const RigidArm&) = delete;

  Joints position;      ///< rad; initially at home
  Joints velocity{};    ///< rad/s
  double friction = 1;  ///< fraction of the model's friction to apply

  /// Returns the first axis whose friction exceeds kMostFriction, or kAxes if there is none.
  [[nodiscard]] static std::size_t too_stiff(const arm_model::Parameters& parameters) noexcept {
    std::size_t i = 0;
    while (i < kAxes &&
           parameters[i].viscous + parameters[i].dry / kDryBand < kMostFriction * parameters[i].rotor)
      ++i;
    return i;
  }

  /// Moves the links for `dt` seconds under this torque, with the fourth-order Runge-Kutta method. The torque
  /// is clamped to the limits of the drives.
  void step(const Joints& torque, double dt) noexcept {
    const int pieces = static_cast<int>(std::ceil(dt / kLongestStep - 1e-6));
    for (int n = 0; n < pieces; ++n) small_step(torque, dt / pieces);
    stop_at_limits();
  }
  /// Moves the links for `dt` seconds with closed brakes: every axis slows down and stops.
  void brake(double dt) noexcept {
    for (std::size_t i = 0; i < kAxes; ++i) {
      velocity[i] -= std::clamp(velocity[i], -kBraking * dt, kBraking * dt);
      position[i] += velocity[i] * dt;
    }
    stop_at_limits();
  }

  /// Returns the accelerations of the axes, in rad/s^2.
  [[nodiscard]] Joints acceleration(const Joints& at, const Joints& speed, const Joints& torque) noexcept {
    for (std::size_t i = 0; i < kAxes; ++i) {
      const arm_model::Axis& axis = parameters_[i];
      const double drag = axis.viscous * speed[i] + axis.dry * std::tanh(speed[i] / kDryBand);
      const auto row = static_cast<unsigned>(i);
      at_(row) = at[i];
      speed_(row) = speed[i];
      torque_(row) = std::clamp(torque[i], -axis.torque, axis.torque) - friction * drag;
    }
    solver_.CartToJnt(at_, speed_, torque_, no_forces_, result_);
    Joints result{};
    std::copy_n(result_.data.data(), kAxes, result.begin());
    return result;
  }

 private:
  static Joints plus(const Joints& value, const Joints& rate, double time) noexcept {
    Joints sum{};
    for (std::size_t i = 0; i < kAxes; ++i) sum[i] = value[i] + rate[i] * time;
    return sum;
  }

  void small_step(const Joints& torque, double dt) noexcept {
    const Joints& v1 = velocity;
    const Joints a1 = acceleration(position, v1, torque);
    const Joints v2 = plus(velocity, a1, dt / 2);
    const Joints a2 = acceleration(plus(position, v1, dt / 2), v2, torque);
    const Joints v3 = plus(velocity, a2, dt / 2);
    const Joints a3 = acceleration(plus(position, v2, dt / 2), v3, torque);
    const Joints v4 = plus(velocity, a3, dt);
    const Joints a4 = acceleration(plus(position, v3, dt), v4, torque);
    for (std::size_t i = 0; i < kAxes; ++i) {
      position[i] += dt / 6 * (v1[i] + 2 * v2[i] + 2 * v3[i] + v4[i]);
      velocity[i] += dt / 6 * (a1[i] + 2 * a2[i] + 2 * a3[i] + a4[i]);
    }
  }

  void stop_at_limits() noexcept {
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double within = std::clamp(position[i], parameters_[i].lower, parameters_[i].upper);
      if (within == position[i]) continue;
      position[i] = within;
      velocity[i] = 0;
    }
  }

  arm_model::Parameters parameters_;
  KDL::Chain chain_;
  KDL::ChainFdSolver_RNE solver_{chain_, KDL::Vector{0, 0, -9.81}};
  KDL::JntArray at_{kAxes};
  KDL::JntArray speed_{kAxes};
  KDL::JntArray torque_{kAxes};
  KDL::JntArray result_{kAxes};
  KDL::Wrenches no_forces_ = KDL::Wrenches(kAxes, KDL::Wrench::Zero());
};

}  // namespace arm
