// libtakt_process: the program's side of channel/release_slot.hpp, inside the user's own program.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <takt/process.h>
#include <takt/channel/module_watch.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/violations.hpp>
#include <takt/component/port.hpp>
#include <takt/component/saved.hpp>
#include <takt/component/service.hpp>
#include <takt/core/hex.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/shared_memory.hpp>
#include <takt/os/waker.hpp>
#include "program_properties.hpp"

/// Defined by TAKT_SAVED in a program in C.
extern "C" __attribute__((weak)) const takt_saved_state takt_saved;

namespace {

using namespace takt;

constexpr const char* kOtherVersion =
    "takt-node and libtakt_process have different versions; install the same version of both";

/// The ports of the program, in the order of construction.
std::vector<PortBase*>& ports() {
  static std::vector<PortBase*> all;
  return all;
}
/// The Saved variables of the program, in the order of construction.
std::vector<SavedBase*>& saved() {
  static std::vector<SavedBase*> all;
  return all;
}

/// This program's side of its release slot, from the first line of main() to the end of the program.
class Guest {
 public:
  void attach(channel::ReleaseSlotKind kind, const char* function);
  void wait(const char* function);

  [[nodiscard]] const channel::ReleaseSlot* slot() const { return slot_; }
  [[nodiscard]] const channel::Taken& taken() const { return taken_; }

 private:
  [[noreturn]] static void refuse(const char* function, const std::string& what);
  static void check_ports(const char* function);
  void find_saved(const char* function);
  void restore() const;
  void describe(channel::ReleaseSlotKind kind) const;
  static void check_properties(const char* function);
  void connect_ports(const char* function);
  [[nodiscard]] static std::int64_t event_at();
  bool released() const {
    return slot_->released.load(std::memory_order_acquire) != taken_.count;
  }  // SYNC: released
  void body_done();
  void spin_until_release();
  bool release_by_event();
  void sleep_on_wake_word();
  void end_if_requested() const;

