// A cell as plain data: the content of a descriptor. The descriptor room reads the cell from XML, and the
// schedule room decides what runs when.
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

/// The words used in descriptors and in all reports: "thread", "non-real", "stop-device".
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

/// The value that readers of an output get while its module does not execute, or when its samples are too
/// old. The fields given here replace those of the component's own safe value. If the component has none, all
/// other fields are zero.
struct SafeValue {
  std::string name;                   ///< of the port
  std::vector<PropertyValue> fields;  ///< name "torque" or "pose.x", value as in JSON
  Line line{};
};

/// How to recover a module that is in RECOVER.
struct Recovery {
  int attempts = 3;                                      ///< 0 to 1000
  Nanoseconds backoff = std::chrono::milliseconds{100};  ///< before each attempt; 0 to 1 h
  GiveUp then = GiveUp::destruct;
};

/// How to handle a release that was not served in time. Either the module's row was missed, or its run was
/// not finished by its next release.
struct OverrunContract {
  Overrun what = Overrun::skip;
  int limit = 1;  ///< catch_up: the maximum number of releases to make up, newest first; 1 to 1000
};

/// Decides when a run() that exceeds its budget is an error. If neither member is set, every excess is an
/// error.
struct BudgetTolerance {
  std::optional<int> times;     ///< an error if a run takes longer than this many budgets; 1 to 1000
  std::optional<int> in_a_row;  ///< an error after this many consecutive excesses; 1 to 1000
};

/// The lines of a module's elements. An element that is missing has no line.
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

/// A module of a device. Here and below, `line` is the line of the element.
struct Module {
  std::string name;      ///< unique on its device
  std::string filename;  ///< as written; a relative path is searched beside the descriptor, then on the
                         ///< component path
  ModuleType type = ModuleType::thread;
  Operation operation = Operation::periodic;
  std::optional<Nanoseconds> period;    ///< periodic: > 0. non-real thread: optional. Otherwise none.
  std::optional<Nanoseconds> offset;    ///< periodic: first release after T0, from 0 to less than the period
  std::optional<Nanoseconds> deadline;  ///< sporadic: > 0, from the release. Otherwise none.
  Miss miss = Miss::count;              ///< whether a missed deadline is only counted or also an error
  Dispatch dispatch = Dispatch::row;    ///< sporadic: runs after the next row, or as soon as a sample arrives
  std::optional<Nanoseconds> interarrival;  ///< sporadic: > 0, the minimum time between two releases
  int priority = 0;                         ///< the lowest value is the highest priority
  std::string executor;  ///< periodic and sporadic: a name in Device::executors. non-real: empty.
  std::optional<Nanoseconds> budget;  ///< of one run(), > 0
  BudgetTolerance tolerance;
  std::optional<OverrunContract> overrun;  ///< periodic; none: that of its executor
  Recovery recovery;
  bool retain = false;  ///< keeps its saved state on disk; not for a non-real process
  std::vector<PropertyValue> properties;
  std::vector<SafeValue> safe;  ///< for its outputs, at most one for each
  Line line{};
  ModuleLines lines{};
};

struct Executor {
  std::string name = "main";
  std::optional<int> cpu;       ///< none: chosen by the node
  int priority = 80;            ///< SCHED_FIFO, 2 to 98; its sporadic modules run one below
  bool rate_monotonic = false;  ///< derive the priority from the basic period: the shorter, the higher
  Wakeup wakeup = Wakeup::hybrid;
  double spin_share = 0.4;  ///< share of the basic period that a wake-up may spin, at most 100 us; 0 to 0.9
  OverrunContract overrun;  ///< of its modules that have none of their own
  Offsets offsets = Offsets::given;  ///< automatic: Takt chooses the missing offsets to flatten the table
  Timing timing = Timing::direct;    ///< let: inputs as of the release, outputs at the end of the period
  bool own_host = false;  ///< runs in its own real-time process, so that a crash stops nothing else
  Line line{};
};

