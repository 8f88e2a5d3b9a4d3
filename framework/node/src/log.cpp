#include <takt/node/log.hpp>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <takt/core/words.hpp>
#include <takt/os/signals.hpp>

namespace takt::node {

/// The lines that wait to be printed.
struct LogQueue {
  std::mutex mutex;
  std::condition_variable changed;
  std::string lines;
  std::uint64_t dropped = 0;  // number of lines that were dropped after `lines`
  bool ending = false;        // no further lines follow
  bool given_up = false;      // the lines that are left are not printed any more
  bool ended = false;

  void put(const std::string& line) {
    const std::lock_guard lock{mutex};
    if (dropped > 0 || lines.size() + line.size() > LogThread::kMost)
      ++dropped;
    else
      lines += line;
    changed.notify_all();
  }
  bool has_given_up() {
    const std::lock_guard lock{mutex};
    return given_up;
  }
};

namespace {

constexpr int kLookEveryMs = 100;

bool silent = false;
std::mutex present_mutex;
std::shared_ptr<LogQueue> present;  // null: log() prints the lines itself

std::shared_ptr<LogQueue> present_queue() {
  const std::lock_guard lock{present_mutex};
  return present;
}
void set_present_queue(std::shared_ptr<LogQueue> queue) {
  const std::lock_guard lock{present_mutex};
  present = std::move(queue);
}

// Prints each line with one write, so that the lines of several nodes do not mix.
void print_lines(LogQueue& queue, std::string_view lines) {
  while (!lines.empty() && !queue.has_given_up()) {
    const std::string_view line = lines.substr(0, lines.find('\n') + 1);
    lines.remove_prefix(os::write_to_standard_error(line, kLookEveryMs));
  }
}

void print(LogQueue& queue) {
  std::unique_lock lock{queue.mutex};
  while (true) {
    queue.changed.wait(lock, [&queue] { return !queue.lines.empty() || queue.ending; });
    if (queue.lines.empty() || queue.given_up) break;
    std::string lines = std::exchange(queue.lines, {});
    if (const std::uint64_t dropped = std::exchange(queue.dropped, 0); dropped > 0)
      lines += fmt::format("{} lines are missing here, because nothing read this output\n", dropped);
    lock.unlock();
    print_lines(queue, lines);
    lock.lock();
  }
  queue.ended = true;
  queue.changed.notify_all();
}

}  // namespace

void log_nothing() { silent = true; }

void log(std::string_view device, std::string_view module, std::string_view text) {
  if (silent) return;
  const auto now = std::chrono::system_clock::now();
  const auto ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm local{};
  ::localtime_r(&seconds, &local);
  const std::string line =
      fmt::format("{:02}:{:02}:{:02}.{:03} {}{}{}: {}\n", local.tm_hour, local.tm_min, local.tm_sec, ms,
                  device, module.empty() ? "" : ".", module, on_one_line(text));
  if (const auto queue = present_queue())
    queue->put(line);
  else
    std::fwrite(line.data(), 1, line.size(), stderr);
}

void LogThread::start() {
  queue_ = std::make_shared<LogQueue>();
  auto thread = os::Thread::start(
      {.name = "takt-log"}, [queue = queue_] { print(*queue); }, nullptr);
  if (!thread) return;
  thread_ = std::move(*thread);
  set_present_queue(queue_);
}

LogThread::~LogThread() {
  if (!thread_.running()) return;
  set_present_queue(nullptr);
  std::unique_lock lock{queue_->mutex};
  queue_->ending = true;
  queue_->changed.notify_all();
  queue_->changed.wait_for(lock, kLastLines, [this] { return queue_->ended; });
  if (queue_->ended) return;
  // The thread may still wait for a reader. It ends when its present attempt does, at the latest with the
  // process.
  queue_->given_up = true;
  thread_.detach();
}

}  // namespace takt::node
