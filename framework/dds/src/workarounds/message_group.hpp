// What the files in this folder read of a message that Fast DDS composes.
#pragma once

#include "../fast_dds.hpp"
#if TAKT_FASTDDS == 2
#include <fastdds/rtps/Endpoint.h>
#include <fastdds/rtps/messages/RTPSMessageSenderInterface.hpp>
#else
#include <fastdds/rtps/Endpoint.hpp>
#include <fastdds/rtps/messages/RTPSMessageSenderInterface.hpp>
#endif

namespace takt::dds {

/// The first members of Fast DDS's class RTPSMessageGroup.
struct MessageGroup {
  rtps::RTPSMessageSenderInterface* receivers;
  rtps::Endpoint* from;
};

inline const MessageGroup& message_group(const void* group) {
  return *static_cast<const MessageGroup*>(group);
}

}  // namespace takt::dds
