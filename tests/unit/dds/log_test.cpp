#include "log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <future>
#include <string>
#include <utility>

#include <fastdds/dds/log/Log.hpp>

#include <long_enough.hpp>

namespace takt::dds::log_test {
namespace {

namespace fast = eprosima::fastdds::dds;

/// Replaces standard error by a pipe that is full, until this object is destroyed.
class FullStandardError {
 public:
  FullStandardError() : before_(::dup(STDERR_FILENO)) {
    EXPECT_EQ(::pipe(ends_.data()), 0);
    ::fcntl(ends_[1], F_SETFL, O_NONBLOCK);
    while (::write(ends_[1], "x", 1) == 1) {
    }
    ::fcntl(ends_[1], F_SETFL, 0);
    ::dup2(ends_[1], STDERR_FILENO);
  }
  FullStandardError(const FullStandardError&) = delete;
  FullStandardError& operator=(const FullStandardError&) = delete;
  ~FullStandardError() {
    ::dup2(before_, STDERR_FILENO);
    for (const int fd : {before_, ends_[0], ends_[1]}) ::close(fd);
  }
  void empty() const {
    ::fcntl(ends_[0], F_SETFL, O_NONBLOCK);
    std::array<char, 4096> part{};
    while (::read(ends_[0], part.data(), part.size()) > 0) {
    }
  }

 private:
  int before_;
  std::array<int, 2> ends_{};
};

TEST(LogOfFastDds, HandlesItsMessagesWhileNothingReadsStandardError) {
  const FullStandardError pipe;
  log_to_standard_error();
  fast::Log::QueueLog("nobody reads this", {__FILE__, __LINE__, __func__, "TEST"}, fast::Log::Kind::Error);
  auto handled = std::async(std::launch::async, [] { fast::Log::Flush(); });
  EXPECT_EQ(handled.wait_for(long_enough()), std::future_status::ready)
      << "the log thread of Fast DDS waits for a reader";
  pipe.empty();
  handled.get();
  fast::Log::Reset();
}

}  // namespace
}  // namespace takt::dds::log_test
