// The platform of a node's supervision: processes of this machine, and flows over DDS.
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
    bool require_real_time = false;  ///< whether to fail if the machine does not allow real time
    bool check_real_time = false;    ///< whether to detect real-time violations of modules
    os::WakeUps wake_ups{};          ///< measured on this machine; not measured if the count is 0
    std::string state_folder{};      ///< folder for the state that modules retain; empty to save nothing
    std::string traces{};            ///< beginning of the paths of fault traces; empty to write no traces
    std::shared_ptr<dds::Participant> participant{};  ///< connects to other devices; null for no DDS
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
  void step(Instant now) override;
  std::vector<supervision::Detection> detections() override;
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

  /// The descriptors that become readable when a host or program reports something.
  [[nodiscard]] std::vector<const os::Fd*> wait_on() const;

 private:
  Result<void> start_record();
  Result<void> retain();
  void watch_gaps(std::vector<supervision::Detection>& detections);

  const Options options_;
  supervision::Parts* parts_ = nullptr;  // null before begin()
  std::optional<os::Throttling> throttling_;
  os::KernelNews kernel_news_;
  std::vector<std::int64_t> seen_latest_ns_;  // for each executor, the latest_ns that was read last
  std::vector<bool> throttled_;               // for each executor, whether throttling was reported
  std::optional<Violations> violations_;      // empty without check_real_time
  std::unique_ptr<FlightRecorder> flight_;
  std::unique_ptr<Retained> retained_;
  std::vector<HostProcess*> hosts_;        // the supervision owns them
  std::vector<ProgramProcess*> programs_;  // the supervision owns these, too
};

}  // namespace takt::node
