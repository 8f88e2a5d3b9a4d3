// A cell as plain data: what a descriptor says, no more. Reading it from XML is the descriptor room's,
// deciding what runs when is the schedule room's.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::model {

enum class ModuleType { thread, process };
enum class Operation { periodic, sporadic, non_real };
enum class Wakeup { sleep, hybrid, spin };
enum class GiveUp { destruct, stop_device };
enum class ConnectionKind { latest, queue };
enum class Stale { hold, error };

/// The words of the descriptor and of every report: "thread", "non-real", "stop-device".
const char* to_text(ModuleType type);
const char* to_text(Operation operation);
const char* to_text(Wakeup wakeup);
const char* to_text(GiveUp then);
const char* to_text(ConnectionKind kind);
const char* to_text(Stale stale);

struct PropertyValue {
  std::string name;
  std::string value;
  int line = 0;
};

/// What is tried when a module is in RECOVER.
struct Recovery {
  int attempts = 3;                                      ///< 0 to 1000
  Nanoseconds backoff = std::chrono::milliseconds{100};  ///< before each attempt; 0 to 1 h
  GiveUp then = GiveUp::destruct;
};

/// Where in Cell::file the elements of a module stand; 0 for one that is not there.
struct ModuleLines {
  int name = 0;
  int filename = 0;
  int period = 0;
  int deadline = 0;
  int executor = 0;
  int budget = 0;
};

/// `line` is the element's line in Cell::file, here and below.
struct Module {
  std::string name;      ///< unique on its device
  std::string filename;  ///< as written; a relative one is looked up beside the descriptor, then on the
                         ///< component path
  ModuleType type = ModuleType::thread;
  Operation operation = Operation::periodic;
  std::optional<Nanoseconds> period;    ///< periodic: > 0. non-real thread: optional. Otherwise none.
  std::optional<Nanoseconds> deadline;  ///< sporadic: > 0, from the release. Otherwise none.
  int priority = 0;                     ///< the lowest value is the highest priority
  std::string executor;  ///< periodic and sporadic: a name in Device::executors. non-real: empty.
  std::optional<Nanoseconds> budget;  ///< of one run(), > 0
  Recovery recovery;
  std::vector<PropertyValue> properties;
  int line = 0;
  ModuleLines lines{};
};

struct Executor {
  std::string name = "main";
  std::optional<int> cpu;  ///< none: chosen by the node
  int priority = 80;       ///< SCHED_FIFO, 2 to 98; its sporadic modules run one below
  Wakeup wakeup = Wakeup::hybrid;
  int line = 0;
};

struct Endpoint {
  std::string device;
  std::string module;
  std::string port;
};

struct Connection {
  Endpoint from;
  Endpoint to;
  ConnectionKind kind = ConnectionKind::latest;
  int depth = 1;                        ///< of a queue
  std::optional<Nanoseconds> deadline;  ///< a value older than this is stale
  Stale stale = Stale::hold;
  int line = 0;
};

struct Device {
  std::string name;
  std::vector<Executor> executors;  ///< never empty
  std::vector<Module> modules;
  int line = 0;
};

struct Cell {
  std::string name;
  std::string file;  ///< the descriptor's path as it was given, for messages; empty if there is none
  int domain = 0;    ///< DDS domain, 0 to 232
  bool domain_given = false;
  std::vector<Device> devices;
  std::vector<Connection> connections;
  int line = 0;
};

}  // namespace takt::model
