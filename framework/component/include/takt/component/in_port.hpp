// takt::InPort: an input of a component. The connection determines whether the port holds the latest value or
// a queue. The code that reads the port is the same in both cases:
//
//   takt::InPort<motion::JointState> measured{*this, "measured"};
//   ...
//   if (measured.read()) ...              takes the next sample, if one has arrived
//   use(measured.value().position());     the sample that was read last
//
// A module that is loaded again after a crash or a reset gets back the value() that it read last, and read()
// continues after that sample. This works if the samples come from another process, or if the executor has
// its own host, because these samples are stored as bytes and not as C++ objects in the host.
//
// If the connected output has a safe value, this value arrives like a sample as soon as the last sample is no
// longer trusted: the writing module does not execute, its device is lost, or the sample is older than the
// connection's deadline.
//
// An operator can force an input that holds the latest value (`takt force`). The forced value then arrives
// like a new sample in each run of the module, until the force ends; then the last sample arrives again.
//
// Every hook may call every function except the constructor, including on the real-time thread: the functions
// neither wait nor allocate. Only one thread at a time may use a port. Takt calls the hooks of a module one
// at a time, so hooks need no lock.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <takt/component/owner.hpp>
#include <takt/component/port.hpp>

namespace takt {

/// The part of InPort that does not depend on the type of the samples.
class InPortBase : public PortBase {
 public:
  [[nodiscard]] bool connected() const noexcept override { return !sources_.empty() || !aside_.empty(); }
  [[nodiscard]] std::int64_t news_at() const noexcept override {
    std::int64_t first = channel::kNever;
    for (const Source& source : sources_) first = std::min(first, source.reader.news_at());
    if (may_be_forced()) return forced_news_at(first);
    if (!watched_ || watched_.safe().empty()) return first;
    if (!is_safe_ && distrusted()) return 0;
    return watched_.is_withheld() ? channel::kNever : first;
  }

  /// True if read() has ever taken a sample or the safe value. value() returns the one that was read last. A
  /// real-time thread may call it.
  [[nodiscard]] bool has_value() const noexcept { return sequence_ != 0 || is_safe_ || is_forced(); }
  /// True if the last read() took a new sample or replaced the last sample by the safe value. A real-time
  /// thread may call it.
  [[nodiscard]] bool is_new() const noexcept { return is_new_; }
  /// True if value() is the safe value of the connected output. sequence() and age() then belong to the last
  /// sample that arrived. A real-time thread may call it.
  [[nodiscard]] bool is_safe() const noexcept { return is_safe_ && !is_forced(); }
  /// Returns the sequence number of the last sample that was read; 0 before the first sample. The writer
  /// numbers its samples from 1, separately for each connection. A gap means that the port has not read some
  /// samples. A real-time thread may call it.
  [[nodiscard]] std::uint64_t sequence() const noexcept { return sequence_; }
  /// Returns the age of the last sample that was read: the time from the start of the run() that wrote it to
  /// the start of this run(). Never negative; Nanoseconds::max() before the first sample. If the sample comes
  /// from another device, the age includes the transfer, and is never less than the true age while the clock
  /// of that device is known. A real-time thread may call it.
  [[nodiscard]] Nanoseconds age() const noexcept {
    if (!has_value()) return Nanoseconds::max();
    const std::int64_t stamp_ns = is_forced() ? forced_at_ns_ : stamp_ns_;
    return Nanoseconds{std::max<std::int64_t>(context().start_ns - stamp_ns, 0)};
  }

 protected:
  using PortBase::PortBase;

  /// One connection to the input.
  struct Source {
    channel::LinkReader reader;
    const void* values = nullptr;  ///< the C++ objects of the link; null: the link carries bytes
    bool latest = false;           ///< true: read() takes only the newest valid sample of several slots
  };
  /// The maximum number of invalid samples that one read() skips.
  static constexpr int kMostRefused = 16;

