// The promise of real-time code, held to on the thread that runs it: no lock, no allocation, and no system
// call but its sleep and one ring of the bell a cycle. The product knows nothing of the traps; a module's
// run() sets them.
#include <gtest/gtest.h>

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <takt/channel/flight_record.hpp>
#include <takt/channel/layout.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/channel/seat.hpp>
#include <takt/component/component.hpp>
#include <takt/component/in_port.hpp>
#include <takt/component/out_port.hpp>
#include <takt/host/executor_threads.hpp>
#include <takt/host/live_properties.hpp>
#include <takt/host/swap.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/schedule/plan.hpp>

#include "../../system/components/sample.hpp"
#include "connected_service.hpp"
#include "system_call_trap.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TAKT_SANITIZED 1
#else
#define TAKT_SANITIZED 0
#endif

namespace {
/// Of the threads that are watched.
std::atomic<std::uint64_t> allocations{0};
std::atomic<std::uint64_t> frees{0};
std::atomic<std::uint64_t> locks{0};
std::atomic<std::uint64_t> waits{0};
thread_local bool watched [[gnu::tls_model("initial-exec")]] = false;

[[maybe_unused]] void count(std::atomic<std::uint64_t>& counter) noexcept {
  if (watched) counter.fetch_add(1, std::memory_order_relaxed);
}
}  // namespace

#if !TAKT_SANITIZED
#include <dlfcn.h>
#include <pthread.h>

// In front of the C library's. operator new and delete come here too.
extern "C" {
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t n, std::size_t size) noexcept;
void* __libc_realloc(void* block, std::size_t size) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;
void __libc_free(void* block) noexcept;

void* malloc(std::size_t size) noexcept {
  count(allocations);
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  count(allocations);
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) noexcept {
  count(allocations);
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  count(allocations);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count(allocations);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  count(allocations);
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}
void free(void* block) noexcept {
  count(frees);
  __libc_free(block);
}

#define TAKT_FORWARD(counter, version, name, parameters, ...)                                             \
  int name parameters noexcept(noexcept(::name(__VA_ARGS__))) {                                           \
    static std::atomic<int(*) parameters> real{nullptr};                                                  \
    auto* function = real.load(std::memory_order_relaxed);                                                \
    if (function == nullptr) {                                                                            \
      function = reinterpret_cast<int(*) parameters>(::dlvsym(RTLD_NEXT, #name, version));                \
      if (function == nullptr) function = reinterpret_cast<int(*) parameters>(::dlsym(RTLD_NEXT, #name)); \
      real.store(function, std::memory_order_relaxed);                                                    \
    }                                                                                                     \
    count(counter);                                                                                       \
    return function(__VA_ARGS__);                                                                         \
  }
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_mutex_lock, (pthread_mutex_t * mutex), mutex)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_mutex_trylock, (pthread_mutex_t * mutex), mutex)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_mutex_unlock, (pthread_mutex_t * mutex), mutex)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_rwlock_rdlock, (pthread_rwlock_t * lock), lock)
TAKT_FORWARD(locks, "GLIBC_2.2.5", pthread_rwlock_wrlock, (pthread_rwlock_t * lock), lock)
TAKT_FORWARD(waits, "GLIBC_2.3.2", pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t* mutex),
             condition, mutex)
TAKT_FORWARD(waits, "GLIBC_2.3.2", pthread_cond_timedwait,
             (pthread_cond_t * condition, pthread_mutex_t* mutex, const timespec* until), condition, mutex,
             until)
TAKT_FORWARD(waits, "GLIBC_2.30", pthread_cond_clockwait,
             (pthread_cond_t * condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* until),
             condition, mutex, clock, until)
#undef TAKT_FORWARD
}
#endif

