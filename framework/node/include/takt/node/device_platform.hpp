// The platform on which a node supervises a device: processes of this machine, and flows over DDS.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/dds/participant.hpp>
#include <takt/node/flight_recorder.hpp>
#include <takt/node/retained.hpp>
#include <takt/node/violations.hpp>
#include <takt/os/fd.hpp>
#include <takt/os/kernel_news.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>
#include <takt/supervision/platform.hpp>

namespace takt::node {

class HostProcess;
class ProgramProcess;

class DevicePlatform final : public supervision::Platform {
 public:
  struct Options {
    bool require_real_time = false;  ///< true: fail if the machine does not allow real time
    bool check_real_time = false;    ///< true: detect real-time violations of modules
    os::WakeUps wake_ups{};  ///< delays with which this machine wakes threads; count is 0 if they were not
                             ///< measured
    /// The folder for the state that modules retain. If it is empty, this state is not saved.
    std::string state_folder{};
    std::string traces{};  ///< beginning of the paths of fault traces; if empty, no traces are written
    std::shared_ptr<dds::Participant> participant{};  ///< connects to other devices; if null, the platform
                                                      ///< opens no flows
  };

  explicit DevicePlatform(Options options);
  ~DevicePlatform() override;

  [[nodiscard]] Instant now() const override;
  Result<void> begin(supervision::Parts& parts) override;
  [[nodiscard]] Nanoseconds spin_limit(const model::Module& module, Nanoseconds period) const override;
  std::unique_ptr<supervision::Host> make_host(std::size_t share) override;
  std::unique_ptr<supervision::Program> make_program(std::uint32_t module) override;
  Result<std::unique_ptr<supervision::Flows>> open_flows() override;
  void wake(std::uint32_t bits) override;
  [[nodiscard]] std::optional<Nanoseconds> ran_if_ready(std::int32_t thread) const override;
  void step(Instant now) override;
  std::vector<supervision::Detection> detections() override;
  void forget(std::uint32_t module) override;
  std::optional<Result<void>> forgotten(std::uint32_t module) override;
  bool finish() override;
  Problems final_problems() override;
  void add_to(nlohmann::ordered_json& report) const override;
  void log(const std::string& module, const std::string& text) override;
  void stepped(const supervision::Step& step) override;
  void in_tables(std::uint32_t, bool) override {}
  void recovering(std::uint32_t, int) override {}
  void fault(const std::string& why) override;
  void host_died(const model::HostShare& share) override;
  void trace(Nanoseconds last, std::size_t most,
             std::function<void(const Result<std::string>&)> done) override;

  /// Returns the file descriptors that become readable when a host or a process module reports something.
  [[nodiscard]] std::vector<const os::Fd*> wait_on() const;

 private:
  Result<void> start_record();
  Result<void> retain();
  void check_gaps(std::vector<supervision::Detection>& detections);

  const Options options_;
  supervision::Parts* parts_ = nullptr;  // null before begin()
  std::optional<os::Throttling> throttling_;
  os::KernelNews kernel_news_;
  std::vector<std::int64_t> seen_latest_ns_;  // by executor: the last value of latest_ns that was read
  std::vector<bool> throttled_;               // by executor: true if throttling was reported
  std::optional<Violations> violations_;      // empty if check_real_time is false
  std::unique_ptr<FlightRecorder> flight_;
  std::unique_ptr<Retained> retained_;
  std::vector<HostProcess*> hosts_;        // the Supervisor owns these objects
  std::vector<ProgramProcess*> programs_;  // the Supervisor owns these objects
};

}  // namespace takt::node
