// libtakt_process, with which authors link the programs of process modules. The library takes the releases
// from the module's release slot (channel/release_slot.hpp) and connects the ports.
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
#include <takt/channel/check_reporter.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/violations.hpp>
#include <takt/component/log.hpp>
#include <takt/component/port.hpp>
#include <takt/component/saved.hpp>
#include <takt/component/service.hpp>
#include <takt/core/hex.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/fork_guard.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/shared_memory.hpp>
#include <takt/os/waker.hpp>
#include "program_properties.hpp"

/// Defined by TAKT_SAVED in a process module in C; otherwise its address is null.
extern "C" __attribute__((weak)) const takt_saved_state takt_saved;

namespace {

using namespace takt;

constexpr const char* kOtherVersion =
    "takt-node and libtakt_process have different versions; install the same version of both";

/// Returns the ports of the program, in the order of construction.
std::vector<PortBase*>& ports() {
  static std::vector<PortBase*> all;
  return all;
}
/// Returns the Saved variables of the program, in the order of construction.
std::vector<SavedBase*>& saved() {
  static std::vector<SavedBase*> all;
  return all;
}

thread_local bool attached_here =
    false;  // true in the thread that called initPeriodExe() or initSporadicExe()

/// Connects this program to the memory that it shares with the node, and waits for releases. The program has
/// one Guest.
class Guest {
 public:
  Guest() { static_cast<void>(os::guard_against_forks()); }

  void attach(channel::ReleaseSlotKind kind, const char* function);
  void wait(channel::ReleaseSlotKind kind, const char* function);
  /// Ends the program if it is already attached, because Takt would then ignore the port or the saved
  /// variable that it constructs.
  void refuse_late(const std::string& what) const;

  [[nodiscard]] const channel::ReleaseSlot* slot() const { return slot_; }
  [[nodiscard]] const channel::Taken& taken() const { return taken_; }
  [[nodiscard]] detail::LogTarget log_target() const noexcept {
    return {slot_ == nullptr ? nullptr : &slot_->log, taken_.cycle, context_.start_ns};
  }

 private:
  [[noreturn]] static void refuse(const char* function, const std::string& what);
  static void refuse_forked_copy(const char* function);
  static void check_ports(const char* function);
  void find_saved(const char* function);
  void restore() const;
  void describe(channel::ReleaseSlotKind kind) const;
  static void check_properties(const char* function);
  void connect_ports(const char* function);
  [[nodiscard]] static std::int64_t event_at();
  bool released() const { return slot_->released.load(std::memory_order_acquire) != taken_.count; }
  void body_done();
  void await_turn();
  void spin_until_release();
  bool release_by_event();
  void sleep_on_wake_word();
  void end_if_requested() const;