namespace takt::host {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

class Script final : public executor::Body {
 public:
  executor::Outcome run(const Cycle& cycle) noexcept override {
    if (on_run) on_run(cycle);
    return {};
  }
  executor::Outcome condition(const Cycle&, bool* ready) noexcept override {
    *ready = ++asked % 3 == 0;
    return {};
  }
  std::function<void(const Cycle&)> on_run;
  std::uint64_t asked = 0;
};

/// A device that runs for real and records it: three thread modules, a sporadic one, and a program that
/// sleeps on the bell after each body.
class RealTimePath : public testing::Test {
 protected:
  static constexpr auto kPeriod = microseconds{500};
  static constexpr std::size_t kSporadic = 3;
  static constexpr std::size_t kProgram = 4;
  static constexpr std::uint64_t kRecorded = 256;  // fewer than are made, so that entries are overwritten

  void SetUp() override {
    if (TAKT_SANITIZED != 0)
      GTEST_SKIP() << "the sanitizer's own allocator, locks and system calls would be counted";
    for (auto* counter : {&allocations, &frees, &locks, &waits}) counter->store(0);
    model::Device device;
    device.executors.emplace_back();
    for (std::size_t i = 0; i < 5; ++i) {
      model::Module module;
      module.name = "m" + std::to_string(i);
      module.executor = "main";
      module.type = i == kProgram ? model::ModuleType::process : model::ModuleType::thread;
      module.operation = i == kSporadic ? model::Operation::sporadic : model::Operation::periodic;
      if (i == kSporadic) {
        module.deadline = milliseconds{10};
      } else {
        module.period = i == 2 ? kPeriod * 3 : kPeriod;
      }
      device.modules.push_back(module);
      blocks[i].in_tables.store(1);
    }
    const auto plan = *schedule::plan(model::Cell{}, device);
    record = std::move(*channel::FlightRecord::create({kRecorded, kRecorded}));
    for (std::size_t ring = 0; ring < flight.size(); ++ring) flight[ring] = record.writer(ring);
    seat.bell_bit = channel::bell_bit(0);
    seat.phase.store(channel::SeatPhase::ready);
    std::vector<executor::Unit> periodic;
    for (const std::uint32_t i : plan.executors[0].periodic) {
      periodic.push_back({.index = i,
                          .body = i == kProgram                   ? nullptr
                                  : replaced == nullptr || i != 1 ? &bodies[i]
                                                                  : replaced,
                          .seat = i == kProgram ? &seat : nullptr,
                          .block = &blocks[i],
                          .period = *device.modules[i].period});
    }
    std::vector<executor::Unit> sporadic{{.index = kSporadic,
                                          .body = &bodies[kSporadic],
                                          .block = &blocks[kSporadic],
                                          .deadline = milliseconds{10}}};
    threads = std::make_unique<ExecutorThreads>(device.executors[0], plan.executors[0], periodic, sporadic,
                                                *block, bell, executor::Flight{&flight[0], &flight[1]});
    row_trap = std::make_unique<SystemCallTrap>([this] { return block->cycles.load(); });
    sporadic_trap = std::make_unique<SystemCallTrap>([this] { return blocks[kSporadic].cycles.load(); });
    set_at_first_run(0, *row_trap);
    set_at_first_run(kSporadic, *sporadic_trap);
  }

  /// From the module's first run() on, its thread is watched.
  void set_at_first_run(std::size_t module, SystemCallTrap& trap) {
    bodies[module].on_run = [this, &trap](const Cycle&) {
      if (watched) return;
      if (const int error = trap.arm(); error != 0) refused = error;
      watched = true;
    };
  }

  /// Runs the device until it has made this many cycles, and takes away what was seen until then.
  void run(std::uint64_t cycles) {
    std::thread program{[this] { serve(); }};
    Problems problems;
    const auto begun = threads->begin(os::now() + milliseconds{20}, {os::allowed_cpus().back()}, &problems);
    EXPECT_TRUE(begun.ok());
    for (const Problem& problem : problems) GTEST_LOG_(WARNING) << to_text(problem);
    const Instant limit = os::now() + std::chrono::seconds{60};
    while (block->cycles.load() < cycles && refused == 0 && os::now() < limit) {
      std::this_thread::sleep_for(milliseconds{10});
    }
    row_calls = row_trap->calls();
    sporadic_calls = sporadic_trap->calls();
    seen = {{"allocations", allocations}, {"frees", frees}, {"locks", locks}, {"waits", waits}};
    threads->ask_to_halt();
    threads->join();
    seat.end.store(1);
    bell.rings.fetch_add(1);
    os::futex_wake(bell.rings, ~0U);
    program.join();
    ASSERT_EQ(refused, 0)
        << "seccomp user notification is refused here (" << std::strerror(refused)
        << "), so nothing is proved; allow seccomp(SECCOMP_SET_MODE_FILTER) with a listener";
    ASSERT_GE(block->cycles.load(), cycles);
  }

