// takt record: records the samples of ports to a file.
#include <memory>

#include <takt/recording/recorder.hpp>

#include "commands/commands.hpp"
#include "commands/network_options.hpp"
#include "commands/ranges.hpp"
#include "terminal/progress.hpp"

namespace takt::tool {

void add_record(CLI::App& app, Chosen& chosen) {
  struct Options {
    recording::RecordOptions record;
    double seconds = 0;
    double megabytes = 1000;
    double flush = 0.5;
  };
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("record", "Record the samples of ports to an SQLite file, until Ctrl-C");
  command->add_option("PORT", options->record.ports, "DEVICE.MODULE.PORT; * matches any characters")
      ->required();
  command->add_option("--out", options->record.recording.file, "the file to write")
      ->type_name("FILE")
      ->required();
  command->add_flag("--append", options->record.recording.append, "append to an existing recording");
  auto* limit = command->add_option("--for", options->seconds, "end after this many seconds")
                    ->type_name("SECONDS")
                    ->check(within(0.001, 1e9));
  command
      ->add_option("--max-size", options->megabytes,
                   "the maximum size of the recording on the disk, at least 1 MB; 0: no limit")
      ->type_name("MB")
      ->check(within(0, 1e9))
      ->capture_default_str();
  command
      ->add_option("--full", options->record.recording.full,
                   "what to do at the maximum size: stop, or drop the oldest samples (default stop)")
      ->type_name("stop|oldest")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, recording::Full>{{"stop", recording::Full::stop},
                                                                         {"oldest", recording::Full::oldest}})
              .description(""));
  command->add_option("--flush", options->flush, "the maximum time until a sample is written to the disk")
      ->type_name("SECONDS")
      ->check(within(0.01, 3600))
      ->capture_default_str();
  add_network_options(*command, options->record.network);
  command->callback([options, limit, &chosen] {
    chosen = [options, for_seconds = limit->count() != 0] {
      recording::RecordOptions& record_options = options->record;
      if (for_seconds) record_options.seconds = options->seconds;
      record_options.recording.max_bytes = static_cast<std::uint64_t>(options->megabytes * 1e6);
      record_options.recording.flush = Nanoseconds{static_cast<std::int64_t>(options->flush * 1e9)};
      Progress progress;
      if (progress.is_seen()) {
        record_options.progress = [&progress](const std::string& text) {
          if (text.empty()) return progress.clear();
          progress.show(text);
        };
      }
      return record(record_options);
    };
  });
}

}  // namespace takt::tool
