// A cell as plain data: what a descriptor says, no more. Reading it from XML is the descriptor room's,
// deciding what runs when is the schedule room's.
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

/// The words of the descriptor and of every report: "thread", "non-real", "stop-device".
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

/// What readers of an output get while its module does not execute, or its samples are too old. The fields
/// that are given stand in place of the component's own safe value; where it has none, in place of zero.
struct SafeValue {
  std::string name;                   ///< of the port
  std::vector<PropertyValue> fields;  ///< "torque" or "pose.x", and its value as in JSON
  Line line{};
};

/// What is tried when a module is in RECOVER.
struct Recovery {
  int attempts = 3;                                      ///< 0 to 1000
  Nanoseconds backoff = std::chrono::milliseconds{100};  ///< before each attempt; 0 to 1 h
  GiveUp then = GiveUp::destruct;
};

/// What becomes of releases that could not be served in time: of a module whose row was missed, or that was
/// not done by its next release.
struct OverrunContract {
  Overrun what = Overrun::skip;
  int limit = 1;  ///< catch_up: the newest releases that are made up, at most; 1 to 1000
};

/// How much more than its budget a run() may take before that is an error. Without either, any excess is one.
struct BudgetTolerance {
  std::optional<int> times;     ///< one excess is an error when it is beyond this many budgets; 1 to 1000
  std::optional<int> in_a_row;  ///< this many excesses in a row are one; 1 to 1000
};

/// Where the elements of a module stand; none for one that is not there.
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

/// `line` is the element's, here and below.
struct Module {
  std::string name;      ///< unique on its device
  std::string filename;  ///< as written; a relative one is looked up beside the descriptor, then on the
                         ///< component path
  ModuleType type = ModuleType::thread;
  Operation operation = Operation::periodic;
  std::optional<Nanoseconds> period;    ///< periodic: > 0. non-real thread: optional. Otherwise none.
  std::optional<Nanoseconds> offset;    ///< periodic: of its first release from T0, 0 to below its period
  std::optional<Nanoseconds> deadline;  ///< sporadic: > 0, from the release. Otherwise none.
  Miss miss = Miss::count;              ///< what a missed deadline is: counted only, or an error too
  Dispatch dispatch = Dispatch::row;    ///< sporadic: when a sample has come, after the next row or at once
  std::optional<Nanoseconds> interarrival;  ///< sporadic: > 0, the least time between two releases
  int priority = 0;                         ///< the lowest value is the highest priority
  std::string executor;  ///< periodic and sporadic: a name in Device::executors. non-real: empty.
  std::optional<Nanoseconds> budget;  ///< of one run(), > 0
  BudgetTolerance tolerance;
  std::optional<OverrunContract> overrun;  ///< periodic; none: its executor's
  Recovery recovery;
  bool retain = false;  ///< what it saves is kept on disk; not of a non-real program
  std::vector<PropertyValue> properties;
  std::vector<SafeValue> safe;  ///< of its outputs, each at most once
  Line line{};
  ModuleLines lines{};
};

struct Executor {
  std::string name = "main";
  std::optional<int> cpu;       ///< none: chosen by the node
  int priority = 80;            ///< SCHED_FIFO, 2 to 98; its sporadic modules run one below
  bool rate_monotonic = false;  ///< its priority follows from its basic period: the shorter, the higher
  Wakeup wakeup = Wakeup::hybrid;
  double spin_share = 0.4;  ///< of the basic period that the wake-up may spin, at most 100 us; 0 to 0.9
  OverrunContract overrun;  ///< of its modules that do not say
  Offsets offsets = Offsets::given;  ///< automatic: those that are not given flatten the table
  Timing timing = Timing::direct;    ///< let: inputs as of the release, outputs at the end of the period
  bool own_host = false;  ///< a real-time process of its own, so that a crash in it stops nothing else
  Line line{};
};