  void serve() {
    std::uint32_t taken = 0;
    while (seat.end.load() == 0) {
      seat.done.store(taken);
      const std::uint32_t rings = bell.rings.load();
      seat.sleeping.store(1);
      if (seat.released.load() == taken && seat.end.load() == 0)
        os::futex_wait(bell.rings, rings, seat.bell_bit);
      seat.sleeping.store(0);
      taken = seat.released.load();
    }
  }

  static bool is_futex(const SystemCall& call, int operation, const void* from, std::size_t size) {
    const auto first = reinterpret_cast<std::uintptr_t>(from);
    return call.number == SYS_futex && (static_cast<int>(call.arguments[1]) & FUTEX_CMD_MASK) == operation &&
           call.arguments[0] >= first && call.arguments[0] < first + size;
  }

  std::array<Script, 5> bodies;
  executor::Body* replaced = nullptr;  // in place of bodies[1]
  std::array<channel::ModuleBlock, 5> blocks{};
  std::unique_ptr<channel::ExecutorBlock> block = std::make_unique<channel::ExecutorBlock>();
  channel::Seat seat{};
  channel::Bell bell{};
  channel::FlightRecord record;
  std::array<channel::FlightWriter, 2> flight;
  std::unique_ptr<SystemCallTrap> row_trap;
  std::unique_ptr<SystemCallTrap> sporadic_trap;
  std::unique_ptr<ExecutorThreads> threads;  // ends before the traps of its threads do
  std::atomic<int> refused{0};
  std::vector<SystemCall> row_calls;
  std::vector<SystemCall> sporadic_calls;
  std::map<std::string, std::uint64_t> seen;
};

TEST_F(RealTimePath, MakesNoSystemCallButItsSleepAndOneRingACycle) {
  run(4000);
  ASSERT_FALSE(row_calls.empty());
  std::map<std::uint64_t, int> sleeps;  // by cycle
  std::map<std::uint64_t, int> rings;
  for (const SystemCall& call : row_calls) {
    if (is_futex(call, FUTEX_WAIT_BITSET, threads.get(), sizeof *threads)) {
      ++sleeps[call.stamp];
    } else if (is_futex(call, FUTEX_WAKE_BITSET, &bell, sizeof bell)) {
      ++rings[call.stamp];
    } else {
      ADD_FAILURE() << "system call " << call.number << " in cycle " << call.stamp;
    }
  }
  for (const auto& [cycle, n] : sleeps) EXPECT_EQ(n, 1) << "sleeps before cycle " << cycle;
  for (const auto& [cycle, n] : rings) EXPECT_EQ(n, 1) << "rings after cycle " << cycle;
  EXPECT_GT(rings.size(), 1000U) << "the program was to sleep";

  ASSERT_FALSE(sporadic_calls.empty());
  for (const SystemCall& call : sporadic_calls) {
    EXPECT_TRUE(is_futex(call, FUTEX_WAIT_BITSET, &bell, sizeof bell)) << "system call " << call.number;
    EXPECT_EQ(call.arguments[5], channel::kSporadicBit);
  }
  EXPECT_GT(blocks[kSporadic].cycles.load(), 500U);
  EXPECT_GT(blocks[kProgram].cycles.load(), 1000U);
  EXPECT_GT(record.copy(0).written, 3 * 4000U) << "each row, and each run of it";
  EXPECT_GT(record.copy(1).written, 500U);
  RecordProperty("row_calls", static_cast<int>(row_calls.size()));
}

TEST_F(RealTimePath, AllocatesAndLocksNothing) {
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  EXPECT_GT(blocks[kSporadic].cycles.load(), 200U);
}

// Texts of all lengths, so that the old one is to be freed and the new one has memory of its own.
TEST_F(RealTimePath, TakesOverPropertiesThatAreSetWhileItRuns) {
  struct Named : Component {
    Property<std::string> label{*this, "label", "none"};
    Property<double> gain{*this, "gain", 0.0};
    void run(const Cycle&) noexcept override {}
  } component;
  LiveProperties live;
  live.serve(component.properties(), "Named");
  std::atomic<std::uint64_t> changes{0};
  double last = 0;
  bodies[1].on_run = [&](const Cycle&) {
    live.take_over();
    if (component.gain == last) return;
    last = component.gain;
    if (component.label.value().size() == static_cast<std::size_t>(last) % 100) ++changes;
  };
  std::atomic<bool> end{false};
  std::thread setter{[&] {
    for (int n = 1; !end; ++n) {
      const std::string label(static_cast<std::size_t>(n % 100), 'x');
      EXPECT_TRUE(live.set({{"gain", std::to_string(n)}, {"label", label}}).ok());
      std::this_thread::sleep_for(microseconds{300});
    }
  }};
  run(2000);
  end = true;
  setter.join();
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex);
  EXPECT_GT(changes.load(), 500U);
}

