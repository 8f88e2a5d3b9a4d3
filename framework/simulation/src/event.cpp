#include <takt/simulation/event.hpp>

#include <iterator>

#include <fmt/format.h>

#include <takt/core/words.hpp>
#include <takt/model/hosts.hpp>

namespace takt::simulation {

namespace {

std::string seconds_text(Nanoseconds time) {
  const std::int64_t ns = time.count();
  const std::int64_t size = ns < 0 ? -ns : ns;
  return fmt::format("{}{}.{:09}", ns < 0 ? '-' : '+', size / 1'000'000'000, size % 1'000'000'000);
}

void add_who(std::string& line, const Event& event, const model::Cell& cell) {
  if (event.connection != Event::kNone) {
    const model::Connection& connection = cell.connections[event.connection];
    const bool at_writer = event.what == What::wrote;
    line += model::to_text(at_writer ? connection.from : connection.to);
    return;
  }
  if (event.device == Event::kNone) {
    line += cell.name;
    return;
  }
  const model::Device& device = cell.devices[event.device];
  line += device.name;
  if (event.module != Event::kNone) line += "." + device.modules[event.module].name;
  if (event.executor != Event::kNone) line += " executor " + device.executors[event.executor].name;
  if (event.host == Event::kNone) return;
  const model::HostShare host = model::hosts_of(device).at(event.host);
  line += host.is_own() ? " host of executor " + host.name : " host";
}

}  // namespace

std::string to_text(const Event& event, const model::Cell& cell, Instant t0) {
  std::string line = seconds_text(event.at - t0) + " ";
  add_who(line, event, cell);
  const auto to = std::back_inserter(line);
  switch (event.what) {
    case What::woke:
      fmt::format_to(to, " woke {} ns after its release", (event.at - event.release).count());
      break;
    case What::walked:
      fmt::format_to(to, " ran row {}, released at {}", event.number, seconds_text(event.release - t0));
      if (event.count != 0) fmt::format_to(to, ", missed rows before it: {}", event.count);
      break;
    case What::joined:
      fmt::format_to(to, " joins its grid at row {}, missed rows before it: {}", event.number, event.count);
      break;
    case What::put_in:
      line += " is in the tables";
      break;
    case What::taken_out:
      line += " is out of the tables";
      break;
    case What::ready:
      fmt::format_to(to, " is ready, by {}", seconds_text(event.until - t0));
      break;
    case What::run:
      fmt::format_to(to, " run {} of {}", event.number, seconds_text(event.release - t0));
      break;
    case What::ran:
      fmt::format_to(to, " ran {} ns", event.took.count());
      break;
    case What::released:
      fmt::format_to(to, " released, {} of {}", event.number, seconds_text(event.release - t0));
      break;
    case What::busy:
      line += " is still in its body";
      break;
    case What::body:
      fmt::format_to(to, " body {} of {}", event.number, seconds_text(event.release - t0));
      break;
    case What::done:
      fmt::format_to(to, " done after {} ns", event.took.count());
      break;
    case What::step:
      fmt::format_to(to, " {} -> {}, step {}", lifecycle::to_text(event.step.from),
                     lifecycle::to_text(event.step.to), event.step.sequence);
      break;
    case What::recovery:
      if (event.number == 0)
        fmt::format_to(to, " recovery, because the value of its input is fresh again");
      else
        fmt::format_to(to, " recovery, attempt {} of {}", event.number, event.count);
      break;
    case What::wrote:
      fmt::format_to(to, " wrote {}", event.number);
      break;
    case What::read:
      fmt::format_to(to, " read {}{}", event.number, event.count == 0 ? "" : ", torn");
      break;
    case What::arrived:
      fmt::format_to(to, " {} arrived", event.number);
      break;
    case What::lost:
      fmt::format_to(to, " {} is lost", event.number);
      break;
    case What::answered:
      line += " command";
      break;
    case What::safe:
      line += event.count != 0 ? " gives its reader the safe value" : " gives its reader samples again";
      break;
    case What::host_ended:
      line += " ended";
      break;
    case What::host_began:
      line += " began";
      break;
    case What::halted:
      line += " halted";
      break;
    case What::prepares:
      line += " prepares its modules";
      break;
    case What::begins:
      fmt::format_to(to, " begins, with T0 at {}", seconds_text(event.release - t0));
      break;
    case What::fault:
      line += " fault";
      break;
    case What::operated:
      line += " operator";
      break;
  }
  if (event.error != ErrorType::none) fmt::format_to(to, ", {}", takt::to_text(event.error));
  if (!event.text.empty()) fmt::format_to(to, " ({})", on_one_line(event.text));
  return line;
}

}  // namespace takt::simulation