  os::SharedMemory slot_memory_;
  os::SharedMemory wake_word_memory_;
  os::SharedMemory turn_memory_;
  channel::ReleaseSlot* slot_ = nullptr;
  channel::WakeWord* wake_word_ = nullptr;
  std::uint32_t wake_bit_ = 0;
  channel::WakeBits noted_{};      // wake bits of the readers of the samples that the body wrote
  channel::Turn* turn_ = nullptr;  // null: this program does not wait for its turn
  os::WakeMargin margin_{Nanoseconds{0}};
  std::vector<os::SharedMemory> link_memories_;
  PortContext context_;
  takt_saved_state saved_{};  // the saved variable; data is null if there is none
  channel::Taken taken_;      // the release whose body runs, or ran last
  Instant started_{};
  channel::CheckReporter reporter_;
  std::uint32_t reported_as_ = 0;
};

void Guest::refuse(const char* function, const std::string& what) {
  std::fprintf(stderr, "takt: %s(): %s\n", function, what.c_str());
  std::exit(1);
}

// Takt watches only the process that it started, so it would never end a copy of that process. A daemon has
// no standard error, so its message reaches the author only if Takt has asked for the description of the
// program.
void Guest::refuse_forked_copy(const char* function) {
  if (!os::is_forked_copy()) return;
  const std::string what =
      std::string{"the program calls "} + function +
      "() in a copy of its process, which daemon() or fork() made; Takt starts and ends only "
      "the process itself";
  const std::string fix =
      "remove daemon(), and call " + std::string{function} + "() in the process that Takt started";
  if (os::MessageSocket asker{os::take_fd_from_environment("TAKT_DESCRIBE_FD")}; asker.fd())
    asker.send_wait(R"({"operation":"","ports":[],"problems":[{"what":)" + in_json(what) + R"(,"fix":)" +
                    in_json(fix) + "}]}");
  std::fprintf(stderr, "takt: %s; %s\n", what.c_str(), fix.c_str());
  std::_Exit(1);
}

void Guest::refuse_late(const std::string& what) const {
  if (slot_ == nullptr) return;
  const bool periodic = slot_->kind == channel::ReleaseSlotKind::periodic;
  refuse(
      periodic ? "initPeriodExe" : "initSporadicExe",
      what +
          " was created after this call, so it would have no effect; make it a global variable, or create it "
          "before this call");
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

// Restores the saved variable. A value that was saved with another version or size is not restored.
void Guest::restore() const {
  const channel::SavedState::Copy* before = saved_.data == nullptr ? nullptr : slot_->saved.saved();
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

// If Takt started the program only to get its description, sends the description and ends the program.
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

// Connects the ports to the links in TAKT_LINKS, "PORT=FD,PORT=FD,...". A port with several links occurs
// several times.
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

// Returns the time from which the first unread event is valid, in ns of the monotonic clock; kNever if there
// is no event.
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
  refuse_forked_copy(function);
  if (slot_ != nullptr) refuse(function, "called twice; call it once, before the first wait");
  check_ports(function);
  find_saved(function);
  describe(kind);
  check_properties(function);
  os::Fd slot = os::take_fd_from_environment("TAKT_SLOT_FD");
  os::Fd wake_word = os::take_fd_from_environment("TAKT_WAKE_WORD_FD");
  if (!slot || !wake_word)
    refuse(function,
           "takt-node did not start this program, or its descriptor says non-real; add the program to the "
           "descriptor of a cell as periodic or sporadic, and run the cell");
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
  // From now on, the program's own code can damage only what the program must write.
  if (!slot_memory_.make_read_only(slot_->read_only_size()) ||
      !wake_word_memory_.make_read_only(channel::WakeWord::kReadOnly))
    refuse(function, "the memory shared with takt-node cannot be protected");
  wake_bit_ = slot_->wake_bit;
  // In noted_, all gateways count as sleeping, so that noted_ collects their wake bits. wait() then checks in
  // the wake word whether a gateway really sleeps.
  noted_.gateway_sleeps.store(1, std::memory_order_relaxed);
  if (os::Fd turn = os::take_fd_from_environment("TAKT_TURN_FD")) {
    auto turn_memory = os::SharedMemory::attach(std::move(turn));
    if (!turn_memory || turn_memory->size() < sizeof(channel::Turn)) refuse(function, kOtherVersion);
    turn_memory_ = std::move(*turn_memory);
    turn_ = reinterpret_cast<channel::Turn*>(turn_memory_.data());
  }
  if (slot_->kind != kind) {
    refuse(function,
           slot_->kind == channel::ReleaseSlotKind::periodic
               ? "the descriptor declares the module periodic; use initPeriodExe() and waitPeriod()"
           : slot_->kind == channel::ReleaseSlotKind::sporadic
               ? "the descriptor declares the module sporadic; use initSporadicExe() and waitSporadic()"
               : "the descriptor declares the module non-real, so it has no releases; remove this call");
  }
  context_ = {.start_ns = to_ns(os::now()), .wake_word = &noted_};
  for (PortBase* port : ports()) port->serve(context_);
  connect_ports(function);
  restore();
  margin_ = os::WakeMargin{Nanoseconds{slot_->margin_cap_ns}};
  if (slot_->lock_memory != 0) static_cast<void>(os::lock_memory());
  const std::string index = os::take_from_environment(channel::kCheckModule);
  const auto reporter = channel::CheckReporter::find();
  if (!reporter) refuse(function, in_words(reporter.problems()));
  reporter_ = *reporter;
  if (reporter_) reported_as_ = static_cast<std::uint32_t>(std::strtoul(index.c_str(), nullptr, 10));
  if (const auto served = serve_program_properties(*slot_); !served)
    refuse(function, in_words(served.problems()));
  attached_here = true;
  slot_->thread.store(os::thread_id(), std::memory_order_relaxed);
  slot_->phase.store(channel::ReleaseSlotPhase::attached, std::memory_order_release);
}

void Guest::end_if_requested() const {
  if (slot_->end.load(std::memory_order_acquire) != 0) std::exit(0);
}

// Sleeps until shortly before the next release, and then spins until the release arrives. The release is
// expected one period after the last one. It arrives a little later, because the scheduler first releases or
// runs other modules of the row. So the function spins until margin_cap_ns after the expected instant.
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

// Releases this program, which has immediate dispatch, if an event is due. Returns true if the program was
// released. The scheduler never releases such a program.
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
  slot_->sleeping.store(1, std::memory_order_seq_cst);  // before the load of `released`; see release()
  bool due = slot_->released.load(std::memory_order_seq_cst) != taken_.count ||
             slot_->end.load(std::memory_order_seq_cst) != 0;
  std::optional<Instant> until;
  // After this check, a writer may write an event, or the node may open the slot. The writer or the node then
  // wakes this program, so the sleep ends at once.
  const std::int64_t event = slot_->immediate != 0 ? event_at() : channel::kNever;
  if (event != channel::kNever && slot_->open.load(std::memory_order_seq_cst) != 0) {
    until = from_ns(std::max(event, channel::not_before_ns(*slot_)));
    due |= *until <= os::now();
  }
  if (!due) os::futex_wait(wake_word_->rings, rings, wake_bit_, until);
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
  slot_->late.fetch_add(1, std::memory_order_release);  // after late_by_ns
}

// Waits until the previous program in the row has begun its body, but only half a period for a program that
// was killed or stopped. So such a program delays this program only once, and by less than a period.
void Guest::await_turn() {
  const channel::Ticket ticket = channel::ticket_of(*slot_, taken_);
  turn_->await(ticket, Nanoseconds{slot_->period_ns / 2}, *wake_word_, wake_bit_, slot_->end);
  end_if_requested();
  turn_->begin(ticket);
}

void Guest::wait(channel::ReleaseSlotKind kind, const char* function) {
  if (slot_ == nullptr) refuse(function, "call initPeriodExe() or initSporadicExe() first");
  refuse_forked_copy(function);
  if (slot_->kind != kind)
    refuse(function, kind == channel::ReleaseSlotKind::periodic
                         ? "the module is sporadic; call waitSporadic()"
                         : "the module is periodic; call waitPeriod()");
  if (!attached_here)
    refuse(function, "call it from the thread that called initPeriodExe() or initSporadicExe()");
  const bool first = taken_.count == 0;
  if (reporter_ && !first) reporter_.leave(0);
  if (!first) body_done();
  // Wakes the readers of all samples that the body wrote, and the programs on this CPU that wait for their
  // turn.
  const std::uint32_t next = turn_ == nullptr ? 0 : turn_->take_waiting();
  if (const std::uint32_t bits = wake_word_->without_awake_gateways(noted_.take_pending()) | next;
      bits != 0) {
    wake_word_->rings.fetch_add(1, std::memory_order_seq_cst);
    os::futex_wake(wake_word_->rings, bits);
  }
  slot_->done.store(taken_.count, std::memory_order_release);  // after the results of the body
  if (first) slot_->phase.store(channel::ReleaseSlotPhase::ready, std::memory_order_release);

  end_if_requested();
  const bool immediate = slot_->immediate != 0;
  if (!immediate && !first && !released()) spin_until_release();
  while (!released()) {
    end_if_requested();
    if (!immediate || !release_by_event()) sleep_on_wake_word();
  }
  taken_ = channel::take(*slot_, taken_.count);
  if (turn_ != nullptr) await_turn();
  take_over_program_properties();
  started_ = os::now();
  const bool logical = slot_->logical != 0;
  context_.start_ns = logical ? taken_.release_ns : to_ns(started_);
  context_.valid_ns = logical ? taken_.release_ns + slot_->period_ns : 0;
  slot_->jitter.record(taken_.release_ns - to_ns(started_));
  if (reporter_) reporter_.enter(reported_as_, channel::Doing::run);
}

Guest guest;

}  // namespace

