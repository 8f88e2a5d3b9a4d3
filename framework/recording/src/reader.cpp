#include <takt/recording/reader.hpp>

#include <algorithm>
#include <filesystem>

#include <takt/core/words.hpp>

namespace takt::recording {

namespace {

std::string where(const Selection& selection) {
  std::string sql = " WHERE time_ns >= ? AND time_ns <= ?";
  if (selection.ports.empty()) return sql;
  std::string list;
  for (const std::int64_t port : selection.ports) list += (list.empty() ? "" : ",") + std::to_string(port);
  return sql + " AND port IN (" + list + ")";
}

}  // namespace

Result<Recording> Recording::open(const std::string& file) {
  const std::string place = on_one_line(file);
  std::error_code none;
  if (!std::filesystem::exists(file, none))
    return Problem{place, "does not exist", "create a recording with takt record"};
  auto database = Database::open(file, Access::read);
  if (!database) return database.problems();
  const auto id = database->number("PRAGMA application_id");
  if (!id) return id.problems();
  const auto version = database->number("PRAGMA user_version");
  if (!version) return version.problems();
  if (*id != kRecordingId) return Problem{place, "is not a recording", "create a recording with takt record"};
  if (*version != kRecordingVersion)
    return Problem{
        place, "has recording format " + std::to_string(*version),
        "use a Takt version that reads it; this one reads only format " + std::to_string(kRecordingVersion)};
  Recording recording{std::move(*database)};
  if (auto loaded = recording.load(); !loaded) return loaded.problems();
  return recording;
}

Result<void> Recording::load() {
  auto cell = Statement::prepare(database_, "SELECT value FROM meta WHERE name = 'cell'");
  if (!cell) return cell.problems();
  const auto named = cell->step();
  if (!named) return named.problems();
  if (*named) cell_ = cell->text(0);
  cell->reset();

  auto ports = Statement::prepare(database_, "SELECT id, path, topic, reliable, type FROM port ORDER BY id");
  if (!ports) return ports.problems();
  for (;;) {
    const auto row = ports->step();
    if (!row) return row.problems();
    if (!*row) break;
    PortOfRecording port;
    port.id = ports->number(0);
    port.path = ports->text(1);
    port.topic = ports->text(2);
    port.reliable = ports->number(3) != 0;
    auto type = model::parse_type(ports->text(4));
    if (!type) {
      return Problem{on_one_line(database_.file()),
                     "is damaged: port " + in_quotes(port.path) +
                         " has an unreadable type: " + in_words(type.problems()),
                     ""};
    }
    port.type = std::move(*type);
    ports_.push_back(std::move(port));
  }

  auto counts = Statement::prepare(
      database_, "SELECT port, count(*), min(time_ns), max(time_ns), sum(missing) FROM sample GROUP BY port");
  if (!counts) return counts.problems();
  bool any = false;
  for (;;) {
    const auto row = counts->step();
    if (!row) return row.problems();
    if (!*row) break;
    const auto found = std::find_if(ports_.begin(), ports_.end(),
                                    [&](const auto& port) { return port.id == counts->number(0); });
    if (found == ports_.end()) continue;
    found->samples = static_cast<std::uint64_t>(counts->number(1));
    found->first_ns = counts->number(2);
    found->last_ns = counts->number(3);
    found->missing = static_cast<std::uint64_t>(counts->number(4));
    first_ns_ = any ? std::min(first_ns_, found->first_ns) : found->first_ns;
    last_ns_ = any ? std::max(last_ns_, found->last_ns) : found->last_ns;
    any = true;
  }
  return {};
}

std::uint64_t Recording::samples() const {
  std::uint64_t all = 0;
  for (const auto& port : ports_) all += port.samples;
  return all;
}

Result<void> Recording::read(const Selection& selection,
                             const std::function<bool(const RecordedSample&)>& each, std::uint64_t& wrong) {
  auto rows = Statement::prepare(
      database_, "SELECT port, time_ns, missing, bytes FROM sample" + where(selection) + " ORDER BY id");
  if (!rows) return rows.problems();
  rows->bind(1, selection.from_ns);
  rows->bind(2, selection.to_ns);
  for (;;) {
    const auto row = rows->step();
    if (!row) return row.problems();
    if (!*row) return {};
    const auto port =
        std::find_if(ports_.begin(), ports_.end(), [&](const auto& p) { return p.id == rows->number(0); });
    const auto [bytes, size] = rows->bytes(3);
    if (port == ports_.end() || bytes == nullptr || !model::is_sample(port->type, bytes, size)) {
      ++wrong;
      continue;
    }
    if (!each({&*port, rows->number(1), static_cast<std::uint64_t>(rows->number(2)), bytes, size})) return {};
  }
}

Result<std::vector<std::int64_t>> Recording::times(std::int64_t port, const Selection& selection) {
  auto rows =
      Statement::prepare(database_, "SELECT time_ns FROM sample" +
                                        where({{port}, selection.from_ns, selection.to_ns}) + " ORDER BY id");
  if (!rows) return rows.problems();
  rows->bind(1, selection.from_ns);
  rows->bind(2, selection.to_ns);
  std::vector<std::int64_t> times;
  for (;;) {
    const auto row = rows->step();
    if (!row) return row.problems();
    if (!*row) return times;
    times.push_back(rows->number(0));
  }
}

}  // namespace takt::recording
