// A cell as plain data: the content of a descriptor. `descriptor` reads a cell from XML, and `schedule`
// decides when its modules run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/line.hpp>

namespace takt::model {

enum class ModuleType { thread, process };
enum class Operation { periodic, sporadic, non_real };
enum class Wakeup { sleep, hybrid, spin };
enum class GiveUp { destruct, stop_device, stop_cell };
enum class ConnectionKind { latest, queue };
enum class Stale { hold, error };
enum class Reliability { best_effort, reliable };
enum class Dispatch { row, immediate };
enum class Miss { count, error };
enum class Overrun { skip, catch_up, error, stop_device, stop_cell };
enum class Offsets { given, automatic };
enum class Timing { direct, let };
enum class Carries { samples, requests, replies };

/// Each value as it is written in descriptors and reports, for example "thread", "non-real" or "stop-device".
const char* to_text(ModuleType type);
const char* to_text(Operation operation);
const char* to_text(Wakeup wakeup);
const char* to_text(GiveUp then);
const char* to_text(ConnectionKind kind);
const char* to_text(Stale stale);
const char* to_text(Reliability reliability);
const char* to_text(Dispatch dispatch);
const char* to_text(Miss miss);
const char* to_text(Overrun overrun);
const char* to_text(Offsets offsets);
const char* to_text(Timing timing);
const char* to_text(Carries carries);

struct PropertyValue {
  std::string name;
  std::string value;
  Line line{};
};

/// The value that readers of an output receive while the output's module does not execute, or when its
/// samples are too old. The fields given here replace fields of the safe value that the component defines. If
/// the component defines none, all other fields are zero.
struct SafeValue {
  std::string name;                   ///< name of the port
  std::vector<PropertyValue> fields;  ///< name as in "torque" or "pose.x", value as in JSON
  Line line{};
};

/// How Takt recovers a module that is in RECOVER.
struct Recovery {
  int attempts = 3;                                      ///< maximum number of attempts; 0 to 1000
  Nanoseconds backoff = std::chrono::milliseconds{100};  ///< wait before each attempt; 0 to 1 h
  GiveUp then = GiveUp::destruct;
};

/// What to do about a release that was not served in time: either its row was missed, or the module's
/// previous run had not finished yet.
struct OverrunContract {
  Overrun what = Overrun::skip;
  int limit = 1;  ///< for catch_up: how many missed releases may be made up, newest first; 1 to 1000
};

/// Decides when a run() that exceeds its budget is an error. If neither member is set, every run over budget
/// is an error.
struct BudgetTolerance {
  std::optional<int> times;     ///< a run is an error if it takes longer than this many budgets; 1 to 1000
  std::optional<int> in_a_row;  ///< this many consecutive runs over budget are an error; 1 to 1000
};

/// The source lines of a module's elements. A missing element has no line.
struct ModuleLines {
  Line name{};
  Line filename{};
  Line period{};
  Line deadline{};
  Line executor{};
  Line budget{};
  Line offset{};
  Line overrun{};
  Line dispatch{};
  Line interarrival{};
  Line retain{};
};

/// A module of a device. Here and in the structs below, `line` is the source line of the element.
struct Module {
  std::string name;      ///< unique on the module's device
  std::string filename;  ///< as written in the descriptor; Takt searches for a relative path beside the
                         ///< descriptor, then on the component path
  ModuleType type = ModuleType::thread;
  Operation operation = Operation::periodic;
  std::optional<Nanoseconds> period;    ///< periodic module: > 0. non-real thread module: optional. Other
                                        ///< modules: none.
  std::optional<Nanoseconds> offset;    ///< periodic module: time of its first release after T0; at least 0,
                                        ///< less than the period
  std::optional<Nanoseconds> deadline;  ///< sporadic module: time from its release, > 0. Other modules: none.
  Miss miss = Miss::count;              ///< whether a missed deadline is only counted, or is also an error
  Dispatch dispatch = Dispatch::row;  ///< sporadic module: whether it runs after the next row, or as soon as
                                      ///< a sample arrives
  std::optional<Nanoseconds> interarrival;  ///< sporadic module: the minimum time between two releases, > 0
  int priority = 0;                         ///< the lowest number is the highest priority
  std::string executor;  ///< periodic or sporadic module: a name in Device::executors. non-real module:
                         ///< empty.
  std::optional<Nanoseconds> budget;  ///< budget of one run(), > 0
  BudgetTolerance tolerance;
  std::optional<OverrunContract> overrun;  ///< periodic module; none: its executor's contract applies
  Recovery recovery;
  bool retain = false;  ///< saves the module's state on disk; not for a non-real process
  std::vector<PropertyValue> properties;
  std::vector<SafeValue> safe;  ///< the safe values of its outputs, at most one for each
  Line line{};
  ModuleLines lines{};
};

struct Executor {
  std::string name = "main";
  std::optional<int> cpu;       ///< none: the node chooses the CPU
  int priority = 80;            ///< priority for SCHED_FIFO, 2 to 98; sporadic modules run one priority lower
  bool rate_monotonic = false;  ///< derive the priority from the basic period: a shorter period gives a
                                ///< higher priority
  Wakeup wakeup = Wakeup::hybrid;
  double spin_share = 0.4;  ///< share of the basic period for which a wake-up may spin, 0 to 0.9; at most 100
                            ///< us in any case
  OverrunContract overrun;  ///< applies to its modules without a contract of their own
  Offsets offsets = Offsets::given;  ///< automatic: Takt chooses the offsets that are not given, to spread
                                     ///< the load over the rows
  Timing timing = Timing::direct;    ///< let (logical execution time): inputs are read as of the release,
                                     ///< outputs become visible at the end of the period
  bool own_host = false;  ///< whether the executor runs in its own real-time process, so that a crash of its
                          ///< modules stops no other executor
  Line line{};
};

struct Endpoint {
  std::string device;
  std::string module;
  std::string port;
  /// False if the descriptor gives no end: the other side is then a program outside Takt.
  [[nodiscard]] bool given() const noexcept { return !device.empty(); }
  bool operator==(const Endpoint&) const = default;
};

/// Connects one port to another. A connection with a topic and only one end connects a port to programs
/// outside Takt.
struct Connection {
  Endpoint from;
  Endpoint to;
  ConnectionKind kind = ConnectionKind::latest;
  int depth = 1;                                       ///< maximum number of samples in a queue
  Reliability reliability = Reliability::best_effort;  ///< in a descriptor, a queue is reliable by default
  std::optional<Nanoseconds> deadline;                 ///< a value older than this is stale
  std::optional<Nanoseconds> lifespan;                 ///< a value older than this is not delivered
  Stale stale = Stale::hold;
  std::string topic;          ///< empty: the default name, takt/<cell>/<device>/<module>/<port> of the writer
  std::optional<int> domain;  ///< DDS domain of the topic; none: the cell's domain
  /// True for a ROS 2 topic: its name begins with kRos2Topics, and its type is a ROS 2 message.
  bool ros2 = false;
  Carries carries = Carries::samples;
  Line line{};
};

/// Connects a client to a service. `Endpoint::port` holds the name of the client or service.
struct Service {
  Endpoint client;
  Endpoint server;
  Line line{};
};

/// How the nodes of a cell find each other.
struct Discovery {
  enum class Kind { multicast, peers, server };
  Kind kind = Kind::multicast;
  std::vector<std::string> peers;  ///< for Kind::peers: IPv4 addresses or host names
  std::string server;              ///< for Kind::server: "host:port"
  bool serve = false;  ///< true if this participant is the discovery server; not part of a descriptor
};
const char* to_text(Discovery::Kind kind);

struct Device {
  std::string name;
  std::vector<Executor> executors;  ///< never empty
  std::vector<Module> modules;
  Line line{};
};

struct Cell {
  std::string name;
  std::string file;  ///< the path of the descriptor as the user gave it, for messages; empty if there is none
  std::vector<Insertion> insertions;  ///< the includes and template uses in the descriptor
  int domain = 0;                     ///< DDS domain, 0 to 232
  bool domain_given = false;
  std::vector<Device> devices;
  std::vector<Connection> connections;
  std::vector<Service> services;
  Discovery discovery;
  std::string server_device;  ///< the device whose node starts the discovery server; empty: the server runs
                              ///< elsewhere
  bool security_required = false;  ///< if true, a node without DDS Security rejects the cell
  Line line{};

