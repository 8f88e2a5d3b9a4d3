#include <takt/os/machine.hpp>

#include <sched.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>

#include <takt/os/files.hpp>
#include <takt/os/real_time.hpp>

namespace takt::os {

namespace {

namespace fs = std::filesystem;

// Linux 6.12 introduced a deadline server for ordinary threads, in place of real-time throttling.
constexpr int kFairServerMajor = 6;
constexpr int kFairServerMinor = 12;
constexpr Nanoseconds kFairServerKeeps = std::chrono::milliseconds{50};

template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end == text.data()) return std::nullopt;
  return value;
}

template <class Number>
std::optional<Number> number_of(const fs::path& file) {
  return number_in<Number>(text_of(file));
}

std::vector<std::string> words_in(const std::string& text) {
  std::istringstream stream{text};
  return {std::istream_iterator<std::string>{stream}, {}};
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  for (fs::directory_iterator at{folder, error}, end; !error && at != end; at.increment(error))
    entries.push_back(at->path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

// Returns the CPUs on which the calling thread may run.
std::vector<int> affinity() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cpus;
  if (::sched_getaffinity(0, sizeof set, &set) != 0) return {0};
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set)) cpus.push_back(cpu);
  }
  return cpus;
}

// Returns the CPUs on which a thread of this process may run if it requests them. sched_getaffinity() alone
// does not show them: it leaves out isolated CPUs, to which the kernel moves a thread only on request. So a
// thread requests all CPUs, and the kernel removes those that a cpuset limit excludes. The thread ends
// afterwards, so that no other thread runs on these CPUs.
std::vector<int> permitted_cpus(const std::vector<int>& online) {
  std::vector<int> permitted;
  auto thread = Thread::start(
      {.name = "takt-probe"},
      [&] {
        static_cast<void>(pin(0, online));
        permitted = affinity();
      },
      nullptr);
  if (!thread) return affinity();
  thread->join();
  return permitted;
}

// Returns the word in brackets or parentheses, for example "madvise" from "always [madvise] never", or "full"
// from "none voluntary (full)".
std::string chosen_of(const std::string& text, char open, char close) {
  const std::size_t from = text.find(open);
  const std::size_t to = text.find(close, from);
  return to == std::string::npos ? "" : text.substr(from + 1, to - from - 1);
}

std::optional<Preemption> preemption_named(std::string_view name) {
  for (const auto preemption :
       {Preemption::none, Preemption::voluntary, Preemption::lazy, Preemption::full}) {
    if (name == to_text(preemption)) return preemption;
  }
  return std::nullopt;
}

std::optional<Preemption> preemption_of(const fs::path& root, const Machine& machine) {
  const auto says = [&machine](std::string_view word) {
    return machine.version.find(word) != std::string::npos;
  };
  if (text_of(root / "sys/kernel/realtime") == "1" || says("PREEMPT_RT")) return Preemption::real_time;
  if (says("PREEMPT_DYNAMIC")) {
    // The preemption model can be set at run time, by a boot parameter, or in the kernel's configuration, in
    // this order of precedence. Read them in this order.
    const std::string now = chosen_of(text_of(root / "sys/kernel/debug/sched/preempt"), '(', ')');
    if (!now.empty()) return preemption_named(now);
    std::optional<Preemption> found;
    for (const std::string& word : words_in(text_of(root / "proc/cmdline"))) {
      if (word.starts_with("preempt=")) found = preemption_named(std::string_view{word}.substr(8));
    }
    if (found) return found;
    const std::string config = "\n" + text_of(root / "boot" / ("config-" + machine.kernel)) + "\n";
    const auto built = [&config](std::string_view option) {
      return config.find("\nCONFIG_" + std::string{option} + "=y\n") != std::string::npos;
    };
    if (built("PREEMPT_NONE")) return Preemption::none;
    if (built("PREEMPT_VOLUNTARY")) return Preemption::voluntary;
    if (built("PREEMPT_LAZY")) return Preemption::lazy;
    if (built("PREEMPT")) return Preemption::full;
    return std::nullopt;
  }
  if (says("PREEMPT_LAZY")) return Preemption::lazy;
  if (says("PREEMPT")) return Preemption::full;
  // The version text does not distinguish kernels without preemption from those with voluntary preemption.
  return machine.version.empty() ? std::optional<Preemption>{} : Preemption::voluntary;
}

