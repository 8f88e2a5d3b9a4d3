#include "bare_dds.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <sstream>

#include <takt/dds/gateway.hpp>
#include <takt/dds/participant.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/process.hpp>

#include "bare_loop.hpp"

namespace takt::bench {

namespace {

using namespace std::chrono_literals;

constexpr const char* kSettings =
    "TAKT_BENCH_WRITER";  // environment variable, with the value "DOMAIN PERIOD_NS LENGTH_NS"
constexpr std::size_t kHead =
    4;  // size of the encapsulation header, which precedes the fields of a sample, in bytes
constexpr std::size_t kBytes = kHead + 64;
constexpr Nanoseconds kMatchLimit = 10s;  // time limit for the matching of writer and reader

dds::Flow flow() {
  return {.topic = "rt/takt_bench",
          .type = {.name = "bench::Sample64",
                   .fields = {{.name = "sent_ns", .scalar = model::Scalar::int64},
                              {.name = "values", .scalar = model::Scalar::float64, .dimensions = {7}}}},
          .quality = {.reliable = true, .depth = 8, .deadline = {}, .lifespan = {}}};
}

Result<std::shared_ptr<dds::Participant>> participate(int domain) {
  return dds::Participant::create(
      {.name = "takt-bench", .domain = domain, .discovery = {}, .interfaces = {"127.0.0.1"}});
}

}  // namespace

Result<std::vector<std::int64_t>> run_bare_dds(const BareDds& settings) {
  std::ostringstream words;
  words << settings.domain << ' ' << settings.period.count() << ' ' << settings.length.count();
  auto writer = os::Child::spawn({.program = os::program_directory() + "/takt",
                                  .arguments = {"bench", "writer"},
                                  .environment = {{kSettings, words.str()}}});
  if (!writer) return writer.problems();

  std::mutex mutex;
  std::vector<std::int64_t> ages;
  const auto participant = participate(settings.domain);
  if (!participant) return participant.problems();
  const auto tap =
      dds::Tap::create(*participant, flow(), [&](const std::byte* bytes, std::size_t size, std::int64_t) {
        const std::int64_t now = to_ns(os::now());
        std::int64_t sent = 0;
        if (size < kHead + sizeof sent) return;
        std::memcpy(&sent, bytes + kHead, sizeof sent);
        const std::scoped_lock lock{mutex};
        ages.push_back(now - sent);
      });
  if (!tap) return tap.problems();
  const os::ProcessEnd end = writer->wait();
  if (end.signalled || end.code != 0) return fail("the writer process of the DDS reference " + end.text());
  os::sleep_until(os::now() + 50ms);  // time for the last samples to arrive
  const std::scoped_lock lock{mutex};
  return ages;
}

int serve_as_writer() {
  std::istringstream words{os::take_from_environment(kSettings)};
  int domain = 0;
  std::int64_t period = 0;
  std::int64_t length = 0;
  if (!(words >> domain >> period >> length) || period <= 0) return 1;
  const auto participant = participate(domain);
  if (!participant) return 1;
  const auto feed = dds::Feed::create(*participant, flow());
  if (!feed) return 1;
  for (const Instant limit = os::now() + kMatchLimit; (*feed)->health().matched == 0;) {
    if (os::now() > limit) return 1;
    os::sleep_until(os::now() + 10ms);
  }
  std::array<std::byte, kBytes> bytes{};
  bytes[1] = std::byte{1};  // encapsulation: 1 means CDR in little-endian byte order
  loop_on_grid(Grid::from_now(Nanoseconds{period}, Nanoseconds{length}), sleep_to, [&](Instant) {
    const std::int64_t now = to_ns(os::now());
    std::memcpy(bytes.data() + kHead, &now, sizeof now);
    (*feed)->write(bytes.data(), bytes.size());
  });
  return 0;
}

}  // namespace takt::bench