struct Endpoint {
  std::string device;
  std::string module;
  std::string port;
  /// False if no end was given: the other end is a program outside Takt.
  [[nodiscard]] bool given() const noexcept { return !device.empty(); }
  bool operator==(const Endpoint&) const = default;
};

/// Connects one port to another. With a topic and only one end, it connects a port to programs outside Takt.
struct Connection {
  Endpoint from;
  Endpoint to;
  ConnectionKind kind = ConnectionKind::latest;
  int depth = 1;                                       ///< of a queue
  Reliability reliability = Reliability::best_effort;  ///< the descriptor's default for a queue is reliable
  std::optional<Nanoseconds> deadline;                 ///< a value older than this is stale
  std::optional<Nanoseconds> lifespan;                 ///< a value older than this is not delivered
  Stale stale = Stale::hold;
  std::string topic;          ///< empty: takt/<cell>/<device>/<module>/<port> of the writer
  std::optional<int> domain;  ///< of the topic; none: the cell's domain
  /// A ROS 2 topic: its name begins with kRos2Topics, and its type is a ROS 2 message.
  bool ros2 = false;
  Carries carries = Carries::samples;
  Line line{};
};

/// Connects a client to a service. Endpoint::port is the name of the client or of the service.
struct Service {
  Endpoint client;
  Endpoint server;
  Line line{};
};

/// How the nodes of a cell find each other.
struct Discovery {
  enum class Kind { multicast, peers, server };
  Kind kind = Kind::multicast;
  std::vector<std::string> peers;  ///< for kind peers: IPv4 addresses or host names
  std::string server;              ///< for kind server: "host:port"
  bool serve = false;              ///< not from a descriptor: this participant is the server
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
  std::string file;  ///< the descriptor's path as given, for messages; empty if there is none
  std::vector<Insertion> insertions;  ///< the includes and the uses of templates in it
  int domain = 0;                     ///< DDS domain, 0 to 232
  bool domain_given = false;
  std::vector<Device> devices;
  std::vector<Connection> connections;
  std::vector<Service> services;
  Discovery discovery;
  std::string server_device;  ///< the device whose node starts the discovery server; empty: it runs elsewhere
  bool security_required = false;  ///< a node that runs without DDS Security rejects the cell
  Line line{};

  [[nodiscard]] Texts texts() const { return {file, insertions}; }
};

/// The prefix of Takt's own topics.
inline constexpr const char* kOwnTopics = "takt/";

/// A service or client NAME consists of two ports: NAME/request and NAME/reply.
inline constexpr const char* kRequestPort = "/request";
inline constexpr const char* kReplyPort = "/reply";
/// The number of requests of each client that may wait for a service.
inline constexpr int kServiceDepth = 8;
/// Adds two adjacent connections for each service of a cell: the requests and the replies. Call it once.
void connect_services(Cell& cell);

/// The prefix of ROS 2 topics on DDS (see the ROS 2 design article "Topic and Service name mapping to DDS").
inline constexpr const char* kRos2Topics = "rt/";

/// "robot.servo.setpoint"; leaves out the dots before missing parts.
std::string to_text(const Endpoint& end);
/// The name of a connection's topic on DDS: the topic that the descriptor gives, else
/// takt/<cell>/<device>/<module>/<port> of the writer. For replies the name is that of the reader, so that
/// each client has its own topic.
std::string topic_of(const Cell& cell, const Connection& connection);
/// The module's own overrun contract, else that of its executor.
OverrunContract contract_of(const Device& device, const Module& module);
/// True if a fault of one of the device's modules can stop the whole cell: the <recovery> or the overrun
/// contract of such a module is stop-cell.
bool stops_cell(const Device& device);
/// For a periodic module, the timing of its executor; all other modules have direct timing.
Timing timing_of(const Device& device, const Module& module);
/// The value that the descriptor sets for a property of a module. Fails if it sets none.
Result<std::string> given_property(const Module& module, const std::string& name);
/// Sets the value of a property of a module; adds the property if the module does not have it yet.
void give_property(Module& module, const std::string& name, const std::string& value);

}  // namespace takt::model