  [[nodiscard]] Texts texts() const { return {file, insertions}; }
};

/// The prefix of topics that are reserved for Takt.
inline constexpr const char* kOwnTopics = "takt/";

/// A service or client called NAME consists of two ports: NAME/request and NAME/reply.
inline constexpr const char* kRequestPort = "/request";
inline constexpr const char* kReplyPort = "/reply";
/// For each client of a service, at most this many requests may wait.
inline constexpr int kServiceDepth = 8;
/// Adds two adjacent connections for each service of a cell: one for the requests and one for the replies.
/// Call this only once.
void connect_services(Cell& cell);

/// The prefix that ROS 2 topics have on DDS (see the ROS 2 design article "Topic and Service name mapping to
/// DDS").
inline constexpr const char* kRos2Topics = "rt/";

/// The endpoint as text, for example "robot.servo.setpoint". Missing parts are omitted together with their
/// dots.
std::string to_text(const Endpoint& end);
/// The name of a connection's topic on DDS: the topic that the descriptor gives, otherwise
/// takt/<cell>/<device>/<module>/<port> of the writer. A connection for replies uses the reader's names
/// instead, so that each client has its own topic.
std::string topic_of(const Cell& cell, const Connection& connection);
/// The module's own overrun contract if it has one, otherwise the contract of its executor.
OverrunContract contract_of(const Device& device, const Module& module);
/// Returns true if a fault of one of the device's modules can stop the whole cell, because the <recovery> or
/// the overrun contract of the module is stop-cell.
bool stops_cell(const Device& device);
/// The timing of a periodic module is that of its executor; all other modules have direct timing.
Timing timing_of(const Device& device, const Module& module);
/// The value that the descriptor sets for a property of a module. Fails if the descriptor does not set the
/// property.
Result<std::string> given_property(const Module& module, const std::string& name);
/// Sets the value of a module's property; adds the property if the module does not have it yet.
void give_property(Module& module, const std::string& name, const std::string& value);

}  // namespace takt::model
