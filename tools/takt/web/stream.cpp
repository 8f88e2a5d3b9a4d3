#include "web/stream.hpp"

#include <algorithm>
#include <random>
#include <utility>

#include <fmt/format.h>

namespace takt::tool::web {

static_assert(Streams::kMost * Stream::kShare <= Stream::kMostOfAll);

std::string event_text(const std::string& name, const std::string& data) {
  return "event: " + name + "\ndata: " + data + "\n\n";
}

Stream::~Stream() { forget(queued_); }

void Stream::count(std::size_t bytes) {
  queued_ += bytes;
  all_ += bytes;
}

void Stream::forget(std::size_t bytes) {
  queued_ -= bytes;
  all_ -= bytes;
}

void Stream::send(const std::string& text) {
  {
    const std::lock_guard lock{mutex_};
    if (ended_) return;
    const std::size_t size = queued_ + text.size();
    if (size > kMostBytes || (size > kShare && all_ + text.size() > kMostOfAll)) {
      ended_ = true;
      forget(waiting_.size());
      waiting_ = {};
    } else {
      waiting_ += text;
      count(text.size());
    }
  }
  arrived_.notify_all();
}

std::optional<std::string> Stream::next(std::chrono::milliseconds limit) {
  std::unique_lock lock{mutex_};
  forget(std::exchange(taken_, 0));
  arrived_.wait_for(lock, limit, [this] { return ended_ || !waiting_.empty(); });
  if (ended_) return std::nullopt;
  taken_ = waiting_.size();
  return std::exchange(waiting_, {});
}

void Stream::end() {
  {
    const std::lock_guard lock{mutex_};
    ended_ = true;
  }
  arrived_.notify_all();
}

bool Stream::ended() const {
  const std::lock_guard lock{mutex_};
  return ended_;
}

std::shared_ptr<Stream> Streams::open(const std::string& address) {
  const std::lock_guard lock{mutex_};
  const auto own = static_cast<std::size_t>(
      std::count_if(all_.begin(), all_.end(), [&](const auto& each) { return each.second == address; }));
  if (ended_ || own >= kMost - all_.size()) return nullptr;
  return all_.emplace(std::make_shared<Stream>(random_word(16), bytes_), address).first->first;
}

void Streams::close(const std::shared_ptr<Stream>& stream) {
  stream->end();
  const std::lock_guard lock{mutex_};
  all_.erase(stream);
}

void Streams::send(const std::string& text) {
  const std::lock_guard lock{mutex_};
  for (const auto& [stream, address] : all_) stream->send(text);
}

std::shared_ptr<Stream> Streams::find(const std::string& id) const {
  const std::lock_guard lock{mutex_};
  const auto found =
      std::find_if(all_.begin(), all_.end(), [&id](const auto& each) { return each.first->id() == id; });
  return found == all_.end() ? nullptr : found->first;
}

std::size_t Streams::count() const {
  const std::lock_guard lock{mutex_};
  return static_cast<std::size_t>(
      std::count_if(all_.begin(), all_.end(), [](const auto& each) { return !each.first->ended(); }));
}

void Streams::end() {
  const std::lock_guard lock{mutex_};
  ended_ = true;
  for (const auto& [stream, address] : all_) stream->end();
}

std::string random_word(std::size_t bytes) {
  std::random_device device;  // reads the random number generator of the system
  std::string word;
  for (std::size_t i = 0; i < bytes; ++i) word += fmt::format("{:02x}", device() & 0xFFU);
  return word;
}

}  // namespace takt::tool::web
