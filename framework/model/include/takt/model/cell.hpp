// A cell as plain data: the content of a descriptor. The room `descriptor` reads a cell from XML, and the
// room `schedule` decides when its modules run.
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

/// The to_text() functions return a value as it is written in descriptors and reports, for example "thread",
/// "non-real" or "stop-device".
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

/// The safe value of an output, as the descriptor sets it. Readers receive the safe value while the output's
/// module does not execute, or when the samples of the output are too old. The fields given here replace
/// fields of the safe value that the component defines. If the component defines none, all other fields are
/// zero.
struct SafeValue {
  std::string name;  ///< name of the output
  /// Name of the field, as in "torque" or "pose.x", and its value, as in JSON.
  std::vector<PropertyValue> fields;
  Line line{};
};

/// How Takt recovers a module that is in RECOVER.
struct Recovery {
  int attempts = 3;                                      ///< maximum number of attempts; 0 to 1000
  Nanoseconds backoff = std::chrono::milliseconds{100};  ///< time to wait before each attempt; 0 to 1 h
  GiveUp then = GiveUp::destruct;
};

/// What to do if a release of a periodic module was not served in time, because its row was missed or the
/// module's previous run had not ended yet.
struct OverrunContract {
  Overrun what = Overrun::skip;
  int limit = 1;  ///< for catch_up: at most this many of the newest missed releases are made up; 1 to 1000
};

/// Decides when a run() that exceeds its budget is an error. If neither member is set, every run over budget
/// is an error.
struct BudgetTolerance {
  std::optional<int> times;     ///< a run that takes longer than `times` budgets is an error; 1 to 1000
  std::optional<int> in_a_row;  ///< `in_a_row` consecutive runs over budget are an error; 1 to 1000
};

/// The lines of a module's elements in the source texts. An element that the descriptor omits has no line.
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
  Line arguments{};
};

/// A module of a device. Here and in the structs below, `line` is the line of the element in the source
/// texts.
struct Module {
  std::string name;  ///< unique on the module's device
  /// The file as written in the descriptor. Takt searches for a relative path in the folder of the
  /// descriptor, then on the component path.
  std::string filename;
  ModuleType type = ModuleType::thread;
  Operation operation = Operation::periodic;
  /// For a periodic module: > 0. For a non-real thread module: optional. For other modules: none.
  std::optional<Nanoseconds> period;
  /// For a periodic module: the time from T0 to its first release; at least 0, and less than the period.
  std::optional<Nanoseconds> offset;
  /// For a sporadic module: the time from its release to its deadline, > 0. For other modules: none.
  std::optional<Nanoseconds> deadline;
  /// For a sporadic module. count: a missed deadline is only counted. error: it is counted and is an error.
  Miss miss = Miss::count;
  /// For a sporadic module. row: it runs after the next row. immediate: it runs as soon as a sample arrives.
  Dispatch dispatch = Dispatch::row;
  /// For a sporadic module: the minimum time between two releases, > 0.
  std::optional<Nanoseconds> interarrival;
  int priority = 0;  ///< among the modules of its executor; the lowest number is the highest priority
  /// For a periodic or sporadic module: the name of one of Device::executors. For a non-real module: empty.
  std::string executor;
  std::optional<Nanoseconds> budget;  ///< the maximum duration of one run(), > 0; none: no limit
  BudgetTolerance tolerance;
  std::optional<Nanoseconds> hang;  ///< a run() that takes this long hangs; none: see hang_limit()
  /// Only for a periodic module. If it is empty, the contract of the module's executor applies.
  std::optional<OverrunContract> overrun;
  Recovery recovery;
  bool retain = false;  ///< true: the module's state is also saved on disk; not for a non-real process
  /// Arguments of a process module's program. Takt appends the arguments for the module's properties.
  std::vector<std::string> arguments;
  std::vector<PropertyValue> properties;  ///< may contain kLogLevelProperty
  std::vector<SafeValue> safe;            ///< the safe values of its outputs, at most one for each output
  Line line{};
  ModuleLines lines{};
};

struct Executor {
  std::string name = "main";
  std::optional<int> cpu;  ///< the CPU on which the executor runs; none: the node chooses the CPU
  int priority = 80;       ///< priority for SCHED_FIFO, 2 to 98; see schedule/levels.hpp
  /// True: the priority is derived from the basic period, so that a shorter period gives a higher priority.
  bool rate_monotonic = false;
  Wakeup wakeup = Wakeup::hybrid;
  /// The longest time for which the executor's thread spins before a release, as a share (0 to 0.9) of the
  /// basic period. The thread never spins longer than 100 us.
  double spin_share = 0.4;
  OverrunContract overrun;  ///< applies to the executor's modules that have no contract of their own
  /// automatic: Takt chooses the offsets that are not given, to spread the load over the rows.
  Offsets offsets = Offsets::given;
  /// let (logical execution time): run() reads the inputs as they were at the release, and its outputs become
  /// visible at the end of the period.
  Timing timing = Timing::direct;
  /// True: the executor runs in its own real-time process, so that a crash of its modules stops no other
  /// executor.
  bool own_host = false;
  Line line{};
};

