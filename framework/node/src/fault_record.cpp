#include <takt/node/fault_record.hpp>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <numeric>
#include <type_traits>

#include <takt/core/fixed_text.hpp>
#include <takt/core/words.hpp>
#include <takt/os/files.hpp>
#include <takt/wire/words.hpp>

namespace takt::node {

namespace {

/// The size of the file's header: a whole page, so that no slot crosses a page boundary.
constexpr std::size_t kHeaderBytes = 4096;
constexpr std::size_t kMostSlots = 65536;
constexpr std::size_t kMostRecordBytes = kHeaderBytes + kMostSlots * kSlotBytes;

struct Header {
  std::uint64_t magic;
  std::uint64_t slots;
  std::uint64_t checksum;
};
constexpr std::uint64_t kMagic = 0x7461'6b74'666c'0001;  // "taktfl", layout 1

struct Slot {
  std::uint64_t checksum;  ///< checksum of all members below
  std::uint64_t sequence;
  std::int64_t time_ns;
  std::uint64_t cycle;
  std::uint64_t count;
  std::uint32_t kind;
  std::uint32_t unused;
  FixedText<16> error;
  FixedText<64> cell;
  FixedText<64> device;
  FixedText<64> module;
  FixedText<512> cause;
  FixedText<256> attachment;
};
static_assert(sizeof(Slot) == kSlotBytes && std::is_trivially_copyable_v<Slot>);

// Computes FNV-1a. If any one byte changes, the checksum changes.
std::uint64_t record_checksum(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

std::string_view bytes_after_checksum(const Slot& slot) {
  return {reinterpret_cast<const char*>(&slot) + sizeof slot.checksum, sizeof slot - sizeof slot.checksum};
}

std::string encode_header(std::size_t slots) {
  Header header{.magic = kMagic, .slots = slots, .checksum = 0};
  header.checksum = record_checksum({reinterpret_cast<const char*>(&header), offsetof(Header, checksum)});
  return {reinterpret_cast<const char*>(&header), sizeof header};
}

Result<std::size_t> decode_header(std::string_view content) {
  const auto not_a_record =
      fail("is not a fault record", "name the file DEVICE.DOMAIN.faults in the --state-dir of a node");
  const auto other =
      fail("is not a fault record of this version", "read it with the version of Takt that wrote it");
  Header header{};
  if (content.size() < sizeof header) return not_a_record;
  std::memcpy(&header, content.data(), sizeof header);
  if (header.magic >> 16U != kMagic >> 16U) return not_a_record;
  if (header.magic != kMagic || header.slots == 0 || header.slots > kMostSlots ||
      header.checksum !=
          record_checksum({reinterpret_cast<const char*>(&header), offsetof(Header, checksum)}))
    return other;
  return static_cast<std::size_t>(header.slots);
}

bool is_zero(std::string_view bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](char c) { return c == 0; });
}

/// The highest number that a valid event can have. No device ever has so many events. A higher number must be
/// forged, and would leave no number for the next event.
constexpr std::uint64_t kMostEvents = std::uint64_t{1} << 62U;

std::size_t offset_of(std::size_t slot) { return kHeaderBytes + slot * kSlotBytes; }

}  // namespace

std::string encode_slot(const model::Fault& fault) {
  Slot slot{};
  slot.sequence = fault.sequence;
  slot.time_ns = fault.time_ns;
  slot.cycle = fault.cycle;
  slot.count = fault.count;
  slot.kind = static_cast<std::uint32_t>(fault.kind);
  const auto put = [](auto& field, const std::string& text) {
    field.assign(wire::cut(text, sizeof field - 1));
  };
  put(slot.error, fault.error);
  put(slot.cell, fault.cell);
  put(slot.device, fault.device);
  put(slot.module, fault.module);
  put(slot.cause, fault.cause);
  put(slot.attachment, fault.attachment);
  slot.checksum = record_checksum(bytes_after_checksum(slot));
  return {reinterpret_cast<const char*>(&slot), sizeof slot};
}

std::optional<model::Fault> decode_slot(std::string_view bytes) {
  Slot slot{};
  if (bytes.size() != sizeof slot) return std::nullopt;
  std::memcpy(&slot, bytes.data(), sizeof slot);
  if (slot.sequence == 0 || slot.kind >= model::kFaultKinds ||
      slot.checksum != record_checksum(bytes_after_checksum(slot)))
    return std::nullopt;
  const auto text = [](const auto& field) { return std::string{field.view()}; };
  return model::Fault{.sequence = slot.sequence,
                      .time_ns = slot.time_ns,
                      .cell = text(slot.cell),
                      .device = text(slot.device),
                      .module = text(slot.module),
                      .kind = static_cast<model::FaultKind>(slot.kind),
                      .error = text(slot.error),
                      .cause = text(slot.cause),
                      .attachment = text(slot.attachment),
                      .count = slot.count,
                      .cycle = slot.cycle};
}

