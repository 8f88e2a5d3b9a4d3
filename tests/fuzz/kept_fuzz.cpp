// Reads arbitrary bytes as a file that a node finds on its disk when it starts: the node's deployment, the
// saved state of a module, or the fault record. If the node accepts a file, writing and reading its content
// must not change the content. New events in an accepted fault record must get higher numbers than its last
// event.
//
// The first letter of an input selects the file (see LLVMFuzzerTestOneInput). If the letter is in lower case,
// the fuzzer adds a correct checksum of the body.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include <takt/channel/saved_state.hpp>
#include <takt/core/check.hpp>
#include <takt/model/safe.hpp>
#include <takt/node/fault_record.hpp>
#include <takt/node/kept_deployment.hpp>
#include <takt/node/retained.hpp>
#include <takt/wire/fault.hpp>
#include <takt/wire/validation.hpp>

#include "bytes.hpp"

namespace {

using namespace takt;

/// A private folder of this process, in memory if possible. A fuzzer that finds a bug aborts without running
/// destructors. So a helper process waits for the end of this process and then removes the folder.
class Folder {
 public:
  Folder() {
    TAKT_CHECK(::pipe(life_) == 0);
    const ::pid_t remover = ::fork();
    TAKT_CHECK(remover >= 0);
    if (remover == 0) {
      ::setsid();  // a signal to the fuzzer's process group must not end the helper
      ::close(life_[1]);
      char none = 0;
      while (::read(life_[0], &none, 1) > 0) continue;  // waits until the fuzzer has ended
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
      ::_exit(0);
    }
    ::close(life_[0]);
    std::filesystem::create_directories(path);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::string path =
      (std::filesystem::is_directory("/dev/shm") ? std::string{"/dev/shm"}
                                                 : std::filesystem::temp_directory_path().string()) +
      "/takt-fuzz-" + std::to_string(::getpid());

 private:
  int life_[2]{};
};

const std::string& folder() {
  static const Folder made;
  return made.path;
}

void put(const std::string& path, std::string_view content) {
  std::ofstream{path, std::ios::binary | std::ios::trunc}.write(content.data(),
                                                                static_cast<std::streamsize>(content.size()));
}

std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

/// Returns the content of a file in the format of node/whole_file.hpp, with a correct checksum.
std::string whole(const std::string& format, std::string_view body) {
  std::array<char, 24> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(checksum(body)));
  return format + " " + digits.data() + "\n" + std::string{body};
}

void check(const Problems& problems) {
  TAKT_CHECK(!problems.empty());
  for (const Problem& problem : problems) TAKT_CHECK(!problem.what.empty());
}

void check_deployment(std::string_view content) {
  const node::DeploymentFile file{folder(), "robot", 7};
  put(file.path(), content);
  const auto kept = file.kept();
  if (!kept) return check(kept.problems());
  TAKT_CHECK(file.keep(*kept));
  const auto again = file.kept();
  // kept() replaces bytes that are not valid UTF-8, and keep() writes the replaced text. So the second kept()
  // returns the same deployment.
  TAKT_CHECK(again && *again == *kept);
  if (kept->current) static_cast<void>(model::parse_safe(kept->current->safe));
}

void check_saved(std::string_view content) {
  const node::SavedFile file{folder(), "cell", "robot", "servo"};
  put(file.path(), content);
  const auto state = std::make_unique<channel::SavedState>();
  if (const auto read = file.read_into(*state); !read) {
    TAKT_CHECK(!state->copy());
    return check(read.problems());
  }
  const auto saved = state->copy();
  TAKT_CHECK(saved && saved->size <= saved->bytes.size());
  TAKT_CHECK(file.write(*saved));
  const auto again = std::make_unique<channel::SavedState>();
  TAKT_CHECK(file.read_into(*again));
  const auto same = again->copy();
  TAKT_CHECK(same && same->version == saved->version && same->size == saved->size);
  TAKT_CHECK(std::memcmp(same->bytes.data(), saved->bytes.data(), saved->size) == 0);
}

void check_record(std::string_view content) {
  const std::string path = folder() + "/robot.7.faults";
  put(path, content);
  const auto recorded = node::read_record(content);
  constexpr std::size_t kSlots = 8;  // number of slots in a new record
  node::FaultRecord record = node::FaultRecord::open(path, kSlots);
  TAKT_CHECK(record.file() == path);
  if (!recorded) {
    check(recorded.problems());
    TAKT_CHECK(record.events().empty());
  } else {
    TAKT_CHECK(record.events() == recorded->events && record.damaged() == recorded->damaged);
    std::uint64_t last = 0;
    for (const model::Fault& fault : recorded->events) {
      TAKT_CHECK(fault.sequence > last);
      last = fault.sequence;
      // encode_slot() shortens a text that has no terminating zero. So this checks only that encoding an
      // event a second time does not change it.
      const auto again = node::decode_slot(node::encode_slot(fault));
      TAKT_CHECK(again && node::decode_slot(node::encode_slot(*again)) == *again);
      static_cast<void>(wire::to_wire(fault));
    }
  }
  const std::uint64_t newest = record.events().empty() ? 0 : record.events().back().sequence;
  // Sequence numbers near the maximum leave no room for the three events that follow here.
  if (newest > (std::uint64_t{1} << 62U) - 3) return;
  for (int i = 1; i <= 3; ++i) {
    model::Fault fault{
        .cell = "cell", .device = "robot", .kind = model::FaultKind::deployed, .cause = "it runs"};
    record.append(fault);
    TAKT_CHECK(record.file() == path && fault.sequence > newest);
    TAKT_CHECK(record.events().back() == fault);
  }
  const auto on_disk = node::read_record_file(path);
  TAKT_CHECK(on_disk && on_disk->events == record.events());
}

/// Returns a fault record with valid checksums, whose events have arbitrary contents.
std::string forged_record(fuzz::Bytes bytes) {
  constexpr std::size_t kHeader = 4096;
  constexpr std::uint64_t kMagic = 0x7461'6b74'666c'0001;
  const std::uint64_t slots = bytes.take<std::uint8_t>();
  std::string content(kHeader + slots * node::kSlotBytes, '\0');
  const auto set = [&content](std::size_t at, std::uint64_t value) {
    std::memcpy(&content[at], &value, sizeof value);
  };
  set(0, kMagic);
  set(8, slots);
  set(16, checksum({content.data(), 16}));
  while (!bytes.empty() && slots > 0) {
    const std::size_t at = kHeader + bytes.take<std::uint8_t>() % slots * node::kSlotBytes;
    const std::string_view body = bytes.take_counted().substr(0, node::kSlotBytes - 8);
    std::memcpy(&content[at + 8], body.data(), body.size());
    set(at, checksum({&content[at + 8], node::kSlotBytes - 8}));
  }
  return content;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view rest{reinterpret_cast<const char*>(data) + 1, size - 1};
  switch (data[0]) {
    case 'd':
      check_deployment(whole("takt deployment 4", rest));
      break;
    case 'D':
      check_deployment(rest);
      break;
    case 's':
      check_saved(whole("takt saved 1", rest));
      break;
    case 'S':
      check_saved(rest);
      break;
    case 'f':
      check_record(forged_record({data + 1, size - 1}));
      break;
    case 'F':
      check_record(rest);
      break;
    default:
      break;
  }
  return 0;
}
