#include <takt/os/thread_use.hpp>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>

namespace takt::os {

// Reads the files stat, schedstat and status of the thread. In stat, the thread's name is in parentheses and
// may contain any character, so the fields are counted from the last ')'.
std::optional<ThreadUse> read_thread_use(int tid, const std::string& root) {
  const std::string folder = root + "/proc/" + std::to_string(tid) + "/task/" + std::to_string(tid);
  const std::string stat = text_of(folder + "/stat");
  const std::size_t name_ends = stat.rfind(')');
  if (name_ends == std::string::npos) return std::nullopt;
  ThreadUse use;
  std::istringstream words{stat.substr(name_ends + 1)};
  std::string word;
  for (int place = 3; words >> word; ++place) {  // fields are numbered as in proc(5)
    std::istringstream number{word};
    if (place == 3) use.stopped = word == "T" || word == "t";
    if (place == 3) use.ready = word == "R";
    if (place == 10) number >> use.minor_faults;
    if (place == 12) number >> use.major_faults;
    if (place == 39) number >> use.cpu;
  }
  std::istringstream times{text_of(folder + "/schedstat")};
  std::int64_t ran = 0;
  std::int64_t waited = 0;
  if (times >> ran >> waited) {
    use.ran = Nanoseconds{ran};
    use.waited = Nanoseconds{waited};
  }
  std::istringstream lines{text_of(folder + "/status")};
  for (std::string line; std::getline(lines, line);) {
    constexpr std::string_view kGaveWay = "nonvoluntary_ctxt_switches:";
    if (!line.starts_with(kGaveWay)) continue;
    std::istringstream number{line.substr(kGaveWay.size())};
    number >> use.gave_way;
  }
  return use;
}

std::vector<Nanoseconds> read_stolen(const std::string& root) {
  const long second = ::sysconf(_SC_CLK_TCK);
  std::vector<Nanoseconds> stolen;
  std::istringstream lines{text_of(root + "/proc/stat")};
  for (std::string line; second > 0 && std::getline(lines, line);) {
    std::istringstream words{line};
    std::string name;
    words >> name;
    if (!name.starts_with("cpu") || name == "cpu") continue;
    std::int64_t ticks = 0;
    for (int place = 0; place < 8; ++place)
      // Fields: user nice system idle iowait irq softirq steal.
      words >> ticks;
    std::istringstream digits{name.substr(3)};
    std::size_t cpu = 0;
    if (!(digits >> cpu) || cpu > 65536) continue;
    if (stolen.size() <= cpu) stolen.resize(cpu + 1);
    if (words) stolen[cpu] = Nanoseconds{ticks * (1'000'000'000 / second)};
  }
  return stolen;
}

Nanoseconds measure_minor_fault() {
  constexpr std::size_t kPages = 32;
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  Nanoseconds least = Nanoseconds::max();
  for (int i = 0; i < 5; ++i) {
    // If the process locks all memory, mmap() itself maps the pages, so measure mmap(), too.
    const Instant before = now();
    void* const memory =
        ::mmap(nullptr, kPages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return Nanoseconds{0};
    for (std::size_t at = 0; at < kPages * page; at += page) static_cast<volatile char*>(memory)[at] = 1;
    least = std::min(least, now() - before);
    ::munmap(memory, kPages * page);
  }
  return least / static_cast<std::int64_t>(kPages);
}

}  // namespace takt::os
