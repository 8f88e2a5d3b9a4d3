// Parses arbitrary bytes as a descriptor. The parser must return either a cell that satisfies every rule of
// the model, or readable problems. tinyxml2 must be able to read every text that Takt's own scanner accepts.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <takt/core/check.hpp>
#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/validate.hpp>

namespace {

constexpr std::string_view kFile = "fuzz.xml:";

bool is_plain(const std::string& text) { return !text.empty() && takt::on_one_line(text) == text; }

void check_problem(const takt::Problem& problem, int last_line, bool bundle) {
  TAKT_CHECK(is_plain(problem.what));
  TAKT_CHECK(is_plain(problem.fix));
  if (bundle) return;  // a bundle names its own files and lines, which this function does not know
  TAKT_CHECK(problem.what.size() < 1000 && problem.fix.size() < 4000);
  TAKT_CHECK(problem.where.starts_with(kFile));
  const int line = std::stoi(problem.where.substr(kFile.size()));
  TAKT_CHECK(line >= 1 && line <= last_line);
  // Takt's own scanner runs first and reports all invalid XML, so tinyxml2 must never find any.
  TAKT_CHECK(!problem.what.starts_with("the XML cannot be read"));
}

/// Checks that an accepted cell has the properties on which other code relies.
void check_cell(const takt::model::Cell& cell) {
  using namespace takt::model;
  TAKT_CHECK(validate(cell).empty());
  TAKT_CHECK(cell.connections.size() <= kMaxConnections);
  std::size_t of_services = 0;
  for (const Connection& connection : cell.connections) {
    if (connection.carries != Carries::samples) {
      ++of_services;
      TAKT_CHECK(connection.from.given() && connection.to.given());
      TAKT_CHECK(is_valid_topic(topic_of(cell, connection)));
      continue;
    }
    TAKT_CHECK(connection.from.given() || connection.to.given());
    for (const Endpoint* end : {&connection.from, &connection.to}) {
      TAKT_CHECK(end->given() == is_valid_name(end->device));
      TAKT_CHECK(end->given() == is_valid_name(end->module));
      TAKT_CHECK(end->given() == is_valid_name(end->port));
    }
    const bool outside = !connection.from.given() || !connection.to.given();
    const bool on_dds =
        outside || connection.from.device != connection.to.device || !connection.topic.empty();
    TAKT_CHECK(!outside || !connection.topic.empty());
    TAKT_CHECK(!on_dds || is_valid_topic(topic_of(cell, connection)));
    TAKT_CHECK(connection.stale == Stale::hold || (connection.deadline && connection.to.given()));
  }
  TAKT_CHECK(of_services == 2 * cell.services.size());
  for (const Device& device : cell.devices) {
    for (const Module& module : device.modules) {
      const bool sporadic = module.operation == Operation::sporadic;
      TAKT_CHECK(sporadic || (module.dispatch == Dispatch::row && module.miss == Miss::count));
      TAKT_CHECK(sporadic || !module.interarrival);
      TAKT_CHECK(!module.interarrival || module.interarrival->count() > 0);
      const bool periodic = module.operation == Operation::periodic;
      TAKT_CHECK(periodic || (!module.offset && !module.overrun));
      TAKT_CHECK(!module.offset || (module.offset->count() >= 0 && *module.offset < *module.period));
      const OverrunContract contract = contract_of(device, module);
      TAKT_CHECK(contract.limit >= 1 && contract.limit <= kMaxCatchUp);
      TAKT_CHECK(periodic || contract.what == Overrun::skip);
    }
  }
  const bool server = cell.discovery.kind == Discovery::Kind::server;
  TAKT_CHECK(server == is_valid_server(cell.discovery.server));
  TAKT_CHECK(server || cell.server_device.empty());
  TAKT_CHECK((cell.discovery.kind == Discovery::Kind::peers) == !cell.discovery.peers.empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view xml{reinterpret_cast<const char*>(data), size};
  int last_line = 1;
  for (const char c : xml) last_line += c == '\n' ? 1 : 0;

  const auto cell = takt::descriptor::parse(xml, "fuzz.xml");
  if (cell) {
    check_cell(*cell);
    return 0;
  }
  TAKT_CHECK(!cell.problems().empty() && cell.problems().size() <= takt::model::kMaxProblems);
  for (const takt::Problem& problem : cell.problems())
    check_problem(problem, last_line, xml.find("<bundle") != std::string_view::npos);
  return 0;
}