struct Endpoint {
  std::string device;
  std::string module;
  std::string port;
  /// False: none was given, the other end is a program that is not Takt's.
  [[nodiscard]] bool given() const noexcept { return !device.empty(); }
  bool operator==(const Endpoint&) const = default;
};

/// From one port to another, or, with a topic and one end only, between a port and programs that are not
/// Takt.
struct Connection {
  Endpoint from;
  Endpoint to;
  ConnectionKind kind = ConnectionKind::latest;
  int depth = 1;                                       ///< of a queue
  Reliability reliability = Reliability::best_effort;  ///< unless said: of a queue reliable
  std::optional<Nanoseconds> deadline;                 ///< a value older than this is stale
  std::optional<Nanoseconds> lifespan;                 ///< a value older than this is not delivered any more
  Stale stale = Stale::hold;
  std::string topic;          ///< empty: takt/<cell>/<device>/<module>/<port> of the writer
  std::optional<int> domain;  ///< of the topic; none: the cell's
  /// The topic is one of ROS 2: it begins with kRos2Topics, its type is a message of ROS 2.
  bool ros2 = false;
  Carries carries = Carries::samples;
  Line line{};
};

/// Who asks whom. `port` of each end is the name of the client, or of the service.
struct Service {
  Endpoint client;
  Endpoint server;
  Line line{};
};

/// How the nodes of a cell find each other.
struct Discovery {
  enum class Kind { multicast, peers, server };
  Kind kind = Kind::multicast;
  std::vector<std::string> peers;  ///< IPv4 addresses or host names, of kind peers
  std::string server;              ///< "host:port", of kind server
  bool serve = false;              ///< not of a descriptor: this participant is the server
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
  std::string file;  ///< the descriptor's path as it was given, for messages; empty if there is none
  std::vector<Insertion> insertions;  ///< what was put into it from elsewhere
  int domain = 0;                     ///< DDS domain, 0 to 232
  bool domain_given = false;
  std::vector<Device> devices;
  std::vector<Connection> connections;
  std::vector<Service> services;
  Discovery discovery;
  std::string server_device;       ///< whose node starts the discovery server; empty: somebody else runs it
  bool security_required = false;  ///< a node that runs without DDS Security refuses it
  Line line{};

  [[nodiscard]] Texts texts() const { return {file, insertions}; }
};

/// What the names of Takt's own topics begin with.
inline constexpr const char* kOwnTopics = "takt/";

/// The two ports that a service or client NAME is made of are NAME/request and NAME/reply.
inline constexpr const char* kRequestPort = "/request";
inline constexpr const char* kReplyPort = "/reply";
/// Requests that wait for a service, of each client.
inline constexpr int kServiceDepth = 8;
/// Adds the two connections that each service of a cell is made of, side by side. Once.
void connect_services(Cell& cell);

/// What the names of ROS 2's topics begin with on DDS (its design article "Topic and Service name mapping to
/// DDS").
inline constexpr const char* kRos2Topics = "rt/";

/// "robot.servo.setpoint"; without the dots of parts that are missing.
std::string to_text(const Endpoint& end);
/// The name of a connection's topic on DDS: its own, else takt/<cell>/<device>/<module>/<port> of the writer;
/// of replies, of their reader: each client has a topic of its own.
std::string topic_of(const Cell& cell, const Connection& connection);
/// The module's own overrun contract, else its executor's.
OverrunContract contract_of(const Device& device, const Module& module);
/// A fault of one of its modules is the whole cell's: such a module's <recovery> or overrun contract says
/// stop-cell.
bool stops_cell(const Device& device);
/// Of a periodic module, its executor's; all others are direct.
Timing timing_of(const Device& device, const Module& module);
/// The text that the descriptor gives a property of a module. Fails when it gives none.
Result<std::string> given_property(const Module& module, const std::string& name);
/// The module is given the property with this value, whether it was given it before or not.
void give_property(Module& module, const std::string& name, const std::string& value);

}  // namespace takt::model
