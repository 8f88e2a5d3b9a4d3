#include "web/stream.hpp"

#include <algorithm>
#include <random>
#include <utility>

#include <fmt/format.h>

namespace takt::tool::web {

std::string event_text(const std::string& name, const std::string& data) {
  return "event: " + name + "\ndata: " + data + "\n\n";
}

void Stream::send(const std::string& text) {
  {
    const std::lock_guard lock{mutex_};
    if (ended_) return;
    if (waiting_.size() + text.size() > kMostBytes) {
      ended_ = true;
      waiting_.clear();
    } else {
      waiting_ += text;
    }
  }
  arrived_.notify_all();
}

std::optional<std::string> Stream::next(std::chrono::milliseconds limit) {
  std::unique_lock lock{mutex_};
  arrived_.wait_for(lock, limit, [this] { return ended_ || !waiting_.empty(); });
  if (ended_) return std::nullopt;
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

std::shared_ptr<Stream> Streams::open() {
  const std::lock_guard lock{mutex_};
  std::erase_if(all_, [](const auto& stream) { return stream->ended(); });
  if (ended_ || all_.size() >= kMost) return nullptr;
  return *all_.insert(std::make_shared<Stream>(random_word(16))).first;
}

void Streams::close(const std::shared_ptr<Stream>& stream) {
  stream->end();
  const std::lock_guard lock{mutex_};
  all_.erase(stream);
}

void Streams::send(const std::string& text) {
  const std::lock_guard lock{mutex_};
  for (const auto& stream : all_) stream->send(text);
}

std::shared_ptr<Stream> Streams::find(const std::string& id) const {
  const std::lock_guard lock{mutex_};
  const auto found = std::find_if(all_.begin(), all_.end(), [&id](const auto& s) { return s->id() == id; });
  return found == all_.end() ? nullptr : *found;
}

std::size_t Streams::count() const {
  const std::lock_guard lock{mutex_};
  return static_cast<std::size_t>(
      std::count_if(all_.begin(), all_.end(), [](const auto& stream) { return !stream->ended(); }));
}

void Streams::end() {
  const std::lock_guard lock{mutex_};
  ended_ = true;
  for (const auto& stream : all_) stream->end();
}

std::string random_word(std::size_t bytes) {
  std::random_device device;  // reads the random number generator of the system
  std::string word;
  for (std::size_t i = 0; i < bytes; ++i) word += fmt::format("{:02x}", device() & 0xFFU);
  return word;
}

}  // namespace takt::tool::web