  os::SharedMemory slot_memory_;
  os::SharedMemory wake_word_memory_;
  channel::ReleaseSlot* slot_ = nullptr;
  channel::WakeWord* wake_word_ = nullptr;
  os::WakeMargin margin_{Nanoseconds{0}};
  std::vector<os::SharedMemory> link_memories_;
  PortContext context_;
  takt_saved_state saved_{};  // the saved variable; data is null if there is none
  channel::Taken taken_;      // the release that is served, or that was served last
  Instant started_{};
  channel::ModuleWatch watch_;
  std::uint32_t watched_as_ = 0;
};

void Guest::refuse(const char* function, const std::string& what) {
  std::fprintf(stderr, "takt: %s(): %s\n", function, what.c_str());
  std::exit(1);
}

void Guest::check_ports(const char* function) {
  for (const PortBase* port : ports()) {
    const auto same = [port](const PortBase* other) { return other->name() == port->name(); };
    if (std::count_if(ports().begin(), ports().end(), same) > 1)
      refuse(function, "the program has two ports '" + port->name() + "'; give each a different name");
  }
}

void Guest::find_saved(const char* function) {
  std::vector<takt_saved_state> all;
  for (const SavedBase* one : saved()) all.push_back({one->version(), one->size(), one->data()});
  if (&takt_saved != nullptr) all.push_back(takt_saved);
  if (all.empty()) return;
  if (all.size() > 1) refuse(function, "the program saves more than one variable; put them into one struct");
  saved_ = all[0];
  if (saved_.data == nullptr || saved_.size == 0 || saved_.size > channel::kMostSaved) {
    refuse(function, "the saved variable has " + std::to_string(saved_.size) + " bytes; use 1 to " +
                         std::to_string(channel::kMostSaved) + " bytes");
  }
}

// A value of another version or size is not restored.
void Guest::restore() const {
  const channel::SavedState::Place* before = saved_.data == nullptr ? nullptr : slot_->saved.saved();
  if (before == nullptr) return;
  const bool same = before->version == saved_.version && before->size == saved_.size;
  if (same) std::memcpy(saved_.data, before->bytes.data(), saved_.size);
  for (SavedBase* one : saved()) one->set_restored(same);
  if (same) {
    std::puts("takt: the program's saved state was restored");
  } else {
    std::printf(
        "takt: the program's saved state was not restored: it has version %u (%u bytes), but this program "
        "saves version %u (%u bytes)\n",
        before->version, before->size, saved_.version, saved_.size);
  }
}

// If the program was started only to describe itself, sends the description and ends the program.
void Guest::describe(channel::ReleaseSlotKind kind) const {
  os::MessageSocket asker{os::take_fd_from_environment("TAKT_DESCRIBE_FD")};
  if (!asker.fd()) return;
  const auto member = [](const char* name, std::string_view text) {
    return in_json(name) + ":" + in_json(text);
  };
  std::string list;
  for (const PortBase* port : ports()) {
    list += (list.empty() ? "{" : ",{") + member("name", port->name()) + "," +
            member("direction", to_text(port->direction())) + "," + member("role", to_text(port->role())) +
            "," + member("description", port->type().description) + "," + member("text", port->text()) + "," +
            member("safe", in_hex(port->safe())) + "}";
  }
  std::string problems;
  for (const Problem& problem : check_program_properties()) {
    problems += (problems.empty() ? "{" : ",{") + member("what", problem.what) + "," +
                member("fix", problem.fix) + "}";
  }
  std::string kept;
  if (saved_.data != nullptr)
    kept = R"(,"saved":{"version":)" + std::to_string(saved_.version) + R"(,"bytes":)" +
           std::to_string(saved_.size) + "}";
  asker.send_wait("{" +
                  member("operation", kind == channel::ReleaseSlotKind::periodic ? "periodic" : "sporadic") +
                  R"(,"ports":[)" + list + R"(],"properties":)" + program_properties_json() +
                  R"(,"problems":[)" + problems + "]" + kept + "}");
  std::_Exit(0);
}

void Guest::check_properties(const char* function) {
  const Problems problems = check_program_properties();
  for (const Problem& problem : problems)
    std::fprintf(stderr, "takt: %s(): %s\n", function, in_words({problem}).c_str());
  if (!problems.empty()) std::exit(1);
}

// Connects the ports to the links in TAKT_LINKS, "PORT=FD,PORT=FD,...". A port may occur several times.
void Guest::connect_ports(const char* function) {
  const std::string links = os::take_from_environment("TAKT_LINKS");
  std::string_view rest = links;
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const std::string_view name = one.substr(0, one.find('='));
    const std::string_view number = one.substr(std::min(one.size(), name.size() + 1));
    int fd = -1;
    std::from_chars(number.data(), number.data() + number.size(), fd);
    auto memory = os::SharedMemory::attach(os::adopt_fd(fd));
    if (!memory || !channel::Link::is_link(memory->data(), memory->size())) refuse(function, kOtherVersion);
    const auto port =
        std::find_if(ports().begin(), ports().end(), [name](const PortBase* p) { return p->name() == name; });
    if (port == ports().end()) {
      refuse(function, "a connection names port '" + std::string{name} +
                           "', but the program has not constructed that port; construct it before this call");
    }
    const channel::Link link{memory->data()};
    if (link.stride() < (*port)->type().max_size)
      refuse(function, "the type of port '" + std::string{name} +
                           "' has changed since the deployment; deploy the cell again");
    (*port)->connect(link, nullptr);
    link_memories_.push_back(std::move(*memory));
  }
}

// The time from which the first unread event is valid, in ns of the monotonic clock; kNever if there is no
// event.
std::int64_t Guest::event_at() {
  std::int64_t first = channel::kNever;
  for (const PortBase* port : ports()) {
    if (port->direction() == PortDirection::event) first = std::min(first, port->news_at());
  }
  return first;
}

