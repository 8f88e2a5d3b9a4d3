#include "programs.hpp"

#include <cstdio>

#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>

namespace takt::bench {

namespace {

const std::vector<std::string> kStress{"--cpu", "0", "--io", "1", "--quiet"};

std::string on_path(const std::string& program) {
  std::string path = os::environment("PATH");
  while (!path.empty()) {
    const std::string folder = path.substr(0, path.find(':'));
    path.erase(0, folder.size() + 1);
    if (!folder.empty() && os::is_executable(folder + "/" + program)) return folder + "/" + program;
  }
  return "";
}

}  // namespace

Result<Interruption> Interruption::create() {
  auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return signals.problems();
  return Interruption{std::move(*signals)};
}

bool Interruption::ended() {
  while (signals_.next()) ended_ = true;
  return ended_;
}

Problem asked_to_end() { return fail("ended by a signal before everything was measured"); }

Result<os::Child> start_beside(const std::string& program, const std::vector<std::string>& arguments,
                               bool capture_output) {
  os::SpawnOptions spawn{.program = os::program_directory() + "/" + program,
                         .arguments = arguments,
                         .capture_output = capture_output};
  if (os::environment("TAKT_INTERFACE").empty()) spawn.environment = {{"TAKT_INTERFACE", "127.0.0.1"}};
  return os::Child::spawn(spawn);
}

Result<std::string> run_beside(const std::string& program, const std::vector<std::string>& arguments,
                               Interruption& interruption) {
  auto child = start_beside(program, arguments, true);
  if (!child) return child.problems();
  std::string output;
  std::string error;
  bool output_ended = false;
  bool error_ended = false;
  bool asked = false;
  while (!output_ended || !error_ended) {
    std::vector<const os::Fd*> fds;
    if (!asked) fds.push_back(&interruption.fd());
    if (!output_ended) fds.push_back(&child->output);
    if (!error_ended) fds.push_back(&child->error);
    os::wait_readable(fds, 100);
    if (!output_ended) output += os::read_available(child->output, &output_ended);
    if (!error_ended) error += os::read_available(child->error, &error_ended);
    if (!asked && interruption.ended()) {
      asked = true;
      child->signal(os::kTerminate);
    }
  }
  const os::ProcessEnd end = child->wait();
  if (asked) return asked_to_end();
  if (end.signalled || end.code != 0) {
    while (!error.empty() && error.back() == '\n') error.pop_back();
    return fail(program + " " + arguments.front() + " " + end.text() + (error.empty() ? "" : ": " + error));
  }
  return output;
}

Result<Load> Load::start() {
  const std::string program = on_path("stress-ng");
  if (program.empty())
    return fail("stress-ng, which --load runs, is not installed",
                "install it with apt-get install stress-ng");
  auto child = os::Child::spawn({.program = program, .arguments = kStress});
  if (!child) return child.problems();
  return Load{std::move(*child)};
}

Load::~Load() {
  // Send SIGTERM, not SIGKILL, so that stress-ng ends its own child processes.
  child_.signal(os::kTerminate);
  if (child_.running()) child_.wait();
}

std::string Load::words() {
  std::string words = "stress-ng";
  for (const std::string& word : kStress) words += " " + word;
  return words;
}

}  // namespace takt::bench