bool has_fair_server(const std::string& release) {
  const auto major = number_in<int>(release);
  const std::size_t dot = release.find('.');
  if (!major || dot == std::string::npos) return false;
  const auto minor = number_in<int>(std::string_view{release}.substr(dot + 1));
  return *major > kFairServerMajor || (*major == kFairServerMajor && minor.value_or(0) >= kFairServerMinor);
}

std::optional<Limit> limit_of(const std::string& limits, std::string_view name) {
  std::istringstream lines{limits};
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name)) continue;
    const auto words = words_in(line.substr(name.size()));
    if (words.size() < 2) return std::nullopt;
    return Limit{number_in<std::uint64_t>(words[0]), number_in<std::uint64_t>(words[1])};
  }
  return std::nullopt;
}

Processor processor_of(const fs::path& folder, int number) {
  Processor processor{.number = number,
                      .governor = text_of(folder / "cpufreq/scaling_governor"),
                      .idle_states = {},
                      .siblings = parse_cpus(text_of(folder / "topology/thread_siblings_list"))};
  for (int s = 0;; ++s) {
    const fs::path state = folder / "cpuidle" / ("state" + std::to_string(s));
    const std::string name = text_of(state / "name");
    if (name.empty()) return processor;
    processor.idle_states.push_back(
        {.name = name,
         .exit_latency = std::chrono::microseconds{number_of<std::int64_t>(state / "latency").value_or(0)},
         .disabled = text_of(state / "disable") == "1"});
  }
}

std::vector<Interrupt> interrupts_of(const fs::path& root) {
  std::vector<Interrupt> interrupts;
  for (const fs::path& folder : entries_of(root / "proc/irq")) {
    const auto number = number_in<int>(folder.filename().string());
    if (!number) continue;
    Interrupt interrupt{.number = *number};
    // If an interrupt has a handler, its folder contains a folder with the name of the handler.
    std::error_code error;
    for (const fs::path& entry : entries_of(folder)) {
      if (fs::is_directory(entry, error)) interrupt.name = entry.filename().string();
    }
    if (interrupt.name.empty()) continue;
    interrupt.cpus = parse_cpus(text_of(folder / "effective_affinity_list"));
    if (interrupt.cpus.empty()) interrupt.cpus = parse_cpus(text_of(folder / "smp_affinity_list"));
    interrupts.push_back(std::move(interrupt));
  }
  return interrupts;
}

bool runs(const fs::path& root, std::string_view program) {
  const auto entries = entries_of(root / "proc");
  return std::any_of(entries.begin(), entries.end(), [program](const fs::path& entry) {
    return number_in<int>(entry.filename().string()) && text_of(entry / "comm") == program;
  });
}

std::string hypervisor_of(const fs::path& root) {
  std::ifstream lines{root / "proc/cpuinfo"};
  bool flag = false;
  for (std::string line; !flag && std::getline(lines, line);) {
    if (!line.starts_with("flags")) continue;
    const auto words = words_in(line);
    flag = std::find(words.begin(), words.end(), "hypervisor") != words.end();
    break;  // the first CPU is enough, because all CPUs have the same flags
  }
  // ARM processors have no such flag, so no hypervisor is found there.
  if (!flag) return {};
  const std::string product = text_of(root / "sys/class/dmi/id/product_name");
  const std::string vendor = text_of(root / "sys/class/dmi/id/sys_vendor");
  if (vendor.empty() && product.empty()) return "a hypervisor";
  return vendor + (vendor.empty() || product.empty() ? "" : " ") + product;
}

