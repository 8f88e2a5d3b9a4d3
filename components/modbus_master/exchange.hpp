// Exchanges a map's values with a Modbus TCP device, on a separate thread. So a device that is off, that is
// slow or that sends invalid data delays only this thread.
//
// The cyclic body puts its values into `outputs` and gets the device's values from `image`; neither side
// waits.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "../common/latest.hpp"
#include "../common/modbus_groups.hpp"
#include "../common/modbus_map.hpp"

struct _modbus;

namespace modbus {

using Seconds = std::chrono::duration<double>;

struct Settings {
  std::string host;
  int port = 502;
  int unit = 255;      ///< 255: the device itself
  Seconds cycle{};     ///< from one exchange to the next
  Seconds timeout{};   ///< for a connection, and for each answer
  Seconds backoff{};   ///< maximum time between two attempts to connect; begins at 0.1 s and doubles
  Seconds watchdog{};  ///< outputs become safe if the body is silent for this long
};

/// The body's values, indexed like the points of the map.
struct Outputs {
  std::array<double, kMaxPoints> value{};
  std::array<bool, kMaxPoints> known{};  ///< there is a value
};

/// The device's values.
struct Image {
  std::array<double, kMaxPoints> value{};
  std::array<std::uint32_t, kMaxPoints> reads{};  ///< number of reads; unchanged if there is no new value
  bool connected = false;                         ///< the last exchange succeeded completely
  std::int64_t exchanges = 0;                     ///< exchanges that succeeded completely
  std::int64_t failures = 0;                      ///< failed requests and connections
};

class Exchange {
 public:
  /// The thread calls `report` with one line of text for the user: once when a fault begins, once when it
  /// ends.
  Exchange(std::vector<Point> points, Settings settings, std::function<void(const std::string&)> report);

  /// For the body. Real-time.
  Latest<Outputs> outputs;
  Latest<Image> image;

  /// The body of the thread. Returns after end() was called and the safe values are written.
  void work();
  /// Ends the thread and waits for it, at most this long. Call it once, from the body's thread.
  void end(Seconds limit);

 private:
  using Clock = std::chrono::steady_clock;

  void exchange_all();
  bool connect();
  void disconnect();
  void read(const Group& group);
  void write(const Group& group, const Outputs& from);
  void write_run(const Group& group, std::size_t first, std::size_t last, const Outputs& from);
  void write_safe();
  void failed(const std::string& what);
  void check_result(int result, int wanted, const char* doing, const Group& group, std::size_t first,
                    std::size_t last);
  [[nodiscard]] const Outputs& wanted_outputs();

  const std::vector<Point> points_;
  const Settings settings_;
  const std::function<void(const std::string&)> report_;
  const std::vector<Group> reads_;
  const std::vector<Group> writes_;
  Outputs safe_;
  bool any_safe_ = false;

  _modbus* device_ = nullptr;  ///< null if not connected
  Image now_;
  bool ok_ = false;      ///< no fault in the current exchange so far
  bool faulty_ = false;  ///< a fault is present and was reported
  Clock::time_point faulty_since_{};
  Clock::time_point heard_{};  ///< time of the body's last outputs
  bool ever_heard_ = false;
  bool silent_ = false;  ///< the body is silent, and this was reported
  Clock::time_point retry_at_{};
  Seconds retry_after_{};

  std::mutex mutex_;
  std::condition_variable changed_;
  bool end_ = false;
  bool ended_ = false;
};

}  // namespace modbus