void Guest::attach(channel::ReleaseSlotKind kind, const char* function) {
  // Buffers the output by line, so that a line appears as soon as it is written, even through a pipe.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (slot_ != nullptr) refuse(function, "called twice; call it once, before the first wait");
  check_ports(function);
  find_saved(function);
  describe(kind);
  check_properties(function);
  os::Fd slot = os::take_fd_from_environment("TAKT_SLOT_FD");
  os::Fd wake_word = os::take_fd_from_environment("TAKT_WAKE_WORD_FD");
  if (!slot || !wake_word)
    refuse(function,
           "takt-node did not start this program; add the program to the descriptor of a cell, and run the "
           "cell");
  auto slot_memory = os::SharedMemory::attach(std::move(slot));
  auto wake_memory = os::SharedMemory::attach(std::move(wake_word));
  if (!slot_memory || !wake_memory) refuse(function, "the memory shared with takt-node cannot be mapped");
  slot_memory_ = std::move(*slot_memory);
  wake_word_memory_ = std::move(*wake_memory);
  slot_ = reinterpret_cast<channel::ReleaseSlot*>(slot_memory_.data());
  wake_word_ = reinterpret_cast<channel::WakeWord*>(wake_word_memory_.data());
  if (slot_memory_.size() < sizeof(channel::ReleaseSlot) || slot_->magic != channel::ReleaseSlot::kMagic) {
    refuse(function, kOtherVersion);
  }
  if (slot_->kind != kind) {
    refuse(function,
           slot_->kind == channel::ReleaseSlotKind::periodic
               ? "the descriptor declares the module periodic; use initPeriodExe() and waitPeriod()"
           : slot_->kind == channel::ReleaseSlotKind::sporadic
               ? "the descriptor declares the module sporadic; use initSporadicExe() and waitSporadic()"
               : "the descriptor declares the module non-real, so it has no releases; remove this call");
  }
  context_ = {.start_ns = to_ns(os::now()), .wake_word = wake_word_};
  for (PortBase* port : ports()) port->serve(context_);
  connect_ports(function);
  restore();
  margin_ = os::WakeMargin{Nanoseconds{slot_->margin_cap_ns}};
  if (slot_->lock_memory != 0) static_cast<void>(os::lock_memory());
  const std::string index = os::take_from_environment(channel::kCheckModule);
  const auto watch = channel::ModuleWatch::find();
  if (!watch) refuse(function, in_words(watch.problems()));
  watch_ = *watch;
  if (watch_) watched_as_ = static_cast<std::uint32_t>(std::strtoul(index.c_str(), nullptr, 10));
  slot_->thread.store(os::thread_id(), std::memory_order_relaxed);
  slot_->phase.store(channel::ReleaseSlotPhase::attached, std::memory_order_release);
}

void Guest::end_if_requested() const {
  if (slot_->end.load(std::memory_order_acquire) != 0) std::exit(0);
}

// The next release is expected one period after the last one. It arrives a little later than this, because
// other modules of the row are released or run first. So the program spins until margin_cap_ns after the
// expected instant.
void Guest::spin_until_release() {
  const Instant expected = from_ns(taken_.release_ns + slot_->period_ns);
  const Instant wake = expected - margin_.value();
  const Instant patience = expected + Nanoseconds{slot_->margin_cap_ns};
  Instant now = os::now();
  if (now < wake) {
    os::sleep_until(wake);
    now = os::now();
    margin_.observe(now - wake);
    slot_->margin_ns.store(margin_.value().count(), std::memory_order_relaxed);
  }
  while (!released() && now < patience) {
    os::cpu_relax();
    now = os::now();
  }
}

// A program with immediate dispatch releases itself when an event is due; the scheduler never releases it.
bool Guest::release_by_event() {
  const Instant now = os::now();
  if (to_ns(now) < std::max(event_at(), channel::not_before_ns(*slot_))) return false;
  if (channel::begin(*slot_, to_ns(now))) return true;
  // The node has just taken the module out of the tables, so there is no release to serve.
  taken_.count = slot_->released.load(std::memory_order_relaxed);
  return false;
}

