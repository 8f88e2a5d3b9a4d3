// A safe value that no sample can equal, because is_whole() is false for it.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>

#include "sample.hpp"

inline samples::Count safe_value(std::uint64_t number) {
  samples::Count count;
  count.number(number);
  for (double& same : count.same()) same = -1;
  return count;
}

/// Reports on standard error each time a reader switches between samples and the safe value, and each value
/// that is neither. Every line contains the time (monotonic, ns): "SAFE 123 after 5", "LIVE 456 with 6",
/// "WRONG 789 with 7". After a restart, a writer numbers its samples from 1 again. Numbers that are times
/// (`failing_source.so`) never decrease.
class SafeWatch {
 public:
  /// The deadline of the connection: a sample older than this is reported as wrong. 0 means no limit.
  explicit SafeWatch(std::chrono::nanoseconds oldest = {}) : oldest_(oldest) {}

  template <class Port>
  void look(const char* who, const Port& port, bool news) {
    const samples::Count& count = port.value();
    const bool first = !said_;
    const bool safe = count.same()[0] == -1;
    bool wrong = safe != port.is_safe();
    if (safe) {
      for (const double same : count.same()) wrong |= same != -1;
      wrong |= count.few().size() > 1;
    } else {
      const bool may_go_back = count.number() <= 20 || (safe_ && count.number() < kTimes);
      wrong |= !is_whole(count) || (news && count.number() <= last_ && !may_go_back);
      wrong |= oldest_.count() > 0 && port.age() > oldest_;
    }
    if (wrong) print(who, "WRONG", "with", count.number());
    if (first || safe != safe_) {
      if (!news) print(who, "WRONG", "without news, with", count.number());
      print(who, safe ? "SAFE" : "LIVE", safe ? "after" : "with", safe ? last_ : count.number());
    }
    said_ = true;
    safe_ = safe;
    if (!safe) last_ = count.number();
  }

 private:
  static constexpr std::uint64_t kTimes =
      1'000'000'000'000'000;  // larger numbers are times, in us since 1970

  static void print(const char* who, const char* what, const char* with, std::uint64_t number) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    std::fprintf(stderr, "%s %s %lld %s %llu\n", who, what, static_cast<long long>(now.count()), with,
                 static_cast<unsigned long long>(number));
  }
  std::chrono::nanoseconds oldest_;
  bool said_ = false;
  bool safe_ = false;
  std::uint64_t last_ = 0;
};
