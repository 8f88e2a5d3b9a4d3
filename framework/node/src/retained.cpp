#include <takt/node/retained.hpp>

#include <limits>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/core/hex.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/futex.hpp>
#include "whole_file.hpp"

namespace takt::node {

namespace {

using json = nlohmann::ordered_json;

constexpr const char* kSavedFormat = "takt saved 1";
constexpr std::size_t kMostSavedBytes = 2 * channel::kMostSaved + 1024;

}  // namespace

SavedFile::SavedFile(const std::string& folder, const std::string& cell, const std::string& device,
                     const std::string& module)
    : path_(folder + "/" + cell + "." + device + "." + module + ".saved") {}

Result<void> SavedFile::write(const channel::SavedState::Copy& saved) const {
  return write_whole(path_, kSavedFormat,
                     model::json_text({{"version", saved.version},
                                       {"bytes", in_hex(std::span{saved.bytes}.first(saved.size))}}));
}

Result<void> SavedFile::read_into(channel::SavedState& state) const {
  const Problem damaged{path_, "the saved state of the module is damaged", "the module starts without it"};
  const auto body = read_whole(path_, kSavedFormat, kMostSavedBytes, damaged);
  if (!body) return body.problems();
  if (!*body) return {};
  try {
    const json value = model::parse_json(**body);
    const auto version = model::whole_number(value.at("version"));
    const auto bytes = bytes_of_hex(value.at("bytes").get<std::string>());
    if (!version || *version > std::numeric_limits<std::uint32_t>::max() || !bytes ||
        bytes->size() > channel::kMostSaved)
      return Problems{damaged};
    state.save(bytes->data(), static_cast<std::uint32_t>(bytes->size()), static_cast<std::uint32_t>(*version),
               0);
    return {};
  } catch (const json::exception&) {
    return Problems{damaged};
  }
}

Result<void> SavedFile::remove() const { return os::remove_file(path_); }

Result<std::unique_ptr<Retained>> Retained::start(std::vector<One> all,
                                                  std::function<void(const std::string&)> report,
                                                  Nanoseconds every) {
  std::unique_ptr<Retained> retained{new Retained{std::move(all), std::move(report)}};
  auto thread = os::Thread::start(
      {.name = "takt-retain"},
      [mine = retained.get(), every] {
        std::uint32_t asked = 0;
        bool last = false;
        while (!last) {
          os::futex_wait(mine->asked_, asked, ~0U, os::now() + every);
          last = mine->end_.load();  // read before the write, so that the last state is always written
          asked = mine->asked_.load();
          mine->write_changes();
          mine->done_.store(asked);
        }
        mine->finished_ = true;
      },
      nullptr);
  if (!thread) return thread.problems();
  retained->thread_ = std::move(*thread);
  return retained;
}

Retained::~Retained() {
  static_cast<void>(finish());
  thread_.join();
}

bool Retained::finish() {
  if (!end_.exchange(true)) update();
  return finished_;
}

void Retained::update() {
  asked_.fetch_add(1);
  os::futex_wake(asked_, ~0U);
}

std::optional<Result<void>> Retained::updated(const channel::SavedState& state) const {
  if (done_.load() != asked_.load()) return std::nullopt;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (all_[i].state == &state && failed_[i].load())
      return fail("cannot write " + all_[i].file.path(), "the log of the node states the reason");
  }
  return Result<void>{};
}

void Retained::write_changes() {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    One& one = all_[i];
    const std::uint64_t number = one.state->whole.load(std::memory_order_acquire);  // pairs with save()
    if (number == one.written) continue;
    Result<void> written;
    if (number == 0) {
      written = one.file.remove();
      if (written) one.written = 0;
    } else if (const auto saved = one.state->copy()) {
      written = one.file.write(*saved);
      if (written) one.written = saved->number;
    } else {
      continue;  // the module is saving this state now; the next round writes it
    }
    if (!written && !failed_[i])
      report_("warning: cannot write the state that modules retain to disk: " + in_words(written.problems()));
    if (written && failed_[i]) report_("the state that modules retain is on disk again: " + one.file.path());
    failed_[i] = !written;
  }
}

}  // namespace takt::node