void Guest::sleep_on_wake_word() {
  const std::uint32_t rings = wake_word_->rings.load(std::memory_order_seq_cst);
  slot_->sleeping.store(1, std::memory_order_seq_cst);  // SYNC: sleeping
  bool due = slot_->released.load(std::memory_order_seq_cst) != taken_.count ||
             slot_->end.load(std::memory_order_seq_cst) != 0;
  std::optional<Instant> until;
  // A writer wakes this program after it writes an event, and the node after it opens the slot. So a change
  // that comes too late for this check ends the sleep.
  const std::int64_t event = slot_->immediate != 0 ? event_at() : channel::kNever;
  if (event != channel::kNever && slot_->open.load(std::memory_order_seq_cst) != 0) {
    until = from_ns(std::max(event, channel::not_before_ns(*slot_)));
    due |= *until <= os::now();
  }
  if (!due) os::futex_wait(wake_word_->rings, rings, slot_->wake_bit, until);
  slot_->sleeping.store(0, std::memory_order_seq_cst);
}

void Guest::body_done() {
  const Instant now = os::now();
  slot_->run.record((now - started_).count());
  slot_->body_began_ns.store(to_ns(started_), std::memory_order_relaxed);
  slot_->body_ended_ns.store(to_ns(now), std::memory_order_relaxed);
  if (saved_.data != nullptr) slot_->saved.save(saved_.data, saved_.size, saved_.version, to_ns(started_));
  if (slot_->deadline_ns == 0) return;
  const std::int64_t late = to_ns(now) - taken_.release_ns - slot_->deadline_ns;
  if (late <= 0) return;
  slot_->late_by_ns.store(late, std::memory_order_relaxed);
  slot_->late.fetch_add(1, std::memory_order_release);  // SYNC: late
}

void Guest::wait(const char* function) {
  if (slot_ == nullptr) refuse(function, "call initPeriodExe() or initSporadicExe() first");
  const bool first = taken_.count == 0;
  if (watch_ && !first) watch_.leave(0);
  if (!first) body_done();
  // Wakes the readers of all samples that the body wrote.
  if (const std::uint32_t bits = wake_word_->take_pending(); bits != 0) {
    wake_word_->rings.fetch_add(1, std::memory_order_seq_cst);
    os::futex_wake(wake_word_->rings, bits);
  }
  slot_->done.store(taken_.count, std::memory_order_release);  // SYNC: done
  if (first) slot_->phase.store(channel::ReleaseSlotPhase::ready, std::memory_order_release);

  end_if_requested();
  const bool immediate = slot_->immediate != 0;
  if (!immediate && !first && !released()) spin_until_release();
  while (!released()) {
    end_if_requested();
    if (!immediate || !release_by_event()) sleep_on_wake_word();
  }
  taken_ = channel::take(*slot_, taken_.count);
  started_ = os::now();
  const bool logical = slot_->logical != 0;
  context_.start_ns = logical ? taken_.release_ns : to_ns(started_);
  context_.valid_ns = logical ? taken_.release_ns + slot_->period_ns : 0;
  slot_->jitter.record(taken_.release_ns - to_ns(started_));
  if (watch_) watch_.enter(watched_as_, channel::Doing::run);
}

Guest guest;

}  // namespace

namespace takt {

std::vector<PortBase*> take_loose_ports() { return ports(); }
std::vector<SavedBase*> take_loose_saved() { return saved(); }

namespace detail {
const char* take_reported_failure() noexcept { return nullptr; }
void add_loose_port(PortBase& port) { ports().push_back(&port); }
void remove_loose_port(PortBase& port) noexcept { std::erase(ports(), &port); }
void add_loose_saved(SavedBase& one) { saved().push_back(&one); }
void remove_loose_saved(SavedBase& one) noexcept { std::erase(saved(), &one); }
}  // namespace detail

}  // namespace takt

extern "C" {

void initPeriodExe(void) { guest.attach(channel::ReleaseSlotKind::periodic, "initPeriodExe"); }
void initSporadicExe(void) { guest.attach(channel::ReleaseSlotKind::sporadic, "initSporadicExe"); }
void waitPeriod(void) { guest.wait("waitPeriod"); }
void waitSporadic(void) { guest.wait("waitSporadic"); }

uint64_t takt_cycle(void) { return guest.taken().cycle; }
int64_t takt_release_ns(void) { return guest.taken().release_ns; }
int64_t takt_period_ns(void) { return guest.slot() == nullptr ? 0 : guest.slot()->period_ns; }
}
