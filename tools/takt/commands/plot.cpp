// takt plot: shows the fields of a recording as a drawing, as CSV, or as statistics.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <takt/client/port_names.hpp>
#include <takt/core/words.hpp>
#include <takt/os/files.hpp>
#include <takt/os/output_file.hpp>
#include <takt/recording/amounts.hpp>
#include <takt/recording/columns.hpp>
#include <takt/recording/csv.hpp>
#include <takt/recording/reader.hpp>
#include <takt/recording/series.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/ranges.hpp"
#include "reports/page.hpp"
#include "reports/plot_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

/// The maximum number of curves in one drawing.
constexpr std::size_t kMostCurves = 200;

struct PlotOptions {
  std::string file;
  std::vector<std::string> fields;  ///< device.module.port[.field]
  std::string svg;
  std::string csv;
  std::optional<double> from;
  std::optional<double> to;
};

/// A column of the output: one field of a port, or one element of such a field.
struct Wanted {
  const recording::PortOfRecording* port;
  std::size_t column;
  std::string name;  ///< device.module.port.field[0]
};

struct Source {
  std::shared_ptr<recording::Columns> columns;
  std::vector<std::size_t> wanted;  ///< the indexes of the port's columns in Choice::wanted
};

struct Choice {
  std::vector<Wanted> wanted;
  std::map<std::int64_t, Source> sources;  ///< for each port, by the port's number in the recording
};

Result<Choice> choose(const recording::Recording& recording, const PlotOptions& options) {
  Choice chosen;
  Problems problems;
  std::vector<std::string_view> paths;
  for (const recording::PortOfRecording& port : recording.ports()) paths.emplace_back(port.path);
  for (const std::string& text : options.fields) {
    std::size_t end = 0;
    for (int dots = 0; end < text.size() && (text[end] != '.' || ++dots < 3);) ++end;
    const std::string path = text.substr(0, end);
    const std::string field = end < text.size() ? text.substr(end + 1) : "";
    bool found = false;
    std::vector<std::string> fields;
    for (const recording::PortOfRecording& port : recording.ports()) {
      if (port.path != path) continue;
      found = true;
      Source& source = chosen.sources[port.id];
      if (!source.columns) source.columns = std::make_shared<recording::Columns>(port.type);
      const std::vector<std::size_t> columns = source.columns->named(field);
      if (columns.empty()) fields = source.columns->fields();
      for (const std::size_t column : columns) {
        const std::string name = path + "." + source.columns->all()[column].name;
        const bool twice = std::any_of(chosen.wanted.begin(), chosen.wanted.end(), [&](const Wanted& w) {
          return w.port == &port && w.column == column;
        });
        if (twice) continue;
        source.wanted.push_back(chosen.wanted.size());
        chosen.wanted.push_back({&port, column, name});
      }
    }
    if (!found)
      problems.push_back(fail("has no port " + in_quotes(path),
                              paths.empty() ? "the recording has no ports" : suggestion(path, paths)));
    else if (!fields.empty())
      problems.push_back(fail("port " + path + " has no field " + in_quotes(field),
                              suggestion(field, {fields.begin(), fields.end()})));
  }
  if (problems.empty()) return chosen;
  for (Problem& problem : problems) problem.where = on_one_line(options.file);
  return problems;
}

class Plotter {
 public:
  Plotter(recording::Recording& recording, const PlotOptions& options, Choice chosen)
      : recording_(recording), options_(options), chosen_(std::move(chosen)) {
    if (options.from) selection_.from_ns = recording.first_ns() + to_ns(*options.from);
    if (options.to) selection_.to_ns = recording.first_ns() + to_ns(*options.to);
    for (const auto& [id, source] : chosen_.sources) selection_.ports.insert(id);
  }

  Result<void> csv() {
    // Leave out an element of a sequence if the sequence is too short for it in all samples.
    std::vector<bool> present(chosen_.wanted.size(), true);
    if (std::any_of(chosen_.sources.begin(), chosen_.sources.end(),
                    [](const auto& each) { return !each.second.columns->fixed(); })) {
      present.assign(present.size(), false);
      auto looked = read([&](const recording::RecordedSample&, const Source& source,
                             const std::vector<recording::Value>& values) {
        for (const std::size_t i : source.wanted)
          if (values[chosen_.wanted[i].column].there()) present[i] = true;
      });
      if (!looked) return looked;
    }
    auto output = os::OutputFile::open_or_standard(options_.csv);
    if (!output) return output.problems();
    std::vector<std::string> line{"time_ns", "seconds"};
    std::vector<std::size_t> place(chosen_.wanted.size(), 0);  // the position of each column in the line
    for (std::size_t i = 0; i < chosen_.wanted.size(); ++i) {
      if (!present[i]) continue;
      place[i] = line.size();
      line.push_back(chosen_.wanted[i].name);
    }
    output->write(recording::csv_line(line));
    const std::size_t cells = line.size();
    auto done = read([&](const recording::RecordedSample& sample, const Source& source,
                         const std::vector<recording::Value>& values) {
      line.assign(cells, "");
      line[0] = std::to_string(sample.time_ns);
      line[1] = fmt::format("{:.9f}", since(sample.time_ns));
      for (const std::size_t i : source.wanted)
        if (present[i]) line[place[i]] = values[chosen_.wanted[i].column].text();
      output->write(recording::csv_line(line));
    });
    auto closed = output->close();
    return done ? closed : done;
  }