namespace {

/// The content of a file, with the slots that hold it.
struct Slots {
  Recorded recorded;
  std::vector<std::size_t> places;  ///< the slot of each event
  std::vector<std::size_t> free;    ///< the slots without a valid event, highest first
  bool torn = false;  ///< true if the write of a slot was interrupted, or its bytes were damaged
};

Slots read_slots(std::string_view content, std::size_t slots) {
  Slots read;
  std::vector<std::pair<model::Fault, std::size_t>> found;
  for (std::size_t i = slots; i-- > 0;) {
    const std::size_t at = offset_of(i);
    const std::string_view slot = at < content.size() ? content.substr(at, kSlotBytes) : std::string_view{};
    auto fault = decode_slot(slot);
    if (fault && fault->sequence <= kMostEvents) {
      found.emplace_back(std::move(*fault), i);
      continue;
    }
    read.free.push_back(i);
    if (is_zero(slot)) continue;
    ++read.recorded.damaged;
    read.torn |= !fault;
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::pair{a.first.sequence, a.second} < std::pair{b.first.sequence, b.second};
  });
  for (auto& [fault, place] : found) {
    if (!read.recorded.events.empty() && read.recorded.events.back().sequence == fault.sequence) {
      read.free.push_back(place);
      ++read.recorded.damaged;
      continue;
    }
    read.recorded.events.push_back(std::move(fault));
    read.places.push_back(place);
  }
  if (!found.empty() && read.recorded.events.back().sequence > slots)
    read.recorded.overwritten = read.recorded.events.back().sequence - slots;
  return read;
}

std::vector<std::size_t> all_free(std::size_t slots) {
  std::vector<std::size_t> free(slots);
  std::iota(free.rbegin(), free.rend(), std::size_t{0});
  return free;
}

}  // namespace

Result<Recorded> read_record(std::string_view content) {
  const auto slots = decode_header(content);
  if (!slots) return slots.problems();
  return read_slots(content, *slots).recorded;
}

Result<Recorded> read_record_file(const std::string& path) {
  const auto content = os::read_file(path, kMostRecordBytes);
  if (!content) return content.problems();
  if (!*content)
    return Problem{path, "there is no such file",
                   "a node's record is the file DEVICE.DOMAIN.faults in its --state-dir"};
  auto recorded = read_record(**content);
  if (recorded) return recorded;
  Problem problem = recorded.problems()[0];
  problem.where = path;
  return problem;
}

std::string FaultRecord::path(const std::string& folder, const std::string& device, int domain) {
  return folder + "/" + device + "." + std::to_string(domain) + ".faults";
}

FaultRecord::FaultRecord(std::size_t slots) : slots_(slots), free_(all_free(slots)) {}

FaultRecord FaultRecord::open(const std::string& path, std::size_t slots) {
  FaultRecord record{slots};
  record.wanted_ = path;
  if (auto taken = record.attach(path); !taken) {
    record.file_.reset();
    for (Problem problem : taken.problems()) record.problems_.push_back(std::move(problem));
    return record;
  }
  record.path_ = path;
  return record;
}

Result<void> FaultRecord::attach(const std::string& path) {
  auto file = os::FixedFile::open(path);
  if (!file) return file.problems();
  auto content = file->read(kMostRecordBytes);
  if (!content) return content.problems();
  // If a node died while it created the file, the file has no header.
  const bool empty = is_zero(*content);
  const auto there = decode_header(*content);
  if (!there && !empty) {
    const std::string aside = path + ".damaged";
    if (auto renamed = file->rename(aside); !renamed) return renamed;
    problems_.push_back({path, there.problems()[0].what, "it was renamed to " + aside});
    file = os::FixedFile::open(path);
    if (!file) return file.problems();
  }
  if (there) slots_ = *there;
  if (auto reserved = file->reserve(kHeaderBytes + slots_ * kSlotBytes); !reserved) return reserved;
  if (!there) {
    if (auto written = file->write(0, encode_header(slots_)); !written) return written;
  }
  file->sync();
  if (!there) content = std::string{};
  Slots read = read_slots(*content, slots_);
  recorded_ = std::move(read.recorded);
  places_ = std::move(read.places);
  free_ = std::move(read.free);
  if (!recorded_.events.empty()) next_ = recorded_.events.back().sequence + 1;
  // An incomplete slot may be that of the next event, because the node died while it wrote this slot. Do not
  // use the number of this event again, so that it counts as missing.
  if (read.torn) ++next_;
  file_ = std::make_shared<os::FixedFile>(std::move(*file));
  return {};
}