std::string container_of(const fs::path& root) {
  std::error_code error;
  for (const char* file : {".dockerenv", "run/.containerenv", "run/systemd/container"}) {
    if (fs::exists(root / file, error)) return std::string{"/"} + file;
  }
  return {};
}

std::optional<std::uint64_t> size_of_filesystem(const fs::path& folder) {
  struct statvfs status {};
  if (::statvfs(folder.c_str(), &status) != 0) return std::nullopt;
  return std::uint64_t{status.f_blocks} * status.f_frsize;
}

// Returns the root folder of this machine if `root` is empty.
fs::path root_folder(const std::string& root) { return root.empty() ? "/" : root; }

}  // namespace

const char* to_text(Preemption preemption) noexcept {
  switch (preemption) {
    case Preemption::none:
      return "none";
    case Preemption::voluntary:
      return "voluntary";
    case Preemption::lazy:
      return "lazy";
    case Preemption::full:
      return "full";
    case Preemption::real_time:
      break;
  }
  return "real-time";
}

double ProcessorTime::stolen_share(const ProcessorTime& before) const noexcept {
  return all <= before.all
             ? 0
             : static_cast<double>(stolen - before.stolen) / static_cast<double>(all - before.all);
}

std::vector<int> parse_cpus(const std::string& text) {
  constexpr int kMost = 8192;
  std::vector<int> cpus;
  std::istringstream parts{text};
  for (std::string part; std::getline(parts, part, ',');) {
    const auto first = number_in<int>(part);
    const std::size_t dash = part.find('-');
    const auto last =
        dash == std::string::npos ? first : number_in<int>(std::string_view{part}.substr(dash + 1));
    if (!first || !last || *first < 0 || *last >= kMost) return {};
    for (int cpu = *first; cpu <= *last; ++cpu) cpus.push_back(cpu);
  }
  return cpus;
}

model::Cpus read_cpus() {
  model::Cpus cpus{.online = parse_cpus(text_of("/sys/devices/system/cpu/online")), .ordinary = affinity()};
  cpus.permitted = permitted_cpus(cpus.online);
  return cpus;
}

std::vector<int> read_isolated_cpus(const std::string& root) {
  return parse_cpus(text_of(root_folder(root) / "sys/devices/system/cpu/isolated"));
}

std::optional<Throttling> read_throttling(const std::string& root_name) {
  const fs::path root = root_folder(root_name);
  if (has_fair_server(text_of(root / "proc/sys/kernel/osrelease"))) {
    Throttling found{.kept = kFairServerKeeps, .fair_server = true, .seen = false};
    for (const fs::path& cpu : entries_of(root / "sys/kernel/debug/sched/fair_server")) {
      const auto runtime = number_of<std::int64_t>(cpu / "runtime");
      const auto period = number_of<std::int64_t>(cpu / "period");
      if (!runtime || !period || *period <= 0) continue;
      const Throttling mine{
          .kept = Nanoseconds{*runtime}, .period = Nanoseconds{*period}, .fair_server = true, .seen = true};
      if (!found.seen || mine.kept > found.kept)
        // Use the CPU on which the kernel withholds the most time.
        found = mine;
    }
    return found;
  }
  const auto runtime = number_of<std::int64_t>(root / "proc/sys/kernel/sched_rt_runtime_us");
  const auto period = number_of<std::int64_t>(root / "proc/sys/kernel/sched_rt_period_us");
  if (!runtime || !period || *period <= 0) return std::nullopt;
  const std::int64_t kept = *runtime < 0 ? 0 : std::max<std::int64_t>(0, *period - *runtime);
  return Throttling{.kept = std::chrono::microseconds{kept}, .period = std::chrono::microseconds{*period}};
}