  /// Reads the curves for the drawing and the statistics.
  Result<void> gather() {
    bool any = false;
    for (const auto& [id, source] : chosen_.sources) {
      auto times = recording_.times(id, selection_);
      if (!times) return times.problems();
      if (times->empty()) continue;
      const auto [low, high] = std::minmax_element(times->begin(), times->end());
      range_.first_ns = any ? std::min(range_.first_ns, *low) : *low;
      range_.last_ns = any ? std::max(range_.last_ns, *high) : *high;
      any = true;
      pauses_[id] = recording::longest_pause(std::move(*times), 0);
    }
    if (options_.from) range_.first_ns = selection_.from_ns;
    if (options_.to) range_.last_ns = std::max(range_.first_ns, selection_.to_ns);
    if (!any) {
      const bool bounded = options_.from || options_.to;
      return Problem{on_one_line(options_.file),
                     bounded ? "has no samples between --from and --to" : "has no samples of these fields",
                     "see takt play --list"};
    }
    // Break a curve only at pauses longer than a pixel, because a shorter pause would not be visible.
    const std::int64_t pixel =
        (range_.last_ns - range_.first_ns) / static_cast<std::int64_t>(kPlotColumns) + 1;
    for (const Wanted& wanted : chosen_.wanted) {
      const auto pause = pauses_.find(wanted.port->id);
      series_.emplace_back(range_, kPlotColumns,
                           std::max(pixel, pause == pauses_.end() ? pixel : pause->second));
    }
    return read([&](const recording::RecordedSample& sample, const Source& source,
                    const std::vector<recording::Value>& values) {
      missing_[sample.port->id] += sample.missing;
      for (const std::size_t i : source.wanted) {
        const Wanted& wanted = chosen_.wanted[i];
        const bool enumeration = !source.columns->all()[wanted.column].enumerators.empty();
        series_[i].add(sample.time_ns, values[wanted.column].number(enumeration), sample.missing > 0);
      }
    });
  }

  Result<void> svg() {
    Plot plot{.title = recording_.cell().empty() ? options_.file : recording_.cell(),
              .subtitle = "time 0 is " + recording::date_text(recording_.first_ns()),
              .from = since(range_.first_ns),
              .to = since(range_.last_ns)};
    std::size_t curves = 0;
    for (std::size_t i = 0; i < chosen_.wanted.size(); ++i) {
      const Wanted& wanted = chosen_.wanted[i];
      if (series_[i].count() == 0) continue;
      if (++curves > kMostCurves)
        return Problem{on_one_line(options_.file),
                       "a drawing can have at most " + std::to_string(kMostCurves) + " curves",
                       "choose fewer fields, or single elements such as position[0]"};
      const recording::Column& column = column_of(wanted);
      const std::string title = column.field + (column.unit.empty() ? "" : " (" + column.unit + ")");
      auto panel = std::find_if(plot.panels.begin(), plot.panels.end(), [&](const PlotPanel& p) {
        return p.title == title && p.labels == column.enumerators;
      });
      if (panel == plot.panels.end())
        panel = plot.panels.insert(plot.panels.end(), {.title = title, .labels = column.enumerators});
      PlotSeries series{.name = wanted.name};
      for (const auto& curve : series_[i].curves()) {
        auto& points = series.curves.emplace_back();
        for (const recording::SeriesPoint& point : curve)
          points.push_back({since(point.time_ns), point.value});
      }
      panel->series.push_back(std::move(series));
    }
    if (plot.panels.empty())
      return Problem{on_one_line(options_.file), "has no numeric field to draw",
                     "use --csv for fields that are text"};
    return os::write_output(options_.svg, plot_svg(plot));
  }

