// Exchanges the body of a periodic thread module while its rows continue.
//
// The executor's thread takes the new body between two rows, so no release is missed and no two run() calls
// overlap. The first runs are a trial: if one of them fails, the old body returns at once and serves the same
// release in which run() failed.
#pragma once

#include <atomic>
#include <cstdint>

#include <takt/component.hpp>
#include <takt/core/fixed_text.hpp>
#include <takt/executor/body.hpp>

namespace takt::executor {

struct Exchange {
  enum class State : std::uint32_t {
    waiting,   ///< waits for a row that finds the module in the tables
    not_now,   ///< the new body could not take over now; try again
    on_trial,  ///< the new body runs
    kept,      ///< the new body stays, after `runs` runs without an error
    put_back,  ///< a run failed, and the old body runs again
  };

  std::uint32_t index = 0;  ///< the module's index on its device
  Body* body = nullptr;     ///< the new body
  std::uint64_t runs = 1;   ///< number of runs in the trial

  /// SYNC: exchange. Publishes the members below. After `kept` or `put_back` the executor no longer uses this
  /// object.
  std::atomic<State> state{State::waiting};
  std::uint64_t row = 0;              ///< first row of the new body
  ErrorType error = ErrorType::none;  ///< the error that put the old body back
  std::uint64_t cycle = 0;            ///< the module's cycle in which the error occurred
  FixedText<256> text{};              ///< the reason
};

}  // namespace takt::executor