std::optional<ProcessorTime> read_processor_time(const std::string& root) {
  std::ifstream stream{root_folder(root) / "proc/stat"};
  std::string line;
  std::getline(stream, line);
  const auto words = words_in(line);
  // Index of "steal" in the line: "cpu" user nice system idle iowait irq softirq steal guest guest_nice.
  constexpr std::size_t kSteal = 8;
  if (words.size() <= kSteal || words[0] != "cpu") return std::nullopt;
  ProcessorTime time;
  // The fields after "steal" are not added, because guest time is already part of user time.
  for (std::size_t i = 1; i <= kSteal; ++i) time.all += number_in<std::uint64_t>(words[i]).value_or(0);
  time.stolen = number_in<std::uint64_t>(words[kSteal]).value_or(0);
  return time;
}

std::optional<std::uint64_t> read_swap_bytes(const std::string& root) {
  std::ifstream lines{root_folder(root) / "proc/swaps"};
  if (!lines) return std::nullopt;
  std::uint64_t bytes = 0;
  std::string line;
  std::getline(lines, line);  // the heading
  while (std::getline(lines, line)) {
    const auto words = words_in(line);
    if (words.size() >= 3) bytes += number_in<std::uint64_t>(words[2]).value_or(0) * 1024;
  }
  return bytes;
}

Machine read_machine(const std::string& root_name) {
  const fs::path root = root_folder(root_name);
  const fs::path cpus = root / "sys/devices/system/cpu";
  Machine machine;
  machine.kernel = text_of(root / "proc/sys/kernel/osrelease");
  machine.version = text_of(root / "proc/sys/kernel/version");
  machine.preemption = preemption_of(root, machine);
  machine.throttling = read_throttling(root_name);
  const std::string limits = text_of(root / "proc/self/limits");
  machine.priority = limit_of(limits, "Max realtime priority");
  machine.locked = limit_of(limits, "Max locked memory");
  machine.files = limit_of(limits, "Max open files");
  machine.online = parse_cpus(text_of(cpus / "online"));
  machine.isolated = read_isolated_cpus(root_name);
  machine.tickless = parse_cpus(text_of(cpus / "nohz_full"));
  for (const int cpu : machine.online)
    machine.processors.push_back(processor_of(cpus / ("cpu" + std::to_string(cpu)), cpu));
  if (const std::string active = text_of(cpus / "smt/active"); !active.empty())
    machine.hyper_threads = active == "1";
  const fs::path clock = root / "sys/devices/system/clocksource/clocksource0";
  machine.clock = text_of(clock / "current_clocksource");
  machine.clocks = words_in(text_of(clock / "available_clocksource"));
  machine.interrupts = interrupts_of(root);
  machine.irqbalance = runs(root, "irqbalance");
  if (const auto slack = number_of<std::int64_t>(root / "proc/self/timerslack_ns"))
    machine.timer_slack = Nanoseconds{*slack};
  machine.swap_bytes = read_swap_bytes(root_name);
  machine.shared_memory_bytes = size_of_filesystem(root / "dev/shm");
  machine.receive_buffer_bytes = number_of<std::uint64_t>(root / "proc/sys/net/core/rmem_max");
  machine.send_buffer_bytes = number_of<std::uint64_t>(root / "proc/sys/net/core/wmem_max");
  machine.huge_pages = chosen_of(text_of(root / "sys/kernel/mm/transparent_hugepage/enabled"), '[', ']');
  machine.memfd_noexec = number_of<int>(root / "proc/sys/vm/memfd_noexec");
  if (const auto balancing = number_of<int>(root / "proc/sys/kernel/numa_balancing"))
    machine.numa_balancing = *balancing != 0;
  machine.hypervisor = hypervisor_of(root);
  machine.container = container_of(root);
  struct statvfs settings {};
  machine.sealed =
      ::statvfs((root / "proc/sys").c_str(), &settings) == 0 && (settings.f_flag & ST_RDONLY) != 0;
  machine.time = read_processor_time(root_name);
  return machine;
}

}  // namespace takt::os
