// takt::InPort: an input of a component. The connection determines whether the port holds the latest value or
// a queue; reading is the same:
//
//   takt::InPort<motion::JointState> measured{*this, "measured"};
//   ...
//   if (measured.read()) ...              takes the next sample, if one has arrived
//   use(measured.value().position());     the sample that was read last
//
// A module that is loaded again after a crash or a reset gets back the value() that it read last, if the
// samples come from another process or if the executor has its own host. read() continues after that sample.
//
// If the connected output has a safe value, this value arrives like a sample as soon as the last sample is no
// longer trusted: the writing module does not execute, its device is lost, or the sample is older than the
// connection's deadline.
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

#include <takt/component/port.hpp>

namespace takt {

/// The part of InPort that does not depend on the type.
class InPortBase : public PortBase {
 public:
  [[nodiscard]] bool connected() const noexcept override { return !sources_.empty() || !aside_.empty(); }
  [[nodiscard]] std::int64_t news_at() const noexcept override {
    std::int64_t first = channel::kNever;
    for (const Source& source : sources_) first = std::min(first, source.reader.news_at());
    if (!watched_ || watched_.safe().empty()) return first;
    if (!is_safe_ && distrusted()) return 0;
    return watched_.is_withheld() ? channel::kNever : first;
  }

  /// Whether a sample or the safe value was ever read; value() is the one that was read last. A real-time
  /// thread may call it.
  [[nodiscard]] bool has_value() const noexcept { return sequence_ != 0 || is_safe_; }
  /// Whether the last read() found a sample, or replaced the last sample by the safe value. A real-time
  /// thread may call it.
  [[nodiscard]] bool is_new() const noexcept { return is_new_; }
  /// Whether value() is the safe value of the connected output. sequence() and age() then belong to the last
  /// sample that arrived. A real-time thread may call it.
  [[nodiscard]] bool is_safe() const noexcept { return is_safe_; }
  /// The number of the last sample that was read. Its writer counts from 1, and each connection to the port
  /// has its own count. A gap means that samples were dropped. 0 before the first sample. A real-time thread
  /// may call it.
  [[nodiscard]] std::uint64_t sequence() const noexcept { return sequence_; }
  /// The age of the last sample that was read: from the start of the run() that wrote it to the start of this
  /// run(). Never negative. Nanoseconds::max() before the first sample. If the sample comes from another
  /// device, the age includes the transfer. A real-time thread may call it.
  [[nodiscard]] Nanoseconds age() const noexcept {
    if (!has_value()) return Nanoseconds::max();
    return Nanoseconds{std::max<std::int64_t>(context().start_ns - stamp_ns_, 0)};
  }

 protected:
  using PortBase::PortBase;

  /// One connection to the input.
  struct Source {
    channel::LinkReader reader;
    const void* values = nullptr;  ///< the link's values; null: the link carries bytes
    bool latest = false;           ///< only the newest valid sample counts, though the link has several slots
  };
  /// How many invalid samples one read() skips at most.
  static constexpr int kMostRefused = 16;

