// Reports the calls of a thread module to libtakt_check, which watches the module (`--check-realtime`).
#pragma once

#include <cstdint>

#include <takt/channel/check_reporter.hpp>
#include <takt/executor/body.hpp>

namespace takt::host {

/// Calls a module for an executor, and reports each call to libtakt_check. If libtakt_check is not loaded,
/// the executor instead calls the module directly.
class ReportingBody final : public executor::Body {
 public:
  ReportingBody(executor::Body& body, std::uint32_t module, channel::CheckReporter reporter)
      : body_(body), module_(module), reporter_(reporter) {}

  executor::Outcome run(const Cycle& cycle) noexcept override {
    const std::uint64_t before = reporter_.enter(module_, channel::Doing::run);
    const executor::Outcome outcome = body_.run(cycle);
    reporter_.leave(before);
    return outcome;
  }
  executor::Outcome condition(const Cycle& cycle, bool* ready) noexcept override {
    const std::uint64_t before = reporter_.enter(module_, channel::Doing::condition);
    const executor::Outcome outcome = body_.condition(cycle, ready);
    reporter_.leave(before);
    return outcome;
  }
  bool take_over(executor::Body& before) noexcept override {
    return body_.take_over(static_cast<ReportingBody&>(before).body_);
  }
  [[nodiscard]] bool has_news(Instant now) const noexcept override { return body_.has_news(now); }

 private:
  executor::Body& body_;
  std::uint32_t module_;
  channel::CheckReporter reporter_;
};

}  // namespace takt::host
