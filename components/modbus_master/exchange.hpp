// Exchanges the values of a map with a Modbus TCP device, on a separate thread. So a device that is off, is
// slow or sends invalid data delays only this thread.
//
// The cyclic body passes its values to that thread in `outputs`, and gets the device's values from `image`.
// Neither the body nor the thread waits for the other.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
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
  int unit = 255;      ///< 255: the device itself, without a gateway
  Seconds cycle{};     ///< time from one exchange to the next
  Seconds timeout{};   ///< limit for a connection attempt, and for each answer
  Seconds backoff{};   ///< maximum time between two attempts to connect; the first time is 0.1 s
  Seconds watchdog{};  ///< outputs take their safe values if the body sends no outputs for this long
};

/// Values of the cell's input ports, indexed like the points of the map.
struct Outputs {
  std::array<double, kMaxPoints> value{};
  std::array<bool, kMaxPoints> known{};  ///< whether the port has received a value
};

/// The values that the device sent.
struct Image {
  std::array<double, kMaxPoints> value{};
  std::array<std::uint32_t, kMaxPoints> reads{};  ///< how often each point was read from the device
  bool connected = false;                         ///< whether the last exchange succeeded completely
  std::int64_t exchanges = 0;                     ///< number of exchanges that succeeded completely
  std::int64_t failures = 0;                      ///< number of failed requests and connections
};

class Exchange {
 public:
  /// The exchange thread calls `report` with one line of text for the user when a fault begins, and again
  /// when the fault ends.
  Exchange(std::vector<Point> points, Settings settings, std::function<void(const std::string&)> report);

  /// The cyclic body may use `outputs` and `image`; both are real-time capable.
  Latest<Outputs> outputs;
  Latest<Image> image;

  /// Exchanges values in the calling thread, until end() is called. Then writes the safe values and returns.
  void work();
  /// Makes work() return, and waits until it has written the safe values, at most for `limit`. The body calls
  /// this once.
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

  _modbus* device_ = nullptr;  ///< null while not connected
  Image now_;
  /// For registers and for coils: true if the device knows only the functions that write a single one.
  std::array<bool, 2> singly_{};
  std::set<std::string> rejected_;  ///< the rejected requests that have been reported
  bool ok_ = false;                 ///< true: the current exchange has had no fault so far
  bool faulty_ = false;             ///< true: a fault is present and has been reported
  Clock::time_point faulty_since_{};
  Clock::time_point heard_{};  ///< time of the body's last outputs
  bool ever_heard_ = false;
  bool silent_ = false;  ///< true: the body sends no outputs, and this has been reported
  Clock::time_point retry_at_{};
  Seconds retry_after_{};

  std::mutex mutex_;
  std::condition_variable changed_;
  bool end_ = false;
  bool ended_ = false;
};

}  // namespace modbus