/// Two ports and the link between them.
struct Connected {
  Connected(bool as_objects, std::uint32_t wake_bits, bool has_safe_value = false) {
    const std::uint32_t most = PortType<samples::Count>::info.max_size;
    const channel::Link::Options options{.depth = 4,
                                         .payload = as_objects ? 0 : most,
                                         .is_queue = true,
                                         .wake_bits = wake_bits,
                                         .safe = has_safe_value ? most : 0};
    memory.resize(channel::Link::layout(options).size() / sizeof(Line));
    auto* start = reinterpret_cast<std::byte*>(memory.data());
    channel::Link::format(start, options);
    link = channel::Link{start};
    if (has_safe_value) {
      samples::Count count;
      fill(count, kSafe);
      std::vector<std::byte> bytes(most);
      bytes.resize(PortType<samples::Count>::encode(count, bytes.data(), most));
      link.give_safe(bytes);
    }
    void* values = as_objects ? out.make_values(link.buffers()) : nullptr;
    out.connect(link, values);
    in.connect(link, values);
  }
  struct alignas(64) Line {
    std::array<std::byte, 64> bytes;
  };
  static constexpr std::uint64_t kSafe = 1'000'000'000;
  std::vector<Line> memory;
  channel::Link link;
  OutPort<samples::Count> out{"out"};
  InPort<samples::Count> in{"in"};
};

TEST_F(RealTimePath, PortsAllocateAndLockNothingAndRingOnceACycle) {
  Connected objects{true, 0};
  Connected bytes{false, channel::kSporadicBit};
  PortContext context{.start_ns = 1, .bell = &bell, .flight = flight.data(), .module = 1};
  for (Connected* each : {&objects, &bytes}) {
    each->out.serve(context);
    each->in.serve(context);
  }
  samples::Count count;
  count.few().reserve(4);
  std::uint64_t wrong = 0;
  std::uint64_t read = 0;
  bodies[1].on_run = [&](const Cycle& cycle) {
    for (int i = 0; i < 3; ++i) {
      fill(count, cycle.number + 1);
      objects.out.write(count);
      bytes.out.write(count);
    }
  };
  bodies[2].on_run = [&](const Cycle&) {
    for (Connected* each : {&objects, &bytes}) {
      while (each->in.read()) {
        ++read;
        if (!is_whole(each->in.value())) ++wrong;
      }
    }
  };
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(read, 2000U);
  std::map<std::uint64_t, int> rings;
  for (const SystemCall& call : row_calls) {
    EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
    if (is_futex(call, FUTEX_WAKE_BITSET, &bell, sizeof bell)) ++rings[call.stamp];
  }
  for (const auto& [cycle, n] : rings) EXPECT_EQ(n, 1) << "rings after cycle " << cycle;
}

