#include "log.hpp"

#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include <fastdds/dds/log/Log.hpp>

#include <takt/core/words.hpp>

namespace takt::dds {

namespace {

namespace fast = eprosima::fastdds::dds;
using Clock = std::chrono::steady_clock;

std::mutex looking;
std::function<bool(const std::string&)> look_first;

bool is_taken(const std::string& message) {
  const std::lock_guard lock{looking};
  return look_first && look_first(message);
}

class ToStandardError final : public fast::LogConsumer {
 public:
  // Prints a message of Fast DDS. Fast DDS calls this function on its log thread, one message at a time.
  void Consume(const fast::Log::Entry& entry) override {
    if (is_taken(entry.message)) return;
    const auto now = Clock::now();
    if (now - since_ > kSpan) {
      if (held_back_ > 0) print(std::to_string(held_back_) + " more messages were not printed");
      since_ = now;
      shown_ = held_back_ = 0;
    }
    if (++shown_ > kShown) {
      ++held_back_;
      return;
    }
    print(std::string{entry.context.category == nullptr ? "" : entry.context.category} + ": " +
          on_one_line(entry.message));
  }

 private:
  static constexpr int kShown = 10;
  static constexpr auto kSpan = std::chrono::seconds{10};

  static void print(const std::string& text) {
    const std::string line = "dds: " + text + "\n";
    std::fputs(line.c_str(), stderr);
  }

  Clock::time_point since_{};
  int shown_ = 0;
  int held_back_ = 0;
};

}  // namespace

void look_at_log(std::function<bool(const std::string&)> look) {
  const std::lock_guard lock{looking};
  look_first = std::move(look);
}

void log_to_standard_error() {
  fast::Log::ClearConsumers();
  fast::Log::RegisterConsumer(std::make_unique<ToStandardError>());
  fast::Log::SetVerbosity(fast::Log::Kind::Error);
}

}  // namespace takt::dds