  /// Adds a connection. Returns the connection if a former instance of the module read its last value from
  /// this connection and the value still exists; otherwise returns null. A value that is stored as bytes
  /// outlives the process; a C++ object does not. Always returns null for events and queues, because their
  /// samples must not arrive twice.
  const Source* add(channel::Link link, const void* values) {
    const bool newest = link.block().is_queue == 0;
    const Source source{channel::LinkReader{link, attach()}, values, newest && link.depth() > 1};
    if (link.has_safe_place()) watched_ = link;
    if (link.has_force_place()) {
      forceable_ = link;
      forced_ = &link.block().forced;
    }
    if (attach() == channel::Attach::later) {
      aside_.push_back(source);
      return nullptr;
    }
    const Source& added = sources_.emplace_back(source);
    const channel::SampleInfo info = added.reader.info();
    const bool is_value = newest && direction() != PortDirection::event && values == nullptr;
    return is_value && info.sequence != 0 && info.stamp_ns > stamp_ns_ ? &added : nullptr;
  }
  void take_back(const channel::SampleInfo& info) noexcept {
    sequence_ = info.sequence;
    stamp_ns_ = info.stamp_ns;
  }
  /// Takes over the connections and the state of `before`, the same port of the former instance, but not its
  /// value.
  void follow(InPortBase& before) noexcept {
    before.sources_.swap(before.aside_);
    if (sources_.empty()) sources_.swap(aside_);
    for (Source& source : sources_) source.reader.attach();
    turn_ = before.turn_;
    taken_from_ = before.taken_from_;
    sequence_ = before.sequence_;
    stamp_ns_ = before.stamp_ns_;
    is_safe_ = before.is_safe_;
    is_new_ = false;
  }
  /// True if value() refers to a C++ object of the link. Both the former and the new instance can use this
  /// object.
  [[nodiscard]] bool value_is_shared() const noexcept {
    return sequence_ != 0 && !is_safe_ && sources_[taken_from_].values != nullptr;
  }
  /// The link whose samples may be replaced by a safe value; empty if no connected output has a safe value.
  [[nodiscard]] const channel::Link& watched() const noexcept { return watched_; }
  /// Decides whether the safe value replaces the newest sample from now on. Call this after take(), and only
  /// if the safe value is known. `found`: true if take() found a sample.
  void settle(bool found) noexcept {
    const bool was_safe = is_safe_;
    is_safe_ = distrusted() || (was_safe && !found);
    is_new_ = is_safe_ ? !was_safe : found;
  }

  /// True if value() is the safe value, unless it is a forced value.
  [[nodiscard]] bool shows_safe() const noexcept { return is_safe_; }
  /// True if value() is a forced value.
  [[nodiscard]] bool is_forced() const noexcept { return force_ != 0; }
  /// False if neither the last read() nor the next one has to do with a forced value.
  [[nodiscard]] bool may_be_forced() const noexcept {
    return (forced_->load(std::memory_order_relaxed) | force_) != 0;
  }
  /// Decides whether a forced value replaces the newest sample from now on. Call this after the ordinary
  /// part of read(). `decode` decodes the forced value; it is called once for each force.
  template <class Decode>
  void settle_force(const Decode& decode) noexcept {
    const bool was_forced = is_forced();
    const std::uint32_t before = force_;
    const std::uint32_t number = forceable_.is_forced(context().start_ns) ? forceable_.forced() : 0;
    force_ = number == 0 || number == before || forceable_.read_force(number, decode) ? number : 0;
    if (is_forced()) {
      // At most one sample in each run, so that `while (port.read())` ends.
      is_new_ = force_ != before || forced_at_ns_ != context().start_ns;
      forced_at_ns_ = context().start_ns;
    } else if (was_forced) {
      is_new_ = has_value();
    }
  }
  /// Forgets the forced value, because another instance takes over.
  void drop_force() noexcept { force_ = 0; }

