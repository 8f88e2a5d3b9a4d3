// What a page of a cell is told and may ask, apart from how it travels.
//
// Everything that is shown comes from the topics on which nodes speak anyway; devices are asked only for what
// somebody looks at (the ports, properties and tables of one module or device), and that by the node, never
// by a real-time thread.
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

#include <takt/client/connection.hpp>
#include <takt/client/history.hpp>
#include <takt/client/log.hpp>

#include "web/metrics.hpp"
#include "web/questions.hpp"
#include "web/said.hpp"
#include "web/stream.hpp"
#include "web/watched_ports.hpp"

namespace takt::tool::web {

/// Any thread.
class Gateway {
 public:
  static Result<std::unique_ptr<Gateway>> create(const client::Network& network);
  ~Gateway();

  /// A stream that has been told everything as it is. None where there are too many.
  std::shared_ptr<Stream> open();
  void close(const std::shared_ptr<Stream>& stream) { streams_.close(stream); }
  /// Ends every stream, and opens no other.
  void end_streams() { streams_.end(); }

  Questions& questions() noexcept { return *questions_; }
  Answer table(const std::string& device) { return questions_->table(device, cell()); }
  Answer properties(const std::string& module) { return questions_->properties(module, cell()); }
  Answer watch(const std::string& stream, const std::string& body);

  Answer history(const std::string& module);
  std::string metrics();
  [[nodiscard]] int domain() const noexcept { return client_.domain; }

 private:
  struct News;
  explicit Gateway(std::unique_ptr<News> news) noexcept;

  void tell();  // the thread that tells
  void ask();   // the thread that asks
  void tell_states(std::vector<LifecycleStatus> steps);
  void tell_measures();
  void look_for_cell();
  [[nodiscard]] bool is_lost() const;  // the cell that is shown
  void follow_faults();
  void read_records();
  void add_faults(const std::vector<model::Fault>& faults, const Problems& problems);
  void add_record(const client::Log& read);
  void keep_problems(const Problems& problems);
  [[nodiscard]] std::string all_faults() const;
  [[nodiscard]] std::shared_ptr<const model::Cell> cell() const;

  std::unique_ptr<News> news_;  // before the client, whose threads give it
  client::Connection client_;
  Streams streams_;
  std::unique_ptr<Questions> questions_;
  std::unique_ptr<WatchedPorts> watched_;
  std::unique_ptr<client::LogFollower> follower_;

  mutable std::mutex mutex_;             // of what follows
  std::map<std::string, Json> devices_;  // as they were told last
  std::map<std::string, Json> modules_;
  std::string measures_;                     // the last event
  std::shared_ptr<const model::Cell> cell_;  // null: not known
  std::string cell_text_;                    // the event that tells it
  std::string deployment_;                   // that it is of
  std::string descriptor_;                   // that it was read from
  Instant asked_{};                          // for the descriptor
  std::deque<Json> faults_;
  std::deque<std::string> problems_;
  std::set<std::string> recorded_;  // devices whose record was read
  Counted counted_;
  client::History history_;

  std::atomic<bool> ended_{false};
  std::thread telling_;
  std::thread asking_;
};

}  // namespace takt::tool::web