// A node withholds the samples and trusts them again while they come.
TEST_F(RealTimePath, SafeValuesAllocateAndLockNothing) {
  Connected objects{true, 0, true};
  Connected bytes{false, 0, true};
  PortContext context{.start_ns = 1, .bell = &bell, .flight = flight.data(), .module = 1};
  for (Connected* each : {&objects, &bytes}) {
    each->out.serve(context);
    each->in.serve(context);
  }
  samples::Count count;
  count.few().reserve(4);
  std::uint64_t wrong = 0;
  std::uint64_t read = 0;
  std::uint64_t safe = 0;
  bodies[1].on_run = [&](const Cycle& cycle) {
    fill(count, cycle.number + 1);
    objects.out.write(count);
    bytes.out.write(count);
  };
  bodies[2].on_run = [&](const Cycle&) {
    for (Connected* each : {&objects, &bytes}) {
      while (each->in.read()) {
        ++(each->in.is_safe() ? safe : read);
        if (!is_whole(each->in.value())) ++wrong;
        if (each->in.is_safe() != (each->in.value().number() == Connected::kSafe)) ++wrong;
      }
    }
  };
  std::atomic<bool> end{false};
  std::thread node{[&] {
    while (!end) {
      for (Connected* each : {&objects, &bytes}) each->link.trust();
      std::this_thread::sleep_for(milliseconds{3});
      for (Connected* each : {&objects, &bytes}) each->link.withhold();
      std::this_thread::sleep_for(milliseconds{3});
    }
  }};
  run(2000);
  end = true;
  node.join();
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(read, 200U);
  EXPECT_GT(safe, 50U);
}

TEST_F(RealTimePath, SavingAllocatesAndLocksNothing) {
  const auto place = std::make_unique<channel::SavedState>();
  std::array<std::uint64_t, channel::kMostSaved / sizeof(std::uint64_t)> kept{};
  bodies[1].on_run = [&](const Cycle& cycle) {
    kept.fill(cycle.number);
    place->save(kept.data(), sizeof kept, 1, to_ns(cycle.start));
  };
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
  ASSERT_NE(place->saved(), nullptr);
  EXPECT_GT(place->saved()->number, 1000U);
}

TEST_F(RealTimePath, ServicesAllocateAndLockNothingAndRingOnceACycle) {
  struct Answers : Plain {
    Service<samples::Count, samples::Count> answer{*this, "answer"};
  } server;
  Asking<samples::Count> objects;
  Asking<samples::Count> bytes;
  const ConnectedService first{objects, server, "answer", true};
  const ConnectedService second{bytes, server, "answer", false, channel::kSporadicBit};
  PortContext context{.start_ns = 1, .bell = &bell};
  for (Component* each : std::initializer_list<Component*>{&objects, &bytes, &server})
    serve_all(*each, context);
  samples::Count count;
  samples::Count answer;
  count.few().reserve(4);
  answer.few().reserve(4);
  std::array<std::uint64_t, 6> told{};
  std::uint64_t wrong = 0;
  std::uint64_t last = 0;
  bodies[1].on_run = [&](const Cycle& cycle) {
    context.start_ns = to_ns(cycle.start);
    for (auto* each : {&objects, &bytes}) {
      const CallStatus status = each->ask.poll();
      ++told[static_cast<std::size_t>(status)];
      if (status == CallStatus::pending) continue;
      if (status == CallStatus::replied &&
          (!is_whole(each->ask.reply()) || each->ask.reply().number() % 2 != 0))
        ++wrong;
      fill(count, ++last);
      each->ask.call(count, milliseconds{20});
    }
  };
  bodies[2].on_run = [&](const Cycle&) {
    while (server.answer.take()) {
      if (server.answer.request().number() % 7 == 0) {
        server.answer.refuse("a multiple of 7");
      } else if (server.answer.request().number() % 13 != 0) {
        fill(answer, 2 * server.answer.request().number());
        server.answer.reply(answer);
      }
    }
  };
  run(2000);
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(told[static_cast<std::size_t>(CallStatus::replied)], 100U);
  EXPECT_GT(told[static_cast<std::size_t>(CallStatus::refused)], 10U);
  EXPECT_GT(told[static_cast<std::size_t>(CallStatus::timed_out)], 3U);
  std::map<std::uint64_t, int> rings;
  for (const SystemCall& call : row_calls) {
    EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
    if (is_futex(call, FUTEX_WAKE_BITSET, &bell, sizeof bell)) ++rings[call.stamp];
  }
  for (const auto& [cycle, n] : rings) EXPECT_EQ(n, 1) << "rings after cycle " << cycle;
}

