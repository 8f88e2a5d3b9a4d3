#include "announced_once.hpp"

#include <algorithm>
#include <chrono>

#include <fastdds/rtps/writer/StatelessWriter.h>
#include <fastdds/rtps/writer/LocatorSelectorSender.hpp>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;
using Limit = std::chrono::steady_clock::time_point;
using Send = bool(const rtps::StatelessWriter*, rtps::CDRMessage_t*, const rtps::LocatorSelectorSender&,
                  Limit&);

Send* original() noexcept {
  static Send* const found = takt::dds::replaced<Send>(
      "_ZNK8eprosima8fastrtps4rtps15StatelessWriter8send_ntsEPNS1_12CDRMessage_tERKNS1_"
      "21LocatorSelectorSenderERNSt6chrono10time_pointINS8_3_V212steady_clockENS8_8durationIlSt5ratioILl1E"
      "Ll1000000000EEEEEE");
  return found;
}

}  // namespace

namespace takt::dds {

void announce_once() noexcept { static_cast<void>(original()); }

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

bool StatelessWriter::send_nts(CDRMessage_t* message, const LocatorSelectorSender& receivers,
                               Limit& limit) const {
  const LocatorSelector& known = receivers.locator_selector;
  const bool reaches_all =
      std::all_of(fixed_locators_.begin(), fixed_locators_.end(), [&known](const Locator_t& each) {
        for (auto at = known.begin(); at != known.end(); ++at) {
          if (*at == each) return true;
        }
        return false;
      });
  return reaches_all ? RTPSWriter::send_nts(message, receivers, limit)
                     : original()(this, message, receivers, limit);
}

}  // namespace eprosima::fastrtps::rtps
