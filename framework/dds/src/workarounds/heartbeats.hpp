// Lets a thread choose which readers answer the heartbeats that it sends. Only the source files of this room
// include this header.
//
// Fast DDS 2.9.1 adds a heartbeat to each sample if readers have not acknowledged the previous one, and all
// readers answer it. With 32 devices, each of which publishes its status ten times a second, that would be
// 10,000 packets a second. The protocol has a flag, with which a reader answers only if it misses a sample
// (RTPS 2.5, 8.3.8.6), but Fast DDS has no setting for it.
#pragma once

namespace takt::dds {

enum class Answers {
  as_usual,              ///< Fast DDS decides
  if_sample_is_missing,  ///< a reader answers only if it misses a sample
  always                 ///< all readers answer, also to a heartbeat that shows that a writer is alive
};

/// While this object exists, the heartbeats that this thread sends ask for these answers.
class HeartbeatsAsk {
 public:
  explicit HeartbeatsAsk(Answers answers) noexcept;
  ~HeartbeatsAsk();
  HeartbeatsAsk(const HeartbeatsAsk&) = delete;
  HeartbeatsAsk& operator=(const HeartbeatsAsk&) = delete;

 private:
  Answers outer_;
};

/// Finds the function of Fast DDS that heartbeats.cpp replaces; ends the process if it is missing. Call this
/// function before the participant of this process is created.
void prepare_heartbeats() noexcept;

}  // namespace takt::dds
