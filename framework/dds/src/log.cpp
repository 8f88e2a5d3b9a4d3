#include "log.hpp"

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include <fastdds/dds/log/Log.hpp>

#include <takt/core/words.hpp>
#include <takt/os/signals.hpp>

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
      since_ = now;
      shown_ = 0;
      if (held_back_ > 0 && print(std::to_string(held_back_) + " more messages were not printed"))
        held_back_ = 0;
    }
    const bool printed = ++shown_ <= kShown &&
                         print(std::string{entry.context.category == nullptr ? "" : entry.context.category} +
                               ": " + on_one_line(entry.message));
    if (!printed) ++held_back_;
  }

 private:
  static constexpr int kShown = 10;
  static constexpr auto kSpan = std::chrono::seconds{10};

  // Returns false if nothing reads standard error. Does not wait for a reader, because the process cannot end
  // before the log thread of Fast DDS has printed its last message.
  static bool print(const std::string& text) {
    const std::string line = "dds: " + text + "\n";
    std::string_view rest = line;
    while (!rest.empty()) {
      const std::size_t written = os::write_to_standard_error(rest, 0);
      if (written == 0) return false;
      rest.remove_prefix(written);
    }
    return true;
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
