// A thread module that a tool watches while it runs.
#pragma once

#include <cstdint>

#include <takt/channel/module_watch.hpp>
#include <takt/executor/body.hpp>

namespace takt::host {

/// Calls a module for an executor, and reports each call to a tool that watches the modules. Without such a
/// tool, the executor calls the module directly.
class WatchedBody final : public executor::Body {
 public:
  WatchedBody(executor::Body& body, std::uint32_t module, channel::ModuleWatch watch)
      : body_(body), module_(module), watch_(watch) {}

  executor::Outcome run(const Cycle& cycle) noexcept override {
    const std::uint64_t before = watch_.enter(module_, channel::Doing::run);
    const executor::Outcome outcome = body_.run(cycle);
    watch_.leave(before);
    return outcome;
  }
  executor::Outcome condition(const Cycle& cycle, bool* ready) noexcept override {
    const std::uint64_t before = watch_.enter(module_, channel::Doing::condition);
    const executor::Outcome outcome = body_.condition(cycle, ready);
    watch_.leave(before);
    return outcome;
  }
  bool take_over(executor::Body& before) noexcept override {
    return body_.take_over(static_cast<WatchedBody&>(before).body_);
  }
  [[nodiscard]] bool has_news(Instant now) const noexcept override { return body_.has_news(now); }

 private:
  executor::Body& body_;
  std::uint32_t module_;
  channel::ModuleWatch watch_;
};

}  // namespace takt::host
