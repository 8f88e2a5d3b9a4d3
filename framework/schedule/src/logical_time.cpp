#include <takt/schedule/logical_time.hpp>

namespace takt::schedule {

std::uint64_t samples_ahead(const model::Device& device, const model::Module& writer,
                            const model::Module* reader) {
  // Additional samples: one of the current period, one of the previous period, and one that may
  // arrive in the meantime.
  constexpr std::uint64_t kSpare = 3;
  if (model::timing_of(device, writer) != model::Timing::let) return 0;
  const Nanoseconds period = reader == nullptr ? Nanoseconds{0} : reader->period.value_or(Nanoseconds{0});
  return static_cast<std::uint64_t>(period / *writer.period) + kSpare;
}

}  // namespace takt::schedule
