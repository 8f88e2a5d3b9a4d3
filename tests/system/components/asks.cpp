// Calls a service with increasing numbers, beginning with `first`. Each call starts as soon as the previous
// call has ended. The module writes the results to `file`.
#include <takt/component.hpp>

#include <fstream>
#include <string>

#include "sample.hpp"

class Asks : public takt::Component {
  takt::Client<samples::Count, samples::Count> ask{*this, "ask"};
  takt::Property<std::int64_t> first{*this, "first", 1};
  takt::Property<std::int64_t> timeout_ms{*this, "timeout_ms", 1000, {.unit = "ms"}};
  takt::Property<std::string> file{*this, "file", ""};

  samples::Count count_;
  std::uint64_t number_ = 0;
  std::uint64_t told_[6] = {};  // for each CallStatus, the number of calls that ended with it
  std::uint64_t wrong_ = 0;
  std::string refusal_ = std::string(128, ' ');

  takt::Result<void> initialize() override {
    count_.few().reserve(4);
    number_ = static_cast<std::uint64_t>(first.value());
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    const takt::CallStatus status = ask.poll();
    if (status == takt::CallStatus::pending) return;
    ++told_[static_cast<std::size_t>(status)];
    if (status == takt::CallStatus::replied &&
        (!is_whole(ask.reply()) || ask.reply().number() != 2 * number_))
      ++wrong_;
    if (status == takt::CallStatus::refused) refusal_.assign(ask.reason());
    fill(count_, ++number_);
    ask.call(count_, std::chrono::milliseconds{timeout_ms});
  }
  void destruct() override {
    if (file.value().empty()) return;
    using takt::CallStatus;
    const auto of = [this](CallStatus status) { return told_[static_cast<std::size_t>(status)]; };
    std::ofstream(file) << "{\"replied\": " << of(CallStatus::replied)
                        << ", \"refused\": " << of(CallStatus::refused)
                        << ", \"timed_out\": " << of(CallStatus::timed_out)
                        << ", \"nobody\": " << of(CallStatus::nobody) << ", \"wrong\": " << wrong_
                        << ", \"late\": " << ask.late() << ", \"last\": " << number_ << ", \"refusal\": \""
                        << refusal_ << "\"}\n";
  }
};
TAKT_COMPONENT(Asks)
