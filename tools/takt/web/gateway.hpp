// Collects the data of a cell for web pages, and forwards the requests of web pages to the cell. This code
// does not depend on HTTP.
//
// Most of what a page shows comes from topics that the nodes publish anyway. The gateway requests other data
// only while a page shows them: the ports, properties and tables of one module or device. The node answers
// these requests without the help of real-time threads.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <takt/client/alarms.hpp>
#include <takt/client/connection.hpp>
#include <takt/client/history.hpp>
#include <takt/client/log.hpp>

#include "web/device_requests.hpp"
#include "web/metrics.hpp"
#include "web/recent_faults.hpp"
#include "web/samples_json.hpp"
#include "web/stream.hpp"
#include "web/watched_ports.hpp"

namespace takt::tool::web {

/// The source of all data for web pages. Any thread may call its functions.
class Gateway {
 public:
  static Result<std::unique_ptr<Gateway>> create(const client::Network& network);
  ~Gateway();

  /// Opens a stream for a new page and sends the complete current state to it. Null if there are too many
  /// streams.
  std::shared_ptr<Stream> open(const std::string& address);
  void close(const std::shared_ptr<Stream>& stream) { streams_.close(stream); }
  /// Ends all streams; open() then opens no more.
  void end_streams() { streams_.end(); }

  DeviceRequests& device_requests() noexcept { return *device_requests_; }
  Answer table(const std::string& device) { return device_requests_->table(device, cell()); }
  Answer properties(const std::string& module) { return device_requests_->properties(module); }
  Answer watch(const std::string& stream, const std::string& body);

  /// The graph of the cell, in which the devices in a list of names with commas between them are collapsed.
  [[nodiscard]] Answer graph(const std::string& collapsed) const;
  /// The fault events before the one with this number, see RecentFaults::before().
  [[nodiscard]] Answer faults(const std::string& before) const;
  Answer history(const std::string& module);
  std::string metrics();
  [[nodiscard]] int domain() const noexcept { return client_.domain; }

 private:
  struct News;
  explicit Gateway(std::unique_ptr<News> news) noexcept;

  void run_sender();   // on the thread that sends to the pages
  void run_fetcher();  // on the thread that asks devices
  void send_states(std::vector<LifecycleStatus> steps);
  void send_measures();
  void look_for_cell();
  [[nodiscard]] bool is_lost() const;  // true if all devices of the shown cell are lost
  void follow_faults();
  void read_records();
  void read_alarms();
  void add_faults(const std::vector<model::Fault>& faults, const Problems& problems);
  void add_record(const client::Log& read);
  void keep_problems(const Problems& problems);
  [[nodiscard]] std::string newest_faults() const;
  [[nodiscard]] std::string all_alarms() const;
  [[nodiscard]] std::shared_ptr<const model::Cell> cell() const;

  std::unique_ptr<News> news_;  // declared before the client, whose threads use it
  client::Connection client_;
  Streams streams_;
  std::unique_ptr<DeviceRequests> device_requests_;
  std::unique_ptr<WatchedPorts> watched_;
  std::unique_ptr<client::LogFollower> follower_;

  mutable std::mutex mutex_;             // protects the members below
  std::map<std::string, Json> devices_;  // devices_ and modules_: the state that was last sent
  std::map<std::string, Json> modules_;
  std::string measures_;                     // the text of the last `measures` event
  std::shared_ptr<const model::Cell> cell_;  // the running cell; null if none is known
  std::string cell_text_;                    // the text of the last `cell` event
  std::string deployment_;                   // the name of the deployment of cell_
  std::string descriptor_;                   // the descriptor of cell_
  Instant asked_{};                          // when the gateway last got the descriptor
  RecentFaults faults_;
  std::deque<std::string> problems_;
  std::set<std::string> recorded_;  // the devices whose fault record was read
  Counted counted_;
  struct OfDevice {
    std::string node;
    std::uint64_t changes = 0;
    std::vector<model::Alarm> alarms{};
    bool operator==(const OfDevice&) const = default;
  };
  std::map<std::string, OfDevice> alarms_;  // the alarms of each device
  client::History history_;

  std::atomic<bool> ended_{false};
  std::thread sender_;
  std::thread fetcher_;
};

}  // namespace takt::tool::web
