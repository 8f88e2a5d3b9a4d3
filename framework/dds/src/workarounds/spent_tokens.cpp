#include "spent_tokens.hpp"

#include <atomic>
#include <mutex>

#include <fastdds/rtps/history/WriterHistory.h>
#include <fastdds/rtps/writer/RTPSWriter.h>
#include <fastdds/rtps/writer/WriterListener.h>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

std::atomic<bool> drops{false};

class Spent final : public rtps::WriterListener {
 public:
  void in(rtps::WriterHistory& history) noexcept { history_ = &history; }
  void onWriterChangeReceivedByAll(rtps::RTPSWriter*, rtps::CacheChange_t* change) override {
    history_.load()->remove_change(change);
  }

 private:
  std::atomic<rtps::WriterHistory*> history_{nullptr};
};

Spent spent;

}  // namespace

namespace takt::dds {

void drop_spent_tokens() noexcept { drops = true; }

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// Replaces a function of Fast DDS with a copy that also sets the listener `spent`. Fast DDS sets no listener
// for the writer of tokens, and gives no access to this writer.
bool WriterHistory::add_change(CacheChange_t* change) {
  const EntityId_t tokens{ENTITYID_P2P_BUILTIN_PARTICIPANT_VOLATILE_MESSAGE_SECURE_WRITER};
  if (drops && change->writerGUID.entityId == tokens && mp_writer != nullptr) {
    const std::lock_guard lock{*mp_mutex};
    spent.in(*this);
    mp_writer->set_listener(&spent);
  }
  WriteParams parameters;
  return add_change_(change, parameters);
}

}  // namespace eprosima::fastrtps::rtps