/// Real components in the place of module 1: it counts its runs in what it saves, and writes the count.
class RealTimeSwap : public RealTimePath {
 protected:
  static inline const std::string kFolder = std::string{TAKT_BINARY_DIR} + "/tests/components/";

  void SetUp() override {
    if (TAKT_SANITIZED != 0) GTEST_SKIP() << "see above";
    const channel::Link::Options options{.depth = 256, .is_queue = true};
    memory.resize(channel::Link::layout(options).size() / sizeof(memory[0]));
    channel::Link::format(start(), options);
    runs = std::make_unique<ThreadModule>();
    runs->attach(&bell, &blocks[1]);
    runs->save_in(*saved);
    ASSERT_TRUE(runs->load(kFolder + "ticks.so", os::Library::Globals::shared, false).ok());
    values = runs->port("out")->make_values(channel::Link{start()}.buffers());
    connect(*runs);
    ASSERT_TRUE(runs->initialize({}).ok());
    ASSERT_TRUE(runs->start().ok());
    in.connect(channel::Link{start()}, values);
    in.serve(context);
    replaced = runs.get();
    RealTimePath::SetUp();
  }
  std::byte* start() { return memory[0].data(); }
  void connect(ThreadModule& module) { module.port("out")->connect(channel::Link{start()}, values); }

  Swapped swap(const std::string& file) {
    auto next = std::make_unique<ThreadModule>();
    next->attach(&bell, &blocks[1]);
    next->stand_by();
    Swapped swapped = carry_out({.index = 1,
                                 .block = blocks[1],
                                 .before = *runs,
                                 .next = *next,
                                 .body = *next,
                                 .threads = *threads,
                                 .place = *saved,
                                 .activity = activity,
                                 .path = kFolder + file,
                                 .properties = {},
                                 .connect = [&]() -> Result<void> {
                                   connect(*next);
                                   return {};
                                 },
                                 .exclude = [] { return std::unique_lock<std::mutex>{}; },
                                 .handle_by = [](ThreadModule&) {},
                                 .ends = [this] { return end.load(); }});
    if (swapped.kept) runs.swap(next);
    return swapped;
  }

  struct alignas(64) Line : std::array<std::byte, 64> {};
  std::vector<Line> memory;
  void* values = nullptr;
  std::unique_ptr<channel::SavedState> saved = std::make_unique<channel::SavedState>();
  std::unique_ptr<ThreadModule> runs;
  channel::Activity activity{};
  PortContext context{.start_ns = 1};
  InPort<samples::Count> in{"in"};
  std::atomic<bool> end{false};
};

TEST_F(RealTimeSwap, AllocatesAndLocksNothingAndMissesNoCount) {
  std::uint64_t last = 0;
  std::uint64_t wrong = 0;
  bodies[2].on_run = [&](const Cycle&) {
    while (in.read()) {
      if (in.value().number() != last + 1 || !is_whole(in.value())) ++wrong;
      last = in.value().number();
    }
  };
  int kept = 0;
  int translated = 0;
  std::string failure;
  std::thread swapper{[&] {
    while (!end && failure.empty()) {
      const bool other = kept % 3 == 0;  // both what is copied and what is translated
      const Swapped swapped = swap(other ? "ticks_more.so" : "ticks.so");
      if (swapped.kept) {
        ++kept;
        translated += other ? 1 : 0;
      } else if (!end) {
        failure = swapped.text;
      }
    }
  }};
  run(4000);
  end = true;
  swapper.join();
  EXPECT_EQ(failure, "");
  for (const auto& [what, n] : seen) EXPECT_EQ(n, 0U) << what;
  for (const SystemCall& call : row_calls) EXPECT_EQ(call.number, SYS_futex) << "in cycle " << call.stamp;
  EXPECT_GT(kept, 20);
  EXPECT_GT(translated, 5);
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(last, 3000U);
  RecordProperty("kept", kept);
}

