// The commands of `takt`. Each command, or family of commands, has its own source file, which adds it to the
// command line.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace takt::tool {

/// Runs the chosen command and returns its exit status. 0 means success. 1 means that the command was
/// rejected or failed; the reason is then on standard error.
using Chosen = std::function<int()>;
/// Adds a command to the command line. If the user gives this command, parsing sets `chosen`. `app` and
/// `chosen` must live until the command line is parsed.
using AddCommand = void(CLI::App& app, Chosen& chosen);

AddCommand add_check;
AddCommand add_graph;
AddCommand add_run;
AddCommand add_new;
AddCommand add_simulate;
AddCommand add_deploy;
AddCommand add_undeploy;
AddCommand add_status;
AddCommand add_watch;
AddCommand add_web;
AddCommand add_log;
AddCommand add_alarms;
AddCommand add_module_commands;
AddCommand add_restart;
AddCommand add_swap;
AddCommand add_properties;
AddCommand add_force;
AddCommand add_echo;
AddCommand add_record;
AddCommand add_play;
AddCommand add_plot;
AddCommand add_trace;
AddCommand add_call;
AddCommand add_doctor;
AddCommand add_secure;
AddCommand add_sign;
AddCommand add_bench;
AddCommand add_describe;
AddCommand add_complete;

/// All commands, in the order in which `takt --help` lists them.
inline constexpr AddCommand* kCommands[] = {
    add_check,    add_graph,   add_run,   add_new,        add_simulate, add_deploy,
    add_undeploy, add_status,  add_watch, add_web,        add_log,      add_module_commands,
    add_alarms,   add_restart, add_swap,  add_properties, add_force,    add_echo,
    add_record,   add_play,    add_plot,  add_trace,      add_call,     add_doctor,
    add_secure,   add_sign,    add_bench, add_describe,   add_complete};

}  // namespace takt::tool
