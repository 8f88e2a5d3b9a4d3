#include <takt/node/log.hpp>

#include <poll.h>
#include <unistd.h>

#include <array>
#include <sstream>
#include <string>

#include <gmock/gmock.h>

#include <long_enough.hpp>
#include <takt/os/fd.hpp>

namespace takt::node::log_test {
namespace {

// Standard error is a pipe while an object of this class exists.
class PipedError {
 public:
  PipedError() : before_(::dup(STDERR_FILENO)) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe(ends.data()), 0);
    reader_ = os::Fd{ends[0]};
    ::dup2(ends[1], STDERR_FILENO);
    ::close(ends[1]);
  }
  ~PipedError() { ::dup2(before_.get(), STDERR_FILENO); }
  PipedError(const PipedError&) = delete;
  PipedError& operator=(const PipedError&) = delete;

  // Reads until the text contains `what`, or nothing more arrives, and returns everything.
  std::string read_until(const std::string& what) {
    std::array<char, 65536> bytes{};
    while (text_.find(what) == std::string::npos) {
      pollfd ready{.fd = reader_.get(), .events = POLLIN, .revents = 0};
      if (::poll(&ready, 1, static_cast<int>(long_enough().count())) <= 0) break;
      const ssize_t got = ::read(reader_.get(), bytes.data(), bytes.size());
      if (got <= 0) break;
      text_.append(bytes.data(), static_cast<std::size_t>(got));
    }
    return text_;
  }

 private:
  os::Fd before_;
  os::Fd reader_;
  std::string text_;
};

TEST(Log, NeverWaitsForAReaderAndCountsTheLinesThatItDropped) {
  constexpr int kLines = 3000;  // together more than a pipe and LogThread hold
  PipedError error;
  LogThread printer;
  printer.start();
  for (int i = 0; i < kLines; ++i)
    log("bench", "servo", "line " + std::to_string(i) + std::string(1000, 'x'));
  const std::string text = error.read_until("nothing read this output\n");
  log("bench", "servo", "the last line");
  EXPECT_THAT(error.read_until("the last line"), testing::HasSubstr("bench.servo: the last line"));

  std::istringstream lines{text};
  int printed = 0;
  int missing = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("lines are missing") != std::string::npos)
      missing = std::stoi(line);
    else if (line.find(" bench.servo: line " + std::to_string(printed) + "x") != std::string::npos)
      ++printed;
  }
  EXPECT_GT(missing, 0);
  EXPECT_EQ(printed + missing, kLines) << "a line was lost, or lines were not in order";
}

TEST(Log, PrintsTheLastLinesBeforeItEnds) {
  PipedError error;
  {
    LogThread printer;
    printer.start();
    for (int i = 0; i < 100; ++i) log("bench", "", std::to_string(i));
  }
  EXPECT_THAT(error.read_until(": 99\n"), testing::HasSubstr("bench: 98\n"));
}

TEST(Log, EndsWithoutAReader) {
  PipedError error;
  LogThread printer;
  printer.start();
  for (int i = 0; i < 3000; ++i) log("bench", "", "a line that nothing reads");
}

}  // namespace
}  // namespace takt::node::log_test