  /// Takes the next sample and returns its connection, or null if there is no sample. Starts with the
  /// connection after the one that had the last sample, so that all connections are read in turn.
  Source* take() noexcept {
    for (std::size_t n = sources_.size(); n > 0; --n) {
      Source& source = sources_[turn_];
      if (++turn_ == sources_.size()) turn_ = 0;
      if (!source.reader.take(context().start_ns)) continue;
      // A link that holds only the latest value has several slots if its writer uses timing="let".
      while (source.latest && source.reader.take(context().start_ns)) continue;
      taken_from_ = static_cast<std::size_t>(&source - sources_.data());
      return &source;
    }
    return nullptr;
  }
  /// The index of the connection that take() returned last. Connections are numbered in the order of their
  /// creation.
  [[nodiscard]] std::size_t taken_from() const noexcept { return taken_from_; }
  void begin_read() noexcept { is_new_ = false; }
  void accept(const channel::SampleInfo& info) noexcept {
    is_new_ = true;
    sequence_ = info.sequence;
    stamp_ns_ = info.stamp_ns;
    if (direction() == PortDirection::event) record(channel::FlightKind::event);
  }
  /// Counts one late sample on the connection of the sample that was taken last.
  void count_late() noexcept {
    if (sources_.empty()) return;
    auto& late = sources_[taken_from_].reader.link().block().late;
    late.store(late.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  /// Counts an invalid sample of this connection.
  static void refuse(Source& source) noexcept {
    auto& refused = source.reader.link().block().refused;
    refused.store(refused.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

 private:
  /// True if the last sample must not be used. This is so if its writer did not execute when it wrote the
  /// sample or does not execute now, if the sample is too old, or if no sample was read yet.
  [[nodiscard]] bool distrusted() const noexcept {
    if (sequence_ < watched_.trusted_from()) return true;
    const std::int64_t deadline = watched_.block().deadline_ns;
    return deadline > 0 && context().start_ns - stamp_ns_ > deadline;
  }

  [[nodiscard]] std::int64_t forced_news_at(std::int64_t sample_at) const noexcept {
    if (!forceable_.is_forced(context().start_ns)) return is_forced() ? 0 : sample_at;
    return forceable_.forced() == force_ && forced_at_ns_ == context().start_ns ? channel::kNever : 0;
  }

  /// For an input that no node can force.
  static inline const std::atomic<std::uint32_t> kNotForced{0};

  std::vector<Source> sources_;
  std::vector<Source> aside_;  // the connections while the port is standing by; sources_ is then empty
  channel::Link watched_;
  channel::Link forceable_;  // the link whose samples may be replaced by a forced value; empty if none
  const std::atomic<std::uint32_t>* forced_ = &kNotForced;  // the number of the force of `forceable_`
  std::uint32_t force_ = 0;                                 // the force whose value value() is; 0: none
  std::int64_t forced_at_ns_ = 0;                           // start of the run that read it last
  bool is_safe_ = false;
  std::size_t turn_ = 0;
  std::size_t taken_from_ = 0;
  std::uint64_t sequence_ = 0;
  std::int64_t stamp_ns_ = 0;
  bool is_new_ = false;
};

/// An input for samples of type T, a struct of an IDL file (see takt_add_idl()).
template <class T>
class InPort : public InPortBase {
 public:
  /// The options of the input.
  using Options = PortOptions;

  /// Constructs an input as a member of a component. Allocates memory, so not for real-time threads.
  InPort(detail::Owner owner, std::string name, Options options = {})
      : InPort(owner.component(), std::move(name), PortDirection::in, std::move(options)) {}
  /// Constructs an input in a process module. The input must be a global variable, or must be constructed
  /// before initPeriodExe() or initSporadicExe() is called. Allocates memory.
  explicit InPort(std::string name, Options options = {})
      : InPort(nullptr, std::move(name), PortDirection::in, std::move(options)) {
    static_assert(detail::InProgram<T>,
                  "pass *this as the first argument: takt::InPort<T> in{*this, \"in\"}; only a program, "
                  "which includes <takt/process.hpp>, omits it");
  }

  /// Takes the next sample: the newest if the connection holds the latest value, the oldest if it is a queue.
  /// Returns false if no sample has arrived since the last read(); value() then stays unchanged. The safe
  /// value arrives like a sample: once, when it replaces the last sample. A real-time thread may call it.
  bool read() noexcept { return may_be_forced() ? read_forced() : read_sample(); }

  /// Returns the value of the last read(): the newest sample, or the safe value if the sample is too old and
  /// the connection has a safe value. Returns T{} before the first sample. The reference is valid until the
  /// next read(). A real-time thread may call it.
  [[nodiscard]] const T& value() const noexcept { return *value_; }

  void connect(channel::Link link, void* values) override {
    if (values == nullptr) {
      for (T& own : own_) PortType<T>::reserve(own);
    }
    if (const Source* before = add(link, values); before != nullptr && decode(*before))
      take_back(before->reader.info());
    safe_known_ = false;
    if (link.has_safe_place()) make(safe_);
    if (link.has_force_place()) make(forced_value_);
  }
  void take_over(PortBase& before) noexcept override {
    auto& other = static_cast<InPort&>(before);
    if (other.is_forced()) other.value_ = other.sample_;
    other.drop_force();
    follow(other);
    if (!has_value()) return;
    if (is_safe() && know_safe()) {
      value_ = safe_.get();
    } else if (value_is_shared()) {
      value_ = other.value_;
    } else {
      own_[0] = other.value();  // does not allocate, because own_ has room for every value of the type
      value_ = own_.data();
    }
  }
  [[nodiscard]] void* make_values(std::uint32_t number) const override {
    return detail::make_values<T>(number);
  }
  [[nodiscard]] std::size_t value_size() const noexcept override { return sizeof(T); }

 protected:
  InPort(Component* owner, std::string name, PortDirection direction, Options options)
      : InPortBase(owner, std::move(name), direction, PortType<T>::info, std::move(options)) {}

 private:
  static void make(std::unique_ptr<T>& value) {
    if (value) return;
    value = std::make_unique<T>();
    PortType<T>::reserve(*value);
  }
  bool read_sample() noexcept {
    const bool found = next();
    if (!watched() || !know_safe()) return found;
    settle(found);
    if (shows_safe()) value_ = safe_.get();
    return is_new();
  }
  /// Takes samples as usual, because their writer must not notice, but shows the forced value.
  bool read_forced() noexcept {
    if (is_forced()) value_ = sample_;
    read_sample();
    sample_ = value_;
    settle_force([this](const std::byte* bytes, std::uint32_t size) noexcept {
      return PortType<T>::decode(bytes, size, *forced_value_);
    });
    if (is_forced()) value_ = forced_value_.get();
    return is_new();
  }
  bool next() noexcept {
    begin_read();
    for (int refused = 0; refused < kMostRefused; ++refused) {
      Source* source = take();
      if (source == nullptr) return false;
      if (source->values != nullptr) {
        value_ = static_cast<const T*>(source->values) + source->reader.buffer();
      } else if (!decode(*source)) {
        refuse(*source);
        continue;
      }
      accept(source->reader.info());
      return true;
    }
    return false;
  }
  bool decode(const Source& source) noexcept {
    T& other = value_ == own_.data() ? own_[1] : own_[0];  // so an invalid sample does not change the last
                                                           // one
    const channel::LinkReader& reader = source.reader;
    if (!PortType<T>::decode(reader.link().payload(reader.buffer()), reader.info().size, other)) return false;
    value_ = &other;
    return true;
  }

  /// Decodes the safe value when it first becomes available. Returns true if the safe value is known. The
  /// safe value of an output on another device arrives only when the cell starts.
  bool know_safe() noexcept {
    if (safe_known_) return true;
    const auto bytes = watched().safe();
    safe_known_ =
        !bytes.empty() && PortType<T>::decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), *safe_);
    return safe_known_;
  }

  std::array<T, 2> own_{};   // two buffers, into which samples are decoded in turn
  std::unique_ptr<T> safe_;  // null if no output with a safe value is connected
  bool safe_known_ = false;
  std::unique_ptr<T> forced_value_;  // null if the input cannot be forced
  const T* value_ = own_.data();
  const T* sample_ = own_.data();  // while the input is forced: the value that it would have otherwise
};

}  // namespace takt
