// Exchanges the body (see body.hpp) of a periodic thread module while its executor continues to run.
//
// The executor's thread exchanges the bodies between two rows, so no release is missed and no two run() calls
// overlap. The first runs of the new body are a trial: if one of them fails, the executor puts the old body
// back at once, and the old body serves the release in which the new body failed.
#pragma once

#include <atomic>
#include <cstdint>

#include <takt/component.hpp>
#include <takt/core/fixed_text.hpp>
#include <takt/executor/body.hpp>

namespace takt::executor {

struct Exchange {
  enum class State : std::uint32_t {
    waiting,   ///< no row in which the module is in the tables has begun yet
    not_now,   ///< the new body could not take over the state now; request the exchange again
    on_trial,  ///< the new body runs, and its trial has not ended
    kept,      ///< the trial succeeded: `runs` runs without an error; the new body stays
    put_back,  ///< the trial failed, and the old body runs again
  };

  std::uint32_t index = 0;  ///< the module's index on its device
  Body* body = nullptr;     ///< the new body
  std::uint64_t runs = 1;   ///< length of the trial: number of runs of the new body

  /// The executor stores `state` after the members below. The executor no longer uses this object once the
  /// state is `kept` or `put_back`.
  std::atomic<State> state{State::waiting};
  std::uint64_t row = 0;              ///< the first row that called the new body
  ErrorType error = ErrorType::none;  ///< for put_back: the error of the new body
  std::uint64_t cycle = 0;            ///< for put_back: the module's cycle in which the error occurred
  FixedText<256> text{};              ///< for put_back: the reason for the error
};

}  // namespace takt::executor
