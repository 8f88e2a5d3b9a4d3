// takt trace: shows what the executors of a device did in the last few seconds, and why rows or modules were
// late.
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/os/files.hpp>
#include <takt/os/output_file.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/ranges.hpp"
#include "commands/target.hpp"
#include "reports/trace_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

constexpr std::size_t kMostBytes = std::size_t{256} << 20;

struct TraceOptions {
  std::string target;
  double seconds = 5;
  std::string output;
  std::string svg;
  bool json = false;
  client::Network network;
};

Result<std::string> read_trace_of_device(const TraceOptions& options) {
  const auto client = connect_to_device(options.network, options.target, "");
  if (!client) return client.problems();
  auto answer =
      client::accepted(client->sender->send({.kind = COMMAND_TRACE,
                                             .device = options.target,
                                             .value = std::to_string(std::llround(options.seconds * 1e9)),
                                             .limit = std::chrono::seconds{10}}));
  if (!answer) return answer.problems();
  return std::move(answer->data);
}

int trace(const TraceOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  auto content = os::read_file(options.target, kMostBytes);
  if (!content) return refuse(content.problems());
  const bool is_file = content->has_value();
  if (!is_file && options.target.find_first_of("/.") != std::string::npos) {
    return refuse({fail(in_quotes(options.target) + " is neither an existing file nor a valid device name",
                        "give the name of a device, without a module, or of a file that takt trace wrote")});
  }
  const auto text = is_file ? Result<std::string>{std::move(**content)} : read_trace_of_device(options);
  if (!text) return refuse(text.problems());
  if (!options.output.empty()) {
    if (const auto written = os::write_output(options.output, *text); !written)
      return refuse(written.problems());
  }
  const auto refuse_target = [&](Problems problems) {
    for (Problem& problem : problems) problem.where = options.target;
    return refuse(problems);
  };
  const nlohmann::ordered_json trace = model::parse_json(*text);
  const auto summary = summary_of(trace);
  if (!summary) return refuse_target(summary.problems());
  if (!options.svg.empty()) {
    const auto drawing = trace_svg(trace);
    if (!drawing) return refuse_target(drawing.problems());
    if (const auto written = os::write_output(options.svg, *drawing); !written)
      return refuse(written.problems());
  }
  return print(options.json ? model::json_text(trace_json_report(*summary)) + "\n"
                            : trace_report(*summary, terminal_style()))
             ? 0
             : 1;
}

}  // namespace

void add_trace(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<TraceOptions>();
  auto* command = app.add_subcommand(
      "trace",
      "Show what the executors of a device did in the last few seconds, and why rows or modules were late");
  command->add_option("DEVICE|FILE", options->target, "a device, or a trace file that takt trace -o wrote")
      ->required();
  command->add_option("--last", options->seconds, "the length of the trace, for a device only (default 5)")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.001, 3600.0));
  command
      ->add_option("-o,--output", options->output,
                   "write the trace to this file; ui.perfetto.dev can read it too")
      ->type_name("FILE");
  command
      ->add_option("--svg", options->svg,
                   "write a drawing (SVG) of the runs over time to this file; best with --last 0.1 or less")
      ->type_name("OUT")
      ->check(svg_file());
  command->add_flag("--json", options->json, "print the summary as one JSON object");
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return trace(*options); }; });
}

}  // namespace takt::tool