  /// Adds a connection. Returns it if a former instance of the module read its last value from it and that
  /// value still exists; else returns null. A value in bytes outlives its process, an object does not. Events
  /// and samples of a queue must not arrive twice, so for them the function returns null.
  const Source* add(channel::Link link, const void* values) {
    const bool newest = link.block().is_queue == 0;
    const Source source{channel::LinkReader{link, attach()}, values, newest && link.depth() > 1};
    if (link.has_safe_place()) watched_ = link;
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
  /// Takes over everything from `before` except the value.
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
  /// Whether value() is in the memory of the link, where both instances find it.
  [[nodiscard]] bool value_is_shared() const noexcept {
    return sequence_ != 0 && !is_safe_ && sources_[taken_from_].values != nullptr;
  }
  /// The link whose samples may be replaced by a safe value; empty if no connected output has a safe value.
  [[nodiscard]] const channel::Link& watched() const noexcept { return watched_; }
  /// Decides whether the safe value, which must be known, replaces the newest sample from now on. Call it
  /// after take(); `found`: whether take() found a sample.
  void settle(bool found) noexcept {
    const bool was_safe = is_safe_;
    is_safe_ = distrusted() || (was_safe && !found);
    is_new_ = is_safe_ ? !was_safe : found;
  }

  /// Takes the next sample and returns its connection, or null if there is no sample. It asks the connections
  /// in turn.
  Source* take() noexcept {
    for (std::size_t n = sources_.size(); n > 0; --n) {
      Source& source = sources_[turn_];
      if (++turn_ == sources_.size()) turn_ = 0;
      if (!source.reader.take(context().start_ns)) continue;
      // A link of a latest value has several slots if the writer's samples become valid later.
      while (source.latest && source.reader.take(context().start_ns)) continue;
      taken_from_ = static_cast<std::size_t>(&source - sources_.data());
      return &source;
    }
    return nullptr;
  }
  /// The index of the connection that take() returned last, in the order of connecting.
  [[nodiscard]] std::size_t taken_from() const noexcept { return taken_from_; }
  void begin_read() noexcept { is_new_ = false; }
  void accept(const channel::SampleInfo& info) noexcept {
    is_new_ = true;
    sequence_ = info.sequence;
    stamp_ns_ = info.stamp_ns;
    if (direction() == PortDirection::event) record(channel::FlightKind::event);
  }
  /// Counts the sample that was taken last as too late to be of use.
  void count_late() noexcept {
    if (sources_.empty()) return;
    auto& late = sources_[taken_from_].reader.link().block().late;
    late.store(late.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  /// Counts an invalid sample.
  static void refuse(Source& source) noexcept {
    auto& refused = source.reader.link().block().refused;
    refused.store(refused.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

 private:
  /// Whether the last sample must not be used: the writing module did not execute when it wrote the sample or
  /// does not execute now, the sample is too old, or there was no sample yet.
  [[nodiscard]] bool distrusted() const noexcept {
    if (sequence_ < watched_.trusted_from()) return true;  // SYNC: trusted
    const std::int64_t deadline = watched_.block().deadline_ns;
    return deadline > 0 && context().start_ns - stamp_ns_ > deadline;
  }

  std::vector<Source> sources_;
  std::vector<Source> aside_;  // used instead of sources_ while the port stands by
  channel::Link watched_;
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

  /// Constructs an input as a member of a component. It allocates memory, so real-time threads must not call
  /// it.
  InPort(Component& owner, std::string name, Options options = {})
      : InPort(&owner, std::move(name), PortDirection::in, std::move(options)) {}
  /// Constructs an input of a program: a global variable, or a variable that is constructed before
  /// initPeriodExe() or initSporadicExe(). It allocates memory.
  explicit InPort(std::string name, Options options = {})
      : InPort(nullptr, std::move(name), PortDirection::in, std::move(options)) {}

  /// Takes the next sample: the newest if the connection holds the latest value, the oldest if it is a queue.
  /// Returns false if no sample has arrived since the last read(); value() then stays unchanged. The safe
  /// value arrives like a sample: once, when it replaces the last sample. A real-time thread may call it.
  bool read() noexcept {
    const bool found = next();
    if (!watched() || !know_safe()) return found;
    settle(found);
    if (is_safe()) value_ = safe_.get();
    return is_new();
  }

  /// The sample that was read last, or the safe value; T{} before the first. The reference is valid until the
  /// next read(). A real-time thread may call it.
  [[nodiscard]] const T& value() const noexcept { return *value_; }

  void connect(channel::Link link, void* values) override {
    if (values == nullptr) {
      for (T& own : own_) PortType<T>::reserve(own);
    }
    if (const Source* before = add(link, values); before != nullptr && decode(*before))
      take_back(before->reader.info());
    safe_known_ = false;
    if (!link.has_safe_place() || safe_) return;
    safe_ = std::make_unique<T>();
    PortType<T>::reserve(*safe_);
  }
  void take_over(PortBase& before) noexcept override {
    auto& other = static_cast<InPort&>(before);
    follow(other);
    if (!has_value()) return;
    if (is_safe() && know_safe()) {
      value_ = safe_.get();
    } else if (value_is_shared()) {
      value_ = other.value_;
    } else {
      own_[0] = other.value();  // does not allocate: own_ has reserved room for every value of the type
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
    T& other = value_ == own_.data() ? own_[1] : own_[0];  // an invalid sample must not damage the last one
    const channel::LinkReader& reader = source.reader;
    if (!PortType<T>::decode(reader.link().payload(reader.buffer()), reader.info().size, other)) return false;
    value_ = &other;
    return true;
  }

  /// Decodes the safe value when it is needed for the first time. The safe value of another device arrives
  /// only when the cell starts.
  bool know_safe() noexcept {
    if (safe_known_) return true;
    const auto bytes = watched().safe();
    safe_known_ =
        !bytes.empty() && PortType<T>::decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), *safe_);
    return safe_known_;
  }

  std::array<T, 2> own_{};   // samples are decoded into these two in turn
  std::unique_ptr<T> safe_;  // null if no output with a safe value is connected
  bool safe_known_ = false;
  const T* value_ = own_.data();
};

}  // namespace takt
