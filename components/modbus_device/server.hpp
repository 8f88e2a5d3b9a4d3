// The device's side of Modbus TCP: a map's tables, served to several masters by a thread of its own.
//
// The cyclic body leaves the inputs in `inputs` and finds what masters wrote in `image`; neither waits.
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

/// What the cell says of the inputs, by the place of the point in the map.
struct Inputs {
  std::array<double, kMaxPoints> value{};
  std::array<bool, kMaxPoints> known{};  ///< there was a value for it
};

/// What masters wrote.
struct Image {
  std::array<double, kMaxPoints> value{};
  std::array<std::uint32_t, kMaxPoints> writes{};  ///< how often; one that stays has no news
  std::int64_t clients = 0;                        ///< that are connected
  std::int64_t requests = 0;                       ///< that were answered, refusals too
};

class Server {
 public:
  using Seconds = std::chrono::duration<double>;
  struct Settings {
    std::string address;  ///< of ours
    int port = 502;
    Seconds watchdog{};  ///< outputs become safe when no master has written for so long; 0: never
  };
  /// `say` is called from the thread, with a line for people.
  Server(std::vector<Point> points, Settings settings, std::function<void(const std::string&)> say);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The body's side. Real-time.
  Latest<Inputs> inputs;
  Latest<Image> image;

  /// Empty, or why nobody can connect.
  std::string listen();
  /// The thread's work, for ever.
  [[noreturn]] void work();
  /// Of that work: the next request of a master is read and answered. False: the master is to be cut off.
  [[nodiscard]] bool serve(int socket);
  /// Of that work: what masters wrote so far is in `image`.
  void publish();

  /// As many masters as are served at once; another is turned away.
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
  const std::function<void(const std::string&)> say_;
  std::unique_ptr<_modbus, void (*)(_modbus*)> context_;
  std::unique_ptr<_modbus_mapping_t, void (*)(_modbus_mapping_t*)> tables_;
  int listener_ = -1;
  std::vector<int> clients_;
  Image now_;
  Clock::time_point written_at_{};
  bool safe_ = true;  ///< nothing was written since the outputs became safe
};

}  // namespace modbus
