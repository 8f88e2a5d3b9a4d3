// What a node and its host say to each other: JSON texts over a message socket. Nothing of it is on a
// real-time path.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/channel/activity.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::host {

/// An end of a link that a thread module has. Of a link between two modules of the host there are two, with
/// the same descriptor.
struct PortLink {
  std::uint32_t module = 0;
  std::string port;
  int fd = -1;
  bool typed = false;  ///< its payloads are values in the host's memory
  bool stale_is_error =
      false;  ///< of an input: run() is not called while the newest value is older than the deadline
};

/// What a host needs to know of its device. Processors are where the node decided; empty lists mean any.
struct Setup {
  model::Device device;
  std::size_t share = 0;                        ///< which of model::hosts_of(device) it is
  std::vector<std::string> paths;               ///< of each module's component
  std::vector<std::vector<int>> executor_cpus;  ///< of each executor
  std::vector<int> background_cpus;             ///< of everything that is not real-time
  std::vector<int> seat_fds;  ///< of each module; -1: it has no slot, or is no business of this host
  int bell_fd = -1;
  int saved_fd = -1;  ///< a channel::SavedState for each module
  std::vector<PortLink> links{};
};

/// node -> host
struct Request {
  enum class Do {
    call,          ///< call a hook (or load) of `module`; answered
    get,           ///< the value of a property of `module`; answered
    set,           ///< set it, while the module runs or not; answered
    swap,          ///< another instance of `module`, of the file `value`, takes its place; answered
    give_up_swap,  ///< the instance that is to take the place of `module` never comes out of a hook
    begin,         ///< start the executors on the grid of its block's t0_ns; answered
    background,    ///< start the threads of non-real-time modules
    halt,          ///< end the executors and background threads; answered
    give_up,       ///< the hook of `module` that is being called never returns: go on without it
    end,           ///< end the process
  };
  Do what = Do::end;
  std::uint32_t module = 0;
  channel::Doing hook = channel::Doing::nothing;
  int error_type = 0;
  std::uint64_t id = 0;  ///< of get and set: the answer has it too
  std::string property{};
  std::string value{};  ///< to set; to swap: the path
};

/// host -> node
struct Answer {
  Request request;
  bool ok = true;
  std::string text;  ///< why not; to get: the value; of initialize(): what was restored; of swap: since when
  std::vector<std::string> warnings;  ///< to begin: what the system refused, in words
};

std::string encode(const Setup& setup);
std::string encode(const Request& request);
std::string encode(const Answer& answer);
/// Fail on a text that is none of ours.
Result<Setup> decode_setup(const std::string& text);
Result<Request> decode_request(const std::string& text);
Result<Answer> decode_answer(const std::string& text);

}  // namespace takt::host
