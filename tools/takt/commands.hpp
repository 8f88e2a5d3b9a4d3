// What `takt` does. Each command returns the exit status: 0 done, 1 refused or failed with a reason on
// standard error.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "network.hpp"
#include "proof.hpp"

namespace takt::tool {

struct CheckOptions {
  std::string file;
  bool json = false;
  std::string svg;        ///< where to write the picture; empty: nowhere
  bool expanded = false;  ///< print the descriptor without includes and templates instead
  bool remote = false;    ///< components that are not on this machine are warnings
  ProofOptions proof;
};
int check(const CheckOptions& options);

struct RunOptions {
  std::string file;
  Network network;
  std::optional<double> seconds;  ///< none: until Ctrl-C
  bool json = false;
  bool require_real_time = false;
  bool check_real_time = false;  ///< what modules do that no real-time code may is seen, and fails the run
  bool quiet = false;
  std::string state_folder;  ///< where the nodes keep their fault records; empty: in memory
  std::string profile;       ///< where to write the run times at the end; empty: nowhere
};
int run(const RunOptions& options);

/// What the command line asks for, once it was read.
using Chosen = std::function<int()>;
/// Each adds its command, which sets `chosen`. Both outlive the parsing.
void add_new(CLI::App& app, Chosen& chosen);
void add_graph(CLI::App& app, Chosen& chosen);
void add_simulate(CLI::App& app, Chosen& chosen);
void add_deploy(CLI::App& app, Chosen& chosen);
void add_undeploy(CLI::App& app, Chosen& chosen);
void add_status(CLI::App& app, Chosen& chosen);
void add_watch(CLI::App& app, Chosen& chosen);
void add_web(CLI::App& app, Chosen& chosen);
void add_log(CLI::App& app, Chosen& chosen);
void add_orders(CLI::App& app, Chosen& chosen);
void add_swap(CLI::App& app, Chosen& chosen);
void add_properties(CLI::App& app, Chosen& chosen);
void add_echo(CLI::App& app, Chosen& chosen);
void add_record(CLI::App& app, Chosen& chosen);
void add_play(CLI::App& app, Chosen& chosen);
void add_plot(CLI::App& app, Chosen& chosen);
void add_trace(CLI::App& app, Chosen& chosen);
void add_describe(CLI::App& app, Chosen& chosen);
void add_call(CLI::App& app, Chosen& chosen);
void add_doctor(CLI::App& app, Chosen& chosen);
void add_secure(CLI::App& app, Chosen& chosen);
void add_sign(CLI::App& app, Chosen& chosen);
void add_bench(CLI::App& app, Chosen& chosen);

}  // namespace takt::tool
