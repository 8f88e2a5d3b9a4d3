#include "unmatched_writers.hpp"

#include <mutex>

#include "replaced_function.hpp"

#if TAKT_FASTDDS == 2
#include <fastdds/rtps/history/History.h>
#define FORGET TAKT_DDS "6detail17DataReaderHistory16writer_not_aliveERKNS_8fastrtps4rtps6GUID_tE"
#else
#include <fastdds/rtps/history/History.hpp>
#define FORGET TAKT_DDS "6detail17DataReaderHistory16writer_not_aliveERKNS0_4rtps6GUID_tE"
#endif

namespace takt::dds {

namespace {

using Forget = void(rtps::History* samples, const rtps::GUID_t& writer);

Forget* original() noexcept {
  static Forget* const found = replaced<Forget>(FORGET);
  return found;
}

}  // namespace

void lock_readers_that_lose_writers() noexcept { static_cast<void>(original()); }

void forget_writer(rtps::History* samples, const rtps::GUID_t& writer) asm(FORGET);

void forget_writer(rtps::History* samples, const rtps::GUID_t& writer) {
  const std::lock_guard lock{*samples->getMutex()};
  original()(samples, writer);
}

}  // namespace takt::dds
