#include "swap.hpp"

#include <utility>

#include <takt/executor/exchange.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/sealed_copy.hpp>

namespace takt::host {

namespace {

using channel::Doing;
using State = executor::Exchange::State;
using std::chrono::microseconds;

/// The number of attempts to exchange an instance whose state restore() must translate. An attempt fails if
/// the old instance saves a new state before the exchange.
constexpr int kMostAttempts = 1000;

class Work {
 public:
  explicit Work(const Swap& swap) : swap_(swap) {}

  Swapped carry_out() {
    if (auto prepared = prepare(); !prepared) return undone(in_words(prepared.problems()));
    executor::Exchange exchange{.index = swap_.index, .body = &swap_.body, .runs = kTrialRuns};
    for (int attempt = 1;; ++attempt) {
      switch (carry_out(exchange)) {
        case State::kept:
        case State::on_trial:  // the trial was cut short: the executors have halted, or the node has
                               // abandoned the swap
          begin_to_save();
          return {true, "from row " + std::to_string(exchange.row) + " of its executor on"};
        case State::put_back:
          return undone(std::string{"the old instance was put back at release "} +
                        std::to_string(exchange.cycle) + ": " + takt::to_text(exchange.error) + ": " +
                        exchange.text.c_str());
        case State::waiting:
          return undone(swap_.ends() ? "the device is stopping"
                                     : "the module was taken out of its table during the swap");
        case State::not_now:
          break;
      }
      if (attempt == kMostAttempts)
        return undone("restore() did not finish before the module's next run() in any of " +
                      std::to_string(attempt) + " attempts; make restore() faster");
      wait_for_run();
      if (auto followed = follow(); !followed) return undone(in_words(followed.problems()));
    }
  }

 private:
  template <class Call>
  Result<void> in(Doing doing, Call&& call) {
    swap_.activity.begin(swap_.index, doing, to_ns(os::now()));
    Result<void> result = std::forward<Call>(call)();
    swap_.activity.end();
    if (result && swap_.ends()) return fail("the device is stopping");
    return result;
  }
  static Result<void> naming(const char* hook, Result<void> result) {
    if (result) return result;
    return fail(std::string{hook} + " failed: " + in_words(result.problems()));
  }

  Result<void> prepare() {
    // If a shared object is already loaded, loading it again gives the old code, even if its file has
    // changed. In this case Globals::own loads a copy of the file, and so the new code.
    const auto globals =
        os::Library::is_loaded(swap_.path) ? os::Library::Globals::own : os::Library::Globals::shared;
    auto done = in(Doing::load, [&]() -> Result<void> {
      auto copy = os::sealed_copy(swap_.component, swap_.path);
      if (!copy) return copy.problems();
      auto loaded = swap_.next.load(swap_.path, globals, false, std::move(*copy), swap_.origin);
      if (loaded) loaded = swap_.next.match(swap_.before);
      return loaded ? swap_.connect() : loaded;
    });
    if (!done) return done;
    done = in(Doing::initialize,
              [&] { return naming("initialize()", swap_.next.initialize(irp::Property{swap_.properties})); });
    if (!done) return done;
    initialized_ = true;
    if (done = follow(); !done) return done;
    return in(Doing::start, [&] { return naming("start()", swap_.next.start()); });
  }
  Result<void> follow() {
    return in(Doing::initialize, [&] { return swap_.next.follow(swap_.before); });
  }

  [[nodiscard]] bool out() const {
    return swap_.block.in_tables.load(std::memory_order_relaxed) == 0 || swap_.ends();
  }
  // Requests the exchange, and waits for the exchange and the trial. During the exchange no handler is
  // called, although handlers and rows run on different threads. So no handler works for an instance that has
  // been replaced.
  State carry_out(executor::Exchange& exchange) {
    State state = State::waiting;
    {
      const auto no_handler = swap_.exclude();
      swap_.threads.exchange(exchange);
      state = wait_while(State::waiting, exchange);
      if (state == State::on_trial || state == State::kept) hand_over(swap_.next, swap_.before);
    }
    if (state != State::on_trial) return state;
    state = wait_while(State::on_trial, exchange);
    if (state == State::put_back) {
      const auto no_handler = swap_.exclude();
      hand_over(swap_.before, swap_.next);
    }
    return state;
  }
  void hand_over(ThreadModule& to, ThreadModule& from) {
    to.take_over_handlers(from);
    swap_.handle_by(to);
  }
  // Waits until the exchange leaves `state`, and returns the new state. Returns `waiting` if the exchange was
  // withdrawn, and `on_trial` if the executors have halted or the node has abandoned the swap.
  State wait_while(State state, const executor::Exchange& exchange) {
    while (exchange.state.load(std::memory_order_acquire) == state) {  // pairs with the stores in
                                                                       // executor.cpp
      if (state == State::waiting ? out() && swap_.threads.withdraw() : swap_.ends()) return state;
      os::sleep_until(os::now() + microseconds{500});
    }
    return exchange.state.load(std::memory_order_acquire);
  }
  // Lets the new instance save its state from now on, and waits until its first state has replaced the old
  // one. During the trial the new instance saved nothing, so that the old instance could have continued with
  // its own state.
  void begin_to_save() {
    const std::uint64_t number = swap_.place.whole.load(std::memory_order_relaxed);
    swap_.next.save_in(swap_.place);
    // Pairs with the store in SavedState::save().
    while (swap_.next.saves() != nullptr && swap_.place.whole.load(std::memory_order_acquire) == number &&
           !out())
      os::sleep_until(os::now() + microseconds{500});
  }
  // Waits until the module's next run() has ended, because from then on, most time is left until the
  // following run().
  void wait_for_run() const {
    // Relaxed: only the time matters. Nothing that the run() has written is read here.
    const std::uint64_t cycles = swap_.block.cycles.load(std::memory_order_relaxed);
    while (swap_.block.cycles.load(std::memory_order_relaxed) == cycles && !out())
      os::sleep_until(os::now() + microseconds{20});
  }

  Swapped undone(std::string text) {
    if (initialized_ && !swap_.ends())
      static_cast<void>(in(Doing::destruct, [&] { return swap_.next.destruct(); }));
    return {false, std::move(text)};
  }

  const Swap& swap_;
  bool initialized_ = false;
};

}  // namespace

Swapped carry_out(const Swap& swap) { return Work{swap}.carry_out(); }

}  // namespace takt::host
