// Tests that a writer that loses a reader does not wait for the thread that sends samples again.
#include <fastdds/rtps/RTPSDomain.h>
#include <fastdds/rtps/attributes/HistoryAttributes.h>
#include <fastdds/rtps/attributes/RTPSParticipantAttributes.h>
#include <fastdds/rtps/attributes/WriterAttributes.h>
#include <fastdds/rtps/builtin/data/ReaderProxyData.h>
#include <fastdds/rtps/history/WriterHistory.h>
#include <fastdds/rtps/participant/RTPSParticipant.h>
#include <fastdds/rtps/writer/RTPSWriter.h>
#include <fastdds/rtps/writer/WriterListener.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>

#include "domain.hpp"

namespace takt::dds_test::removed_readers_test {
namespace {

namespace rtps = eprosima::fastrtps::rtps;

/// Called when all readers have acknowledged a sample, which a writer may then delete. Finds out whether
/// another thread can use the destinations of the writer meanwhile.
class Listener final : public rtps::WriterListener {
 public:
  void onWriterChangeReceivedByAll(rtps::RTPSWriter* writer, rtps::CacheChange_t*) override {
    other_ = std::async(std::launch::async, [writer] {
      writer->get_async_locator_selector().lock();
      writer->get_async_locator_selector().unlock();
    });
    are_free_ = other_.wait_for(std::chrono::seconds{2}) == std::future_status::ready;
    is_called_ = true;
  }
  [[nodiscard]] bool is_called() const noexcept { return is_called_; }
  [[nodiscard]] bool are_free() const noexcept { return are_free_; }
  void join() { other_.get(); }

 private:
  std::future<void> other_;
  bool is_called_ = false;
  bool are_free_ = false;
};

TEST(RemovedReader, ItsSamplesAreDeletedWhileOtherThreadsCanUseTheDestinations) {
  rtps::RTPSParticipantAttributes attributes;
  attributes.builtin.discovery_config.discoveryProtocol = rtps::DiscoveryProtocol::NONE;
  rtps::RTPSParticipant* const participant =
      rtps::RTPSDomain::createParticipant(static_cast<std::uint32_t>(domain()), attributes);
  ASSERT_NE(participant, nullptr);
  rtps::WriterHistory history{rtps::HistoryAttributes{}};
  rtps::WriterAttributes of_writer;
  of_writer.endpoint.reliabilityKind = rtps::RELIABLE;
  Listener listener;
  rtps::RTPSWriter* const writer =
      rtps::RTPSDomain::createRTPSWriter(participant, of_writer, &history, &listener);
  ASSERT_NE(writer, nullptr);
  rtps::ReaderProxyData reader{1, 1};
  rtps::GUID_t guid = participant->getGuid();
  guid.guidPrefix.value[11] ^= 1;  // of another participant
  guid.entityId = 0x107U;
  reader.guid(guid);
  reader.m_qos.m_reliability.kind = eprosima::fastdds::dds::RELIABLE_RELIABILITY_QOS;
  ASSERT_TRUE(writer->matched_reader_add(reader));
  rtps::CacheChange_t* const sample = writer->new_change([] { return 4U; }, rtps::ALIVE);
  ASSERT_NE(sample, nullptr);
  sample->serializedPayload.length = 4;
  ASSERT_TRUE(history.add_change(sample));
  ASSERT_FALSE(listener.is_called()) << "the reader has not acknowledged the sample";

  EXPECT_TRUE(writer->matched_reader_remove(guid));
  EXPECT_TRUE(listener.is_called());
  EXPECT_TRUE(listener.are_free());
  listener.join();
  rtps::RTPSDomain::removeRTPSWriter(writer);
  rtps::RTPSDomain::removeRTPSParticipant(participant);
}

}  // namespace
}  // namespace takt::dds_test::removed_readers_test
