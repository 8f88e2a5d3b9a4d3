// The device's side of Modbus TCP: a separate thread serves the tables of a map to several masters.
//
// The cyclic body passes the values of its input ports to that thread in `inputs`, and gets the values that
// masters wrote from `image`. Neither the body nor the thread waits for the other.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "../common/latest.hpp"
#include "../common/modbus_map.hpp"

struct _modbus;
struct _modbus_mapping_t;

namespace modbus {

/// Values of the cell's input ports, indexed like the points of the map.
struct Inputs {
  std::array<double, kMaxPoints> value{};
  std::array<bool, kMaxPoints> known{};  ///< whether the port has received a value
};

/// The values that masters wrote.
struct Image {
  std::array<double, kMaxPoints> value{};
  std::array<std::uint32_t, kMaxPoints> writes{};  ///< how often masters have written each point
  std::int64_t clients = 0;                        ///< connected masters
  std::int64_t requests = 0;                       ///< answered requests, including rejected ones
};

class Server {
 public:
  using Seconds = std::chrono::duration<double>;
  struct Settings {
    std::string address;  ///< address to listen on
    int port = 502;
    Seconds watchdog{};  ///< outputs take their safe values if no master writes for this long; 0: never
  };
  /// The server's thread calls `report` with one line of text for the user.
  Server(std::vector<Point> points, Settings settings, std::function<void(const std::string&)> report);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The cyclic body may use `inputs` and `image`; both are real-time capable.
  Latest<Inputs> inputs;
  Latest<Image> image;

  /// Starts to listen. Returns an empty string, or the reason if this fails.
  std::string listen();
  /// Serves the masters in the calling thread; never returns.
  [[noreturn]] void work();
  /// Used by work(): reads and answers the next request of a master. Returns false if work() must disconnect
  /// the master.
  [[nodiscard]] bool serve(int socket);
  /// Used by work(): copies all writes so far to `image`.
  void publish();

  /// Maximum number of connected masters; the server rejects further connections.
  static constexpr std::size_t kMaxClients = 16;

 private:
  using Clock = std::chrono::steady_clock;

  void accept_client();
  void take_inputs();
  void written(Table table, unsigned address, unsigned count);
  void note_writes(const std::uint8_t* request, int length);
  void watch_masters();
  [[nodiscard]] bool put(const Point& point, double value);

  const std::vector<Point> points_;
  const Settings settings_;
  const std::function<void(const std::string&)> report_;
  std::unique_ptr<_modbus, void (*)(_modbus*)> context_;
  std::unique_ptr<_modbus_mapping_t, void (*)(_modbus_mapping_t*)> tables_;
  int listener_ = -1;
  std::vector<int> clients_;
  Image now_;
  Clock::time_point written_at_{};
  bool safe_ = true;  ///< true: no master has written since the outputs took their safe values
};

}  // namespace modbus