namespace takt {

std::vector<PortBase*> take_loose_ports() { return ports(); }
std::vector<SavedBase*> take_loose_saved() { return saved(); }

namespace detail {
LogTarget log_target() noexcept { return guest.log_target(); }
const char* take_reported_failure() noexcept { return nullptr; }
bool report_late(const std::string&) { return false; }
void add_loose_port(PortBase& port) {
  guest.refuse_late("port '" + port.name() + "'");
  ports().push_back(&port);
}
void remove_loose_port(PortBase& port) noexcept { std::erase(ports(), &port); }
void add_loose_saved(SavedBase& one) {
  guest.refuse_late("a Saved variable");
  saved().push_back(&one);
}
void remove_loose_saved(SavedBase& one) noexcept { std::erase(saved(), &one); }
}  // namespace detail

}  // namespace takt

extern "C" {

void initPeriodExe(void) { guest.attach(channel::ReleaseSlotKind::periodic, "initPeriodExe"); }
void initSporadicExe(void) { guest.attach(channel::ReleaseSlotKind::sporadic, "initSporadicExe"); }
void waitPeriod(void) { guest.wait(channel::ReleaseSlotKind::periodic, "waitPeriod"); }
void waitSporadic(void) { guest.wait(channel::ReleaseSlotKind::sporadic, "waitSporadic"); }

uint64_t takt_cycle(void) { return guest.taken().cycle; }
int64_t takt_release_ns(void) { return guest.taken().release_ns; }
int64_t takt_period_ns(void) { return guest.slot() == nullptr ? 0 : guest.slot()->period_ns; }
}
