#include "recorder.hpp"

#include <dlfcn.h>
#include <execinfo.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "page_faults.hpp"
#include "system_calls.hpp"

namespace takt::check {

namespace {

using channel::LoadedObject;
using channel::Violation;
using channel::ViolationLog;

constexpr auto relaxed = std::memory_order_relaxed;

// The values of a thread's selector byte. The kernel reads this byte to decide whether it intercepts a system
// call (linux/prctl.h).
constexpr char kAllow = 0;
constexpr char kBlock = 1;

/// The data that the library stores for each thread.
struct Mine {
  volatile char selector = kAllow;
  bool prepared = false;
  std::uint64_t mark = 0;  ///< kInside, the hook and the module, packed into one number
};
constexpr std::uint64_t kInside = std::uint64_t{1} << 63;

thread_local Mine mine;

ViolationLog* violation_log = nullptr;
FixedText<256> program;            // path of the program of this process
const void* own_object = nullptr;  // address at which this library is loaded

void take_log() noexcept {
  const char* fd = std::getenv(channel::kCheckFd);
  if (fd == nullptr) return;
  const int number = std::atoi(fd);
  struct stat status {};
  if (::fstat(number, &status) != 0 || static_cast<std::size_t>(status.st_size) < sizeof(ViolationLog))
    return;
  void* memory = ::mmap(nullptr, sizeof(ViolationLog), PROT_READ | PROT_WRITE, MAP_SHARED, number, 0);
  if (memory == MAP_FAILED) return;
  ::close(number);
  ::unsetenv(channel::kCheckFd);
  ::unsetenv("LD_PRELOAD");  // so programs that this process starts are not checked
  violation_log = static_cast<ViolationLog*>(memory);
}

[[gnu::constructor]] void begin() {
  Dl_info info{};
  if (::dladdr(reinterpret_cast<const void*>(&begin), &info) != 0) own_object = info.dli_fbase;
  std::array<char, PATH_MAX> path{};
  const ssize_t length = ::readlink("/proc/self/exe", path.data(), path.size() - 1);
  program.assign({path.data(), length > 0 ? static_cast<std::size_t>(length) : 0});
  // The first call of backtrace() loads a library and allocates memory. So make the first call here, before
  // any thread is checked.
  std::array<void*, 2> frames{};
  ::backtrace(frames.data(), frames.size());
  take_log();
  if (violation_log == nullptr) return;
  serve_system_calls();
  serve_page_faults();
}

std::uint32_t object_number(std::string_view path) noexcept {
  const std::uint32_t known = std::min<std::uint32_t>(
      violation_log->claimed_objects.load(std::memory_order_acquire), ViolationLog::kObjects);
  for (std::uint32_t i = 0; i < known; ++i) {
    const LoadedObject& object = violation_log->objects[i];
    if (object.ready.load(std::memory_order_acquire) != 0 && object.path.view() == path) return i + 1;
  }
  const std::uint32_t mine_now = violation_log->claimed_objects.fetch_add(1, std::memory_order_acq_rel);
  if (mine_now >= ViolationLog::kObjects) return 0;
  LoadedObject& object = violation_log->objects[mine_now];
  object.path.assign(path);
  object.ready.store(1, std::memory_order_release);  // stored last, so that readers see the complete path
  return mine_now + 1;
}

channel::CodePlace place_of(void* address) noexcept {
  dl_find_object object{};
  if (::_dl_find_object(address, &object) != 0) return {0, reinterpret_cast<std::uintptr_t>(address)};
  const link_map* map = object.dlfo_link_map;
  const std::string_view name = map->l_name;
  // A return address is the address after the call instruction, so the byte before it belongs to the call
  // instruction.
  return {object_number(name.empty() ? program.view() : name),
          reinterpret_cast<std::uintptr_t>(address) - map->l_addr - 1};
}

bool is_in_this_library(void* address) noexcept {
  dl_find_object object{};
  return ::_dl_find_object(address, &object) == 0 && object.dlfo_map_start == own_object;
}

// The log entry of a violation; null if the log is full. If `claimed` is true, this thread has just claimed
// the entry and must fill it.
struct Found {
  Violation* entry;
  bool claimed;
};
Found entry_of(std::uint64_t key) noexcept {
  for (Violation& entry : violation_log->violations) {
    std::uint64_t there = entry.key.load(relaxed);
    // The thread that changes the key from 0 to another value owns the entry.
    if (there == 0 && entry.key.compare_exchange_strong(there, key, relaxed)) return {&entry, true};
    if (there == key) return {&entry, false};
  }
  return {nullptr, false};
}

}  // namespace

bool counts() noexcept { return mine.selector == kBlock; }
char* selector() noexcept { return const_cast<char*>(&mine.selector); }

Pause::Pause() noexcept : before_(mine.selector) { mine.selector = kAllow; }
Pause::~Pause() { mine.selector = before_; }

void is_blind(std::uint32_t bit) noexcept { violation_log->blind.fetch_or(bit, relaxed); }

void record(const Occurrence& occurrence) noexcept {
  // Skip the innermost frames, which belong to this library. The array has room for kOwn such frames.
  constexpr int kOwn = 8;
  std::array<void*, Violation::kFrames + kOwn> frames{};
  const int all = occurrence.placed ? ::backtrace(frames.data(), static_cast<int>(frames.size())) : 0;
  int first = 0;
  while (first < all && is_in_this_library(frames[static_cast<std::size_t>(first)])) ++first;
  const std::size_t depth = std::min<std::size_t>(static_cast<std::size_t>(all - first), Violation::kFrames);
  void* const* const stack = frames.data() + first;

  std::uint64_t key = 0xcbf29ce484222325;  // FNV-1a
  const auto add = [&key](std::uint64_t value) { key = (key ^ value) * 0x100000001b3; };
  add(mine.mark);
  add(static_cast<std::uint64_t>(occurrence.kind));
  add(static_cast<std::uint64_t>(occurrence.system_call));
  add(reinterpret_cast<std::uintptr_t>(occurrence.function));
  for (std::size_t i = 0; i < depth; ++i) add(reinterpret_cast<std::uintptr_t>(stack[i]));
  const auto [entry, claimed] = entry_of(key == 0 ? 1 : key);
  if (entry == nullptr) {
    violation_log->dropped.fetch_add(occurrence.times, relaxed);
    return;
  }
  entry->count.fetch_add(occurrence.times, relaxed);
  if (!claimed) return;
  entry->module = static_cast<std::uint32_t>(mine.mark);
  entry->hook = static_cast<channel::Doing>((mine.mark & ~kInside) >> 32);
  entry->kind = occurrence.kind;
  entry->system_call = occurrence.system_call;
  entry->function.assign(occurrence.function);
  entry->depth = static_cast<std::uint32_t>(depth);
  for (std::size_t i = 0; i < depth; ++i) entry->frames[i] = place_of(stack[i]);
  if (occurrence.exact && depth > 0) ++entry->frames[0].address;
  entry->ready.store(1, std::memory_order_release);  // stored last, so that readers see the complete entry
}

}  // namespace takt::check

extern "C" {

[[gnu::visibility("default")]] std::uint64_t takt_check_enter(std::uint32_t module, std::uint32_t hook) {
  using namespace takt::check;
  if (violation_log == nullptr) return 0;
  mine.selector = kAllow;  // stops the recording if the thread is already in a module
  if (!mine.prepared) {
    mine.prepared = true;
    watch_system_calls();
    watch_page_faults();
  }
  count_page_faults((mine.mark & kInside) != 0);
  const std::uint64_t before = mine.mark;
  mine.mark = kInside | std::uint64_t{hook} << 32 | module;
  mine.selector = kBlock;
  return before;
}

[[gnu::visibility("default")]] void takt_check_leave(std::uint64_t before) {
  using namespace takt::check;
  if (violation_log == nullptr) return;
  mine.selector = kAllow;
  count_page_faults(true);
  mine.mark = before;
  if ((before & kInside) != 0) mine.selector = kBlock;
}
}
