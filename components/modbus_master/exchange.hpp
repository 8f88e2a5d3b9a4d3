// The exchange of a map's values with a Modbus TCP device, on a thread of its own: a device that is off, slow
// or talks nonsense costs this thread its time and nobody else's.
//
// The cyclic body leaves what it has to say in `outputs` and finds what the device said in `image`; neither
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
  Seconds backoff{};   ///< between two attempts to connect, at most; it begins with a tenth of a second and
                       ///< doubles
  Seconds watchdog{};  ///< outputs become safe when the body has not said anything for so long
};

/// What the body has to say, by the place of the point in the map.
struct Outputs {
  std::array<double, kMaxPoints> value{};
  std::array<bool, kMaxPoints> known{};  ///< there was a value for it
};

/// What the device said.
struct Image {
  std::array<double, kMaxPoints> value{};
  std::array<std::uint32_t, kMaxPoints> reads{};  ///< how often it was read; one that stays has no news
  bool connected = false;                         ///< the last exchange went well as a whole
  std::int64_t exchanges = 0;                     ///< that went well as a whole
  std::int64_t failures = 0;                      ///< requests and connections that did not
};

class Exchange {
 public:
  /// `say` is called from the thread, with a line for people: once when something is wrong, once when it is
  /// well again.
  Exchange(std::vector<Point> points, Settings settings, std::function<void(const std::string&)> say);

  /// The body's side. Real-time.
  Latest<Outputs> outputs;
  Latest<Image> image;

  /// The thread's work, until end() is called; its last is to make the outputs safe.
  void work();
  /// Waits for the thread's end, but not longer than this. From the thread that is the body, once.
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
  void asked(int result, int wanted, const char* doing, const Group& group, std::size_t first,
             std::size_t last);
  [[nodiscard]] const Outputs& wanted_outputs();

  const std::vector<Point> points_;
  const Settings settings_;
  const std::function<void(const std::string&)> say_;
  const std::vector<Group> reads_;
  const std::vector<Group> writes_;
  Outputs safe_;
  bool any_safe_ = false;

  _modbus* device_ = nullptr;  ///< connected
  Image now_;
  bool well_ = false;  ///< of the exchange that is being made
  bool bad_ = false;   ///< and it was said
  Clock::time_point bad_since_{};
  Clock::time_point heard_{};  ///< of the body
  bool ever_heard_ = false;
  bool silent_ = false;  ///< the body is; and it was said
  Clock::time_point retry_at_{};
  Seconds retry_after_{};

  std::mutex mutex_;
  std::condition_variable changed_;
  bool end_ = false;
  bool ended_ = false;
};

}  // namespace modbus
