// The messages between a node and its host: JSON texts over a message socket. No real-time thread uses these
// messages.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <takt/channel/activity.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/os/fd.hpp>

namespace takt::host {

/// One end of a link (the memory of a connection) at a thread module. A link between two modules of this host
/// has two PortLinks with the same file descriptor.
struct PortLink {
  std::uint32_t module = 0;
  std::string port;
  int fd = -1;
  bool typed = false;  ///< true: the samples are C++ values in the host's memory; false: encoded bytes
  bool stale_is_error =
      false;  ///< for an input: run() is not called while the newest value is older than the deadline
};

/// The data that a host needs about its device. The node has chosen the CPUs. An empty list of CPUs means any
/// CPU.
struct Setup {
  model::Device device;
  std::size_t share = 0;                        ///< index of this host in model::hosts_of(device)
  std::vector<std::string> paths;               ///< path of each module's component file
  std::vector<std::vector<int>> executor_cpus;  ///< the CPUs of each executor
  std::vector<int> background_cpus;             ///< the CPUs of all threads that are not real-time
  std::vector<int> slot_fds;  ///< file descriptor of each module's release slot; -1 if the module has none or
                              ///< is not in this host
  int wake_word_fd = -1;
  int saved_fd = -1;  ///< file descriptor of the memory with a channel::SavedState for each module
  std::vector<PortLink> links{};
};

/// A message from the node to the host.
struct Request {
  enum class Do {
    call,          ///< call a hook of `module`, or load it; answered
    get,           ///< get the value of a property of `module`; answered
    set,           ///< set a property of `module`, even while the module runs; answered
    swap,          ///< replace `module` by a new instance from the file `value`; answered
    give_up_swap,  ///< abandon the swap of `module`: a hook of the new instance never returns
    begin,         ///< start the executors on the grid that begins at t0_ns of the host's block; answered
    background,    ///< start the threads of non-real-time modules
    halt,          ///< end the executors and background threads; answered
    give_up,       ///< the current hook of `module` never returns; continue without the module
    end,           ///< end the process
  };
  Do what = Do::end;
  std::uint32_t module = 0;
  channel::Doing hook = channel::Doing::nothing;
  int error_type = 0;
  std::uint64_t id = 0;  ///< for get and set: the answer has the same id
  std::string property{};
  std::string value{};  ///< for set: the new value; for swap: the path
  /// For swap: the properties that the new instance does not take over from the running one, with their values
  std::map<std::string, std::string> values{};
  /// For a call that loads: true if an operator has reset the module, so that the present file is loaded;
  /// false to load the file that the module was loaded from before.
  bool afresh = false;
  /// For a call that loads, and for swap: a sealed copy of the component's file. It does not belong to the
  /// encoded text, but is sent with it.
  std::shared_ptr<const os::Fd> component{};
  bool is_signed = false;  ///< the signature of the copy was checked; it finds no libraries through $ORIGIN
};

/// A message from the host to the node.
struct Answer {
  Request request;
  bool ok = true;
  /// If `ok` is false, the reason. Otherwise: for get, the value; for a call of initialize(), a sentence
  /// about the restored state; for swap, the first row of the new instance.
  std::string text;
  std::vector<std::string> warnings;  ///< for begin: rights that the system denied, such as a priority or a
                                      ///< CPU
};

std::string encode(const Setup& setup);
std::string encode(const Request& request);
std::string encode(const Answer& answer);
/// These functions decode a message. They fail if the text is not an encoded message of their kind.
Result<Setup> decode_setup(const std::string& text);
Result<Request> decode_request(const std::string& text);
Result<Answer> decode_answer(const std::string& text);

}  // namespace takt::host
