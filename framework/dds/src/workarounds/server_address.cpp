#include "server_address.hpp"

#include <algorithm>
#include <utility>

#include <fastdds/rtps/builtin/data/ParticipantProxyData.h>
#include "../fast_dds.hpp"
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

using Read = bool(rtps::ParticipantProxyData*, rtps::CDRMessage_t*, bool, const rtps::NetworkFactory&, bool);

Read* original() noexcept {
  static Read* const found = takt::dds::replaced<Read>(
      "_ZN8eprosima8fastrtps4rtps20ParticipantProxyData18readFromCDRMessageEPNS1_12CDRMessage_tEbRKNS1_"
      "14NetworkFactoryEb");
  return found;
}

std::optional<takt::dds::NamedServer> named;

}  // namespace

namespace takt::dds {

void reach_server_at(std::optional<NamedServer> server) {
  static_cast<void>(original());
  named = std::move(server);
}

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

bool ParticipantProxyData::readFromCDRMessage(CDRMessage_t* message, bool has_encapsulation,
                                              const NetworkFactory& network, bool has_shared_memory) {
  if (!original()(this, message, has_encapsulation, network, has_shared_memory)) return false;
  if (named && m_guid.guidPrefix == named->prefix) {
    std::vector<takt::os::Ipv4> addresses;
    for (const Locator_t& each : metatraffic_locators.unicast) {
      if (each.kind == LOCATOR_KIND_UDPv4)
        std::copy_n(IPLocator::getIPv4(each), 4, addresses.emplace_back().begin());
    }
    named->announced(addresses);
    metatraffic_locators.unicast.clear();
    metatraffic_locators.add_unicast_locator(named->locator);
  }
  return true;
}

}  // namespace eprosima::fastrtps::rtps