bool FaultRecord::reopen() {
  if (file_ || wanted_.empty()) return false;
  const bool begun = opening_.valid();
  if (begun && opening_.wait_for(std::chrono::seconds{0}) != std::future_status::ready) return false;
  const auto opened = begun ? opening_.get() : nullptr;
  if (!opened || !opened->file_) {
    begin_to_open();
    return false;
  }
  FaultRecord& other = *opened;
  const auto& theirs = other.recorded_.events;
  const auto& ours = recorded_.events;
  // The first event that the file does not have.
  auto from = std::find_if(ours.begin(), ours.end(), [&](const model::Fault& fault) {
    return theirs.empty() || fault.sequence > theirs.back().sequence;
  });
  const bool goes_on = (from == ours.begin() && from != ours.end()) || theirs.empty() ||
                       std::any_of(ours.begin(), from, [&](const model::Fault& fault) {
                         return std::find(theirs.begin(), theirs.end(), fault) != theirs.end();
                       });
  if (!goes_on) from = ours.begin();
  for (; from != ours.end(); ++from) {
    model::Fault fault = *from;
    if (goes_on) other.next_ = fault.sequence;
    other.append(fault);
  }
  if (goes_on) other.next_ = next_;
  if (!other.file_) return false;
  other.worker_ = std::move(worker_);
  other.kept_ = std::move(kept_);
  *this = std::move(other);
  return true;
}

void FaultRecord::begin_to_open() {
  if (!has_worker()) return;
  auto open_it = std::make_shared<std::packaged_task<std::unique_ptr<FaultRecord>()>>(
      [path = wanted_, slots = slots_] { return std::make_unique<FaultRecord>(open(path, slots)); });
  opening_ = open_it->get_future();
  worker_->add([open_it] { (*open_it)(); });
}

void FaultRecord::begin_sync() {
  if (file_ && has_worker() && worker_->is_idle()) worker_->add([file = file_] { file->sync(); });
}

bool FaultRecord::has_worker() {
  if (!worker_) {
    if (auto worker = Worker::start("takt-record")) worker_ = std::move(*worker);
  }
  return worker_ != nullptr;
}

void FaultRecord::sync() const {
  if (file_) file_->sync();
}

// Returns the event that a new event replaces in a full record. Log lines replace log lines, and other events
// replace other events, unless the new event's class has less than half of the slots.
std::size_t FaultRecord::replaced_by(const model::Fault& fault) const {
  const auto& events = recorded_.events;
  const bool is_line = model::is_log_line(fault.kind);
  const auto same = [is_line](const model::Fault& each) { return model::is_log_line(each.kind) == is_line; };
  const auto number = static_cast<std::size_t>(std::count_if(events.begin(), events.end(), same));
  const bool own = 2 * number >= events.size();
  const auto replaceable = [&](const model::Fault& each) { return same(each) == own; };
  auto oldest = std::find_if(events.begin(), events.end(), [&](const model::Fault& each) {
    return replaceable(each) && std::find(kept_.begin(), kept_.end(), each.sequence) == kept_.end();
  });
  if (oldest == events.end()) oldest = std::find_if(events.begin(), events.end(), replaceable);
  return static_cast<std::size_t>(oldest - events.begin());
}

void FaultRecord::append(model::Fault& fault) {
  fault.sequence = next_++;
  const std::string slot = encode_slot(fault);
  if (free_.empty()) {
    const auto replaced = static_cast<std::ptrdiff_t>(replaced_by(fault));
    free_.push_back(places_[static_cast<std::size_t>(replaced)]);
    places_.erase(places_.begin() + replaced);
    recorded_.events.erase(recorded_.events.begin() + replaced);
  }
  const std::size_t place = free_.back();
  free_.pop_back();
  places_.push_back(place);
  recorded_.events.push_back(*decode_slot(slot));  // decoded, so that it equals the event that readers of the
                                                   // file get
  if (fault.sequence > slots_) recorded_.overwritten = fault.sequence - slots_;
  if (!file_) return;
  if (auto written = file_->write(offset_of(place), slot); !written) {
    problems_ = written.problems();
    file_.reset();
    path_.clear();
  }
}

}  // namespace takt::node
