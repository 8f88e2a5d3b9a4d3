// Another body for a periodic thread module while its rows go on.
//
// The executor's thread takes it between two rows, so that no release is missed and no run() meets another.
// Its first runs are a trial: where one of them goes wrong, the body before it is back at once, and serves
// the very release in which run() failed.
#pragma once

#include <atomic>
#include <cstdint>

#include <takt/component.hpp>
#include <takt/core/fixed_text.hpp>
#include <takt/executor/body.hpp>

namespace takt::executor {

struct Exchange {
  enum class State : std::uint32_t {
    waiting,   ///< for a row that finds the module in the tables
    not_now,   ///< the body did not take over; it may be asked again
    on_trial,  ///< it runs
    kept,      ///< `runs` went well: it stays
    put_back,  ///< one went wrong, and the body before it runs again
  };

  std::uint32_t index = 0;  ///< of the module on its device
  Body* body = nullptr;     ///< that comes
  std::uint64_t runs = 1;   ///< that are to go well

  /// SYNC: exchange. Publishes what follows; after `kept` and `put_back` the executor is done with all of it.
  std::atomic<State> state{State::waiting};
  std::uint64_t row = 0;              ///< from which on it ran
  ErrorType error = ErrorType::none;  ///< that put it back
  std::uint64_t cycle = 0;            ///< of the module, in which that was
  FixedText<256> text{};              ///< why
};

}  // namespace takt::executor