// The traps work: what a module must not do is seen.

/// What is done once, in the hundredth cycle or, where that row is lost, in the next one.
std::function<void(const Cycle&)> once(std::function<void()> what) {
  return [what = std::move(what), done = false](const Cycle& cycle) mutable {
    if (done || cycle.number < 100) return;
    done = true;
    what();
  };
}

TEST_F(RealTimePath, AModuleThatMakesASystemCallIsSeen) {
  bodies[1].on_run = once([] { static_cast<void>(::syscall(SYS_getpid)); });
  run(200);
  const auto others = std::count_if(row_calls.begin(), row_calls.end(),
                                    [](const SystemCall& call) { return call.number != SYS_futex; });
  EXPECT_EQ(others, 1);
  EXPECT_EQ(std::count_if(row_calls.begin(), row_calls.end(),
                          [](const SystemCall& call) { return call.number == SYS_getpid; }),
            1);
}

TEST_F(RealTimePath, ASporadicModuleThatMakesASystemCallIsSeen) {
  bodies[kSporadic].on_run = [this, next = bodies[kSporadic].on_run](const Cycle& cycle) {
    next(cycle);
    if (blocks[kSporadic].cycles.load() == 20) static_cast<void>(::syscall(SYS_getpid));
  };
  run(200);
  EXPECT_EQ(std::count_if(sporadic_calls.begin(), sporadic_calls.end(),
                          [](const SystemCall& call) { return call.number == SYS_getpid; }),
            1);
}

TEST_F(RealTimePath, AModuleThatAllocatesIsSeen) {
  bodies[1].on_run = once([] {
    const std::string text(100, 'x');
    asm volatile("" : : "r"(text.data()) : "memory");
  });
  run(200);
  EXPECT_EQ(seen["allocations"], 1U);
  EXPECT_EQ(seen["frees"], 1U);
}

TEST_F(RealTimePath, AModuleThatLocksIsSeen) {
  std::mutex mutex;
  bodies[1].on_run = once([&mutex] { const std::lock_guard lock{mutex}; });
  run(200);
  EXPECT_EQ(seen["locks"], 2U);
}

TEST_F(RealTimePath, AModuleThatWaitsForAConditionIsSeen) {
  std::mutex mutex;
  std::condition_variable condition;
  bodies[1].on_run = once([&] {
    std::unique_lock lock{mutex};
    condition.wait_for(lock, microseconds{1});
  });
  run(200);
  EXPECT_EQ(seen["waits"], 1U);
}

TEST(Clock, MakesNoSystemCall) {
  if (TAKT_SANITIZED != 0) GTEST_SKIP() << "the sanitizer makes system calls of its own";
  SystemCallTrap trap;
  std::vector<SystemCall> calls;
  int refused = 0;
  os::MonotonicClock clock;
  std::thread reader{[&] {
    refused = trap.arm();
    Instant last{};
    for (int i = 0; i < 10'000; ++i) {
      const Instant now = clock.now();
      if (now < last) refused = -1;
      last = now;
    }
    calls = trap.calls();
  }};
  reader.join();
  ASSERT_EQ(refused, 0) << std::strerror(refused);
  EXPECT_TRUE(calls.empty()) << "system call " << calls.front().number << ": the clock source is no TSC, see "
                             << "/sys/devices/system/clocksource/clocksource0/current_clocksource";
}

}  // namespace
}  // namespace takt::host
