#include <takt/wire/words.hpp>

#include <takt/core/words.hpp>

namespace takt {

const char* to_text(LifecycleState state) noexcept {
  switch (state) {
    case STATE_IDLE:
      return "IDLE";
    case STATE_INITIALIZE:
      return "INITIALIZE";
    case STATE_START:
      return "START";
    case STATE_EXECUTING:
      return "EXECUTING";
    case STATE_RECOVER:
      return "RECOVER";
    case STATE_DESTRUCT:
      return "DESTRUCT";
  }
  return "?";
}

const char* to_text(LifecycleEvent event) noexcept {
  switch (event) {
    case EVENT_NONE:
      return "";
    case EVENT_INITIALIZE:
      return "initialize";
    case EVENT_START:
      return "start";
    case EVENT_RUN:
      return "run";
    case EVENT_STOP:
      return "stop";
    case EVENT_ERROR:
      return "error";
    case EVENT_RECOVER:
      return "recover";
    case EVENT_GIVE_UP:
      return "give up";
    case EVENT_DESTRUCT:
      return "destruct";
    case EVENT_RESET:
      return "reset";
  }
  return "?";
}

const char* to_text(LifecycleError error) noexcept {
  switch (error) {
    case ERROR_NONE:
      return "";
    case ERROR_FAILURE:
      return "failure";
    case ERROR_BUDGET:
      return "budget";
    case ERROR_START:
      return "start";
    case ERROR_CRASH:
      return "crash";
    case ERROR_HANG:
      return "hang";
    case ERROR_DEADLINE:
      return "deadline";
    case ERROR_STALE:
      return "stale";
    case ERROR_OVERRUN:
      return "overrun";
  }
  return "?";
}

const char* to_text(DeviceState state) noexcept {
  switch (state) {
    case DEVICE_WAITING:
      return "waiting";
    case DEVICE_PREPARING:
      return "preparing";
    case DEVICE_READY:
      return "ready";
    case DEVICE_ARMED:
      return "armed";
    case DEVICE_STARTED:
      return "started";
    case DEVICE_RUNNING:
      return "running";
    case DEVICE_STOPPING:
      return "stopping";
    case DEVICE_ENDED:
      return "ended";
  }
  return "?";
}

const char* to_text(DeviceHealth health) noexcept {
  switch (health) {
    case HEALTH_OK:
      return "ok";
    case HEALTH_DEGRADED:
      return "degraded";
    case HEALTH_FAILED:
      return "failed";
  }
  return "?";
}

const char* to_text(TransactionStage stage) noexcept {
  switch (stage) {
    case STAGE_PREPARED:
      return "prepared";
    case STAGE_ARMED:
      return "armed";
    case STAGE_RUNNING:
      return "running";
    case STAGE_UNDONE:
      return "undone";
    case STAGE_FINAL:
      return "final";
  }
  return "?";
}

const char* to_text(CommandKind kind) noexcept {
  switch (kind) {
    case COMMAND_REPORT:
      return "report";
    case COMMAND_DESCRIPTOR:
      return "descriptor";
    case COMMAND_DESCRIBE:
      return "describe";
    case COMMAND_PREPARE:
      return "prepare";
    case COMMAND_CHANGE:
      return "change";
    case COMMAND_RUN:
      return "run";
    case COMMAND_PUT_BACK:
      return "put back";
    case COMMAND_UNDEPLOY:
      return "undeploy";
    case COMMAND_INITIALIZE:
      return "initialize";
    case COMMAND_START:
      return "start";
    case COMMAND_STOP:
      return "stop";
    case COMMAND_RECOVER:
      return "recover";
    case COMMAND_RESET:
      return "reset";
    case COMMAND_DESTRUCT:
      return "destruct";
    case COMMAND_GET:
      return "get";
    case COMMAND_SET:
      return "set";
    case COMMAND_TAP:
      return "tap";
    case COMMAND_LOG:
      return "log";
    case COMMAND_SWAP:
      return "swap";
    case COMMAND_TRACE:
      return "trace";
    case COMMAND_FORCE:
      return "force";
    case COMMAND_END_FORCE:
      return "end the force";
    case COMMAND_ALARMS:
      return "alarms";
    case COMMAND_ACKNOWLEDGE:
      return "acknowledge";
  }
  return "?";
}

}  // namespace takt

namespace takt::wire {

std::string cut(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return std::string{text};
  constexpr std::string_view kOmitted = "...";
  if (bytes <= kOmitted.size()) return std::string{text.substr(0, bytes)};
  std::size_t end = bytes - kOmitted.size();
  // Move the cut back to the beginning of a UTF-8 character. Text that is not UTF-8 may be cut at any byte.
  for (std::size_t back = 0; back < 4 && back < end; ++back) {
    if (utf8_length(text.substr(end - back)) == 0) continue;
    end -= back;
    break;
  }
  return std::string{text.substr(0, end)} += kOmitted;
}

std::string path_of(std::string_view cell, std::string_view device, std::string_view part) {
  std::string path{cell};
  path.append("/").append(device);
  if (!part.empty()) path.append("/").append(part);
  return path;
}

bool executes(const DeviceStatus& status) {
  return status.state() == DEVICE_STARTED || status.state() == DEVICE_RUNNING;
}

std::string name_conflict(const DeviceStatus& other, int domain) {
  std::string text = "another node named " + other.device().to_string() + " is on domain " +
                     std::to_string(domain) + ": process " + std::to_string(other.process_id()) + " on " +
                     other.host_name().to_string();
  if (!executes(other)) return text;
  const std::string cell = " cell " + other.cell().to_string();
  if (other.uninterrupted_s() == 0) return text + ", which executes" + cell;
  return text + ", which has executed" + cell + " without interruption for " +
         std::to_string(other.uninterrupted_s()) + " s";
}

std::string nodes_of_one_name(const std::vector<DeviceStatus>& nodes, int domain) {
  std::string places;
  for (const DeviceStatus& node : nodes) {
    places += (places.empty() ? "process " : ", process ") + std::to_string(node.process_id()) + " on " +
              node.host_name().to_string();
  }
  return std::to_string(nodes.size()) + " nodes on domain " + std::to_string(domain) +
         " have this name: " + places;
}

}  // namespace takt::wire