  int numbers() {
    Page page{terminal_style()};
    std::vector<Page::Words> rows{{"field", "samples", "missing", "min", "mean", "max", "unit", "pauses"}};
    for (std::size_t i = 0; i < series_.size(); ++i) {
      const recording::Series& series = series_[i];
      if (series.count() == 0) continue;
      const recording::Column& column = column_of(chosen_.wanted[i]);
      rows.push_back({chosen_.wanted[i].name, std::to_string(series.count()),
                      std::to_string(missing_[chosen_.wanted[i].port->id]),
                      fmt::format("{:.6g}", series.least()), fmt::format("{:.6g}", series.mean()),
                      fmt::format("{:.6g}", series.largest()), column.unit,
                      std::to_string(series.curves().size() - 1)});
    }
    page.table(0, rows);
    return print(std::move(page).take()) ? 0 : 1;
  }

  [[nodiscard]] std::uint64_t wrong() const { return wrong_; }
  [[nodiscard]] bool cut() const {
    return std::any_of(chosen_.sources.begin(), chosen_.sources.end(),
                       [](const auto& each) { return each.second.columns->cut(); });
  }

 private:
  static std::int64_t to_ns(double seconds) { return static_cast<std::int64_t>(std::llround(seconds * 1e9)); }
  [[nodiscard]] double since(std::int64_t time_ns) const {
    return static_cast<double>(time_ns - recording_.first_ns()) / 1e9;
  }
  [[nodiscard]] const recording::Column& column_of(const Wanted& wanted) const {
    return chosen_.sources.at(wanted.port->id).columns->all()[wanted.column];
  }
  template <class Each>
  Result<void> read(Each each) {
    std::vector<recording::Value> values;
    wrong_ = 0;
    return recording_.read(
        selection_,
        [&](const recording::RecordedSample& sample) {
          const Source& source = chosen_.sources.at(sample.port->id);
          source.columns->values(sample.bytes, sample.size, values);
          each(sample, source, values);
          return true;
        },
        wrong_);
  }

  recording::Recording& recording_;
  const PlotOptions& options_;
  Choice chosen_;
  recording::Selection selection_;
  recording::Series::Range range_;
  std::map<std::int64_t, std::int64_t> pauses_;    // for each port, in ns; a longer pause breaks a curve
  std::map<std::int64_t, std::uint64_t> missing_;  // for each port: number of lost samples
  std::vector<recording::Series> series_;          // one for each column, in the order of Choice::wanted
  std::uint64_t wrong_ = 0;
};

int plot(const PlotOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  if (options.from && options.to && *options.from > *options.to)
    return refuse({fail("--from is after --to", "")});
  auto recording = recording::Recording::open(options.file);
  if (!recording) return refuse(recording.problems());
  auto chosen = choose(*recording, options);
  if (!chosen) return refuse(chosen.problems());
  Plotter plotter{*recording, options, std::move(*chosen)};
  if (plotter.cut())
    std::fprintf(stderr,
                 "takt plot: a port has more columns than the limit of %zu; the other columns are left out\n",
                 recording::Columns::kMost);
  if (!options.csv.empty()) {
    if (const auto done = plotter.csv(); !done) return refuse(done.problems());
  }
  if (!options.svg.empty() || options.csv.empty()) {
    if (const auto done = plotter.gather(); !done) return refuse(done.problems());
    if (!options.svg.empty()) {
      if (const auto done = plotter.svg(); !done) return refuse(done.problems());
    } else if (plotter.numbers() != 0) {
      return 1;
    }
  }
  if (plotter.wrong() == 0) return 0;
  std::fprintf(stderr, "takt plot: %llu damaged samples were left out\n",
               static_cast<unsigned long long>(plotter.wrong()));
  return 1;
}

}  // namespace

void add_plot(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<PlotOptions>();
  auto* command = app.add_subcommand("plot",
                                     "Draw fields of a recording, or write them as CSV; without --svg and "
                                     "--csv, print minimum, mean and maximum");
  command->add_option("FILE", options->file, "a recording made by takt record")->required();
  command
      ->add_option(
          "FIELD", options->fields,
          "DEVICE.MODULE.PORT.FIELD; with FIELD[0], one element; without FIELD, all fields of the port")
      ->required();
  command->add_option("--svg", options->svg, "draw the curves to this file")
      ->type_name("OUT")
      ->check(svg_file());
  command
      ->add_option("--csv", options->csv,
                   "write one line for each sample to this file; - for standard output")
      ->type_name("OUT");
  command
      ->add_option("--from", options->from, "begin this many seconds after the first sample of the recording")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  command->add_option("--to", options->to, "end this many seconds after the first sample of the recording")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  command->callback([options, &chosen] { chosen = [options] { return plot(*options); }; });
}

}  // namespace takt::tool