struct Endpoint {
  std::string device;
  std::string module;
  std::string port;
  /// Returns false if the descriptor omits this end. Then the other end of the connection is in a program
  /// outside Takt.
  [[nodiscard]] bool given() const noexcept { return !device.empty(); }
  bool operator==(const Endpoint&) const = default;
};

/// Connects one port to another. A connection that has a topic and only one end connects a port to programs
/// outside Takt.
struct Connection {
  Endpoint from;
  Endpoint to;
  ConnectionKind kind = ConnectionKind::latest;
  int depth = 1;             ///< maximum number of samples in a queue; 1 for kind latest
  bool depth_given = false;  ///< true: the descriptor states the depth
  /// The descriptor reader makes queues reliable unless the descriptor says otherwise.
  Reliability reliability = Reliability::best_effort;
  std::optional<Nanoseconds> deadline;  ///< a value older than this is stale; none: values never become stale
  std::optional<Nanoseconds> lifespan;  ///< a value older than this is not delivered
  Stale stale = Stale::hold;
  std::string topic;  ///< name of the topic; empty: takt/<cell>/<device>/<module>/<port> of the writer
  std::optional<int> domain;  ///< DDS domain of the topic; none: the cell's domain
  /// True if the topic is a ROS 2 topic: its name begins with kRos2Topics, and its type is a ROS 2 message.
  bool ros2 = false;
  Carries carries = Carries::samples;
  Line line{};
};

/// Connects a client to a service. `port` of each endpoint is the name of the client or of the service.
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
  bool serve = false;  ///< true if this participant is the discovery server; a descriptor does not contain
                       ///< this value
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
  /// The path of the descriptor as the user gave it, for messages; empty if there is no file.
  std::string file;
  std::vector<Insertion> insertions;  ///< the includes and template uses in the descriptor
  int domain = 0;                     ///< DDS domain, 0 to 232
  bool domain_given = false;
  std::vector<Device> devices;
  std::vector<Connection> connections;
  std::vector<Service> services;
  Discovery discovery;
  /// The device whose node starts the discovery server; empty: the server runs elsewhere.
  std::string server_device;
  bool security_required = false;  ///< true: a node without DDS Security rejects the cell
  Line line{};

  [[nodiscard]] Texts texts() const { return {file, insertions}; }
};

/// The prefix of topics that are reserved for Takt.
inline constexpr const char* kOwnTopics = "takt/";

/// A service or client called NAME consists of two ports: NAME/request and NAME/reply.
inline constexpr const char* kRequestPort = "/request";
inline constexpr const char* kReplyPort = "/reply";
/// The maximum number of requests of one client that may wait for a service.
inline constexpr int kServiceDepth = 8;
/// Adds two adjacent connections for each service of a cell: one for the requests and one for the replies.
/// Call this only once for a cell.
void connect_services(Cell& cell);

/// The prefix that ROS 2 topics have on DDS (see the ROS 2 design article "Topic and Service name mapping to
/// DDS").
inline constexpr const char* kRos2Topics = "rt/";

/// Returns the endpoint as text, for example "robot.servo.setpoint". Missing parts at its end are omitted
/// together with their dots.
std::string to_text(const Endpoint& end);
/// Returns the name of a connection's topic on DDS: the topic that the descriptor gives, otherwise
/// takt/<cell>/<device>/<module>/<port> of the writer. For the replies of a service, this name is built from
/// the reader's names, so that each client has its own topic.
std::string topic_of(const Cell& cell, const Connection& connection);
/// Returns the names of all devices of the cell.
std::vector<std::string> device_names(const Cell& cell);
/// Returns the module's own overrun contract if it has one, otherwise the contract of its executor.
OverrunContract contract_of(const Device& device, const Module& module);
/// Returns the time after which a run() of the module, or the body of a process module, counts as hanging. It
/// is `hang` if the descriptor gives it. For a thread module with a budget, it is 10 budgets, or as many as
/// the budget's tolerance allows, and at least 20 ms. For other modules, it is 1 s plus 10 periods or
/// deadlines, at most 61 s.
Nanoseconds hang_limit(const Module& module);
/// Returns true if a fault of one of the device's modules can stop the whole cell, because the <recovery> or
/// the overrun contract of the module is stop-cell.
bool stops_cell(const Device& device);
/// Returns the timing of a periodic module, which is the timing of its executor. All other modules have
/// direct timing.
Timing timing_of(const Device& device, const Module& module);
/// Returns true if the module has a log, and so the property kLogLevelProperty. All modules have one, except
/// a non-real process module.
bool has_log(const Module& module);
/// Returns the line of the file name of a module's component; the line of the module if it gives none.
Line line_of_file(const Module& module);
/// Returns the arguments in one line. An argument that is empty or contains a space is in quotes.
std::string in_one_line(const std::vector<std::string>& arguments);
/// Returns the value that the descriptor sets for a property of a module. Fails if the descriptor does not
/// set the property.
Result<std::string> given_property(const Module& module, const std::string& name);
/// Sets the value of a module's property. Adds the property if the module does not have it yet.
void give_property(Module& module, const std::string& name, const std::string& value);

}  // namespace takt::model
