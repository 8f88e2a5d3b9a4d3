// The headers of Fast DDS that several files of this room include, and names for what other versions of Fast
// DDS call otherwise or answer otherwise. Only the source files of this room include this header.
#pragma once

#include <chrono>
#include <cstdint>

#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <takt/core/time.hpp>

namespace takt::dds {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Duration = eprosima::fastrtps::Duration_t;
using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;

inline Duration duration(Nanoseconds time) {
  const auto ns = time.count();
  return {static_cast<std::int32_t>(ns / 1'000'000'000), static_cast<std::uint32_t>(ns % 1'000'000'000)};
}

/// Returns false if DDS rejects the sample. Fast DDS takes a non-const pointer, but does not write through
/// it.
inline bool write_sample(fast::DataWriter& writer, const void* sample, rtps::WriteParams parameters = {}) {
  return writer.write(const_cast<void*>(sample), parameters);
}

/// Returns false if there is no further sample.
inline bool take_sample(fast::DataReader& reader, void* sample, fast::SampleInfo& info) {
  return reader.take_next_sample(sample, &info) == ReturnCode::RETCODE_OK;
}

/// Waits until all readers have acknowledged all samples. Returns false if that takes longer than `limit`.
inline bool wait_for_readers(fast::DataWriter& writer, Nanoseconds limit) {
  return writer.wait_for_acknowledgments(duration(limit)) == ReturnCode::RETCODE_OK;
}

/// Sets the period in which the writer sends heartbeats, instead of 3 s. A heartbeat asks readers to
/// acknowledge samples, and is how they notice that they miss one. The writer answers a request after 1 ms
/// instead of 5 ms.
inline void set_times(fast::DataWriterQos& qos, Nanoseconds heartbeat) {
  qos.reliable_writer_qos().times.heartbeatPeriod = duration(heartbeat);
  qos.reliable_writer_qos().times.nackResponseDelay = duration(std::chrono::milliseconds{1});
}

/// Sets after which time the reader answers a heartbeat, instead of 5 ms. It asks a new writer for samples
/// after 10 ms instead of 70 ms.
inline void set_times(fast::DataReaderQos& qos, Nanoseconds answer) {
  qos.reliable_reader_qos().times.heartbeatResponseDelay = duration(answer);
  qos.reliable_reader_qos().times.initialAcknackDelay = duration(std::chrono::milliseconds{10});
}

}  // namespace takt::dds
