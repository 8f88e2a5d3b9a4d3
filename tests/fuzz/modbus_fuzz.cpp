// Parses arbitrary text as a map of Modbus points, and sends arbitrary bytes from a master to a device with
// that map. The parser must accept the map or report all its mistakes. Accepted points must be valid, and
// converting a value to registers and back must not change it. The device must send the master only
// well-formed frames, and must let the master write only outputs.
//
// An input consists of the map, a zero byte, and the bytes that the master sends.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <sys/socket.h>
#include <unistd.h>

#include <takt/core/check.hpp>

#include "components/common/modbus_groups.hpp"
#include "components/common/modbus_map.hpp"
#include "components/modbus_device/server.hpp"

namespace {

using namespace modbus;

bool is_plain(const std::string& text) { return std::none_of(text.begin(), text.end(), detail::is_control); }

void check_value(const Point& point, const std::array<std::uint16_t, 2>& registers) {
  const double value = decode(point.encoding, registers.data());
  std::array<std::uint16_t, 2> again{};
  if (std::isnan(value)) return TAKT_CHECK(!encode(point.encoding, value, again.data()));
  TAKT_CHECK(encode(point.encoding, value, again.data()));
  const double scale = std::abs(point.encoding.scale);
  const double offset = std::abs(point.encoding.offset);
  const bool exact = scale > 1e-200 && scale < 1e200 &&
                     (point.encoding.type == Type::float32 ? offset == 0 : offset <= 1e6 * scale);
  if (exact && std::isfinite(value)) TAKT_CHECK(decode(point.encoding, again.data()) == value);
}

void check_groups(const std::vector<Point>& points, bool out, Limits limits) {
  std::set<std::size_t> grouped;
  for (const Group& group : groups_of(points, out, limits)) {
    TAKT_CHECK(group.count > 0 && group.count <= (is_bit(group.table) ? limits.bits : limits.registers));
    TAKT_CHECK(group.address + group.count <= 65536);
    for (const std::size_t i : group.points) {
      TAKT_CHECK(grouped.insert(i).second);
      TAKT_CHECK(points.at(i).out == out && points[i].table == group.table);
      TAKT_CHECK(points[i].address >= group.address && points[i].end() <= group.address + group.count);
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) TAKT_CHECK(grouped.contains(i) == (points[i].out == out));
}

void check_points(const std::vector<Point>& points) {
  TAKT_CHECK(!points.empty() && points.size() <= kMaxPoints);
  std::set<std::string> names;
  for (const Point& point : points) {
    TAKT_CHECK(names.insert(point.name).second && point.name.size() <= 63);
    TAKT_CHECK(point.end() <= 65536 && point.width() >= 1);
    TAKT_CHECK(!point.out || point.table == Table::coil || point.table == Table::holding);
    TAKT_CHECK(is_plain(point.unit));
    TAKT_CHECK(std::isfinite(point.encoding.scale) && point.encoding.scale != 0);
    TAKT_CHECK(std::isfinite(point.encoding.offset));
    if (is_bit(point.table)) continue;
    for (const unsigned word : {0x0000U, 0x0001U, 0x7fffU, 0x8000U, 0xc0deU, 0xffffU})
      check_value(point, {static_cast<std::uint16_t>(word), 0x1234});
    if (!point.safe) continue;
    std::array<std::uint16_t, 2> registers{};
    TAKT_CHECK(point.out && encode(point.encoding, *point.safe, registers.data()));
  }
  check_groups(points, true, kWriteLimits);
  check_groups(points, false, kReadLimits);
}

/// Checks that the device has sent the master only complete frames.
void check_answers(std::string_view bytes) {
  while (!bytes.empty()) {
    TAKT_CHECK(bytes.size() >= 9 && bytes[2] == 0 && bytes[3] == 0);
    const std::size_t length =
        std::size_t{static_cast<std::uint8_t>(bytes[4])} << 8U | static_cast<std::uint8_t>(bytes[5]);
    TAKT_CHECK(length >= 3 && length <= 254 && bytes.size() >= 6 + length);
    bytes.remove_prefix(6 + length);
  }
}

void play_master(const std::vector<Point>& points, std::string_view bytes) {
  constexpr std::size_t kMost = 4096;
  std::array<int, 2> ends{};
  TAKT_CHECK(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0);
  bytes = bytes.substr(0, kMost);
  TAKT_CHECK(::send(ends[0], bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  TAKT_CHECK(::shutdown(ends[0], SHUT_WR) == 0);

  Server server{points, {.address = "127.0.0.1", .port = 1502}, [](const std::string&) {}};
  std::size_t requests = 0;
  while (server.serve(ends[1])) ++requests;
  TAKT_CHECK(requests <= bytes.size() / 8);
  server.publish();
  TAKT_CHECK(server.image.take());
  const Image& image = server.image.taken();
  TAKT_CHECK(image.requests == static_cast<std::int64_t>(requests));
  for (std::size_t i = 0; i < kMaxPoints; ++i) {
    TAKT_CHECK(std::isfinite(image.value[i]));
    TAKT_CHECK(image.writes[i] == 0 || (i < points.size() && points[i].out));
  }
  ::close(ends[1]);
  std::string answers(std::size_t{1} << 20U, '\0');
  const ssize_t got = ::recv(ends[0], answers.data(), answers.size(), MSG_WAITALL);
  ::close(ends[0]);
  check_answers({answers.data(), got < 0 ? 0 : static_cast<std::size_t>(got)});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input{reinterpret_cast<const char*>(data), size};
  const std::string_view text = input.substr(0, input.find('\0'));
  const Map map = parse_map(text);
  TAKT_CHECK(map.mistakes.size() <= kMostMistakes);
  for (const Mistake& mistake : map.mistakes) {
    TAKT_CHECK(mistake.line >= 1 && is_plain(mistake.what) && is_plain(mistake.fix));
    TAKT_CHECK(!mistake.what.empty() && mistake.what.size() < 500 && !mistake.fix.empty());
  }
  if (!map.mistakes.empty()) return 0;
  check_points(map.points);
  if (text.size() < input.size()) play_master(map.points, input.substr(text.size() + 1));
  return 0;
}
