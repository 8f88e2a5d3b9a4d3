// The process of a process module.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <takt/node/output.hpp>
#include <takt/os/process.hpp>
#include <takt/supervision/parts.hpp>
#include <takt/supervision/platform.hpp>
#include "host_process.hpp"

namespace takt::node {

class ProgramProcess final : public supervision::Program {
 public:
  /// If the program is periodic or sporadic, `inheritance` is called at each start of the program.
  ProgramProcess(const supervision::Parts& parts, std::uint32_t module,
                 std::function<Inheritance()> inheritance)
      : parts_(parts), module_(module), inheritance_(std::move(inheritance)) {}

  Result<void> start() override;
  std::optional<supervision::ProcessEnd> ended() override;
  void terminate() override { child_.signal(os::kTerminate); }
  void kill() override { child_.signal(os::kKill); }
  Result<void> make_real_time() override;
  void wake_for_property() override;
  [[nodiscard]] bool running() const override { return child_.running(); }
  [[nodiscard]] int pid() const override { return pid_; }
  [[nodiscard]] std::string last_line() const override { return output_.last_words(); }

  /// Logs the output of the program.
  void step(const std::string& device);
  void wait_on(std::vector<const os::Fd*>& fds) const;

 private:
  [[nodiscard]] const model::Module& model() const { return parts_.of_device().modules[module_]; }

  const supervision::Parts& parts_;
  const std::uint32_t module_;
  const std::function<Inheritance()> inheritance_;
  os::Child child_;
  Output output_;
  int pid_ = 0;
};

}  // namespace takt::node
