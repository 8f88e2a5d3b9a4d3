// Where samples come in. A connection says whether the port holds the latest value or a queue of them;
// reading is the same:
//
//   takt::InPort<motion::JointState> measured{*this, "measured"};
//   ...
//   if (measured.read()) ...              the next sample, if one has come
//   use(measured.value().position());     the last one that was read
//
// A module that is loaded again, after a crash or a reset, has the value() that was read last, where it comes
// from another process or the executor has a host of its own; read() goes on behind that.
// Where the output has a safe value, that comes like a sample as soon as what came last is not to be trusted
// any more: its module does not execute, its device is lost, or it is older than the connection's deadline.
//
// Everything but the constructor is for every hook, also on the real-time thread: it neither waits nor
// allocates. One thread at a time, as the hooks are called.
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

/// The part that does not depend on the type.
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

  /// A sample was read at some time, or the safe value; value() is the last one.
  [[nodiscard]] bool has_value() const noexcept { return sequence_ != 0 || is_safe_; }
  /// The last read() found a sample, or the safe value took its place.
  [[nodiscard]] bool is_new() const noexcept { return is_new_; }
  /// value() is the safe value of the output that the port is connected to. sequence() and age() are then
  /// those of the last sample that came.
  [[nodiscard]] bool is_safe() const noexcept { return is_safe_; }
  /// Of value(): the number that its writer gave it, counted from 1; a gap tells of samples that were
  /// dropped. 0 before the first. Each connection to the port counts its own.
  [[nodiscard]] std::uint64_t sequence() const noexcept { return sequence_; }
  /// Of value(): from the beginning of the run() that wrote it to the beginning of this one; never negative.
  /// Nanoseconds::max() before the first. From another device it includes the way.
  [[nodiscard]] Nanoseconds age() const noexcept {
    if (!has_value()) return Nanoseconds::max();
    return Nanoseconds{std::max<std::int64_t>(context().start_ns - stamp_ns_, 0)};
  }

 protected:
  using PortBase::PortBase;

  struct Source {
    channel::LinkReader reader;
    const void* values = nullptr;  ///< null: bytes
    bool latest = false;           ///< of a link with several places: only the newest valid sample counts
  };
  /// What is no sample is passed over, but not for ever.
  static constexpr int kMostRefused = 16;

  /// Null, or where a former instance of the module read its last value, which is still there: bytes outlive
  /// a process, objects do not. An event is not to come twice, nor one of a queue.
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
  /// take_over() but for the value.
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
  /// value() lies in the memory of the link, where both instances find it.
  [[nodiscard]] bool value_is_shared() const noexcept {
    return sequence_ != 0 && !is_safe_ && sources_[taken_from_].values != nullptr;
  }
  /// The link whose samples a safe value may stand in for; none where no output with one is connected.
  [[nodiscard]] const channel::Link& watched() const noexcept { return watched_; }
  /// After the newest sample was taken, where there was one: whether the safe value, which must be known,
  /// holds in its place from now on.
  void settle(bool found) noexcept {
    const bool was_safe = is_safe_;
    is_safe_ = distrusted() || (was_safe && !found);
    is_new_ = is_safe_ ? !was_safe : found;
  }

  /// The connection that the next sample came from, each in turn; null: there is none. The sample is taken.
  Source* take() noexcept {
    for (std::size_t n = sources_.size(); n > 0; --n) {
      Source& source = sources_[turn_];
      if (++turn_ == sources_.size()) turn_ = 0;
      if (!source.reader.take(context().start_ns)) continue;
      // The link of a latest value has several places where its writer's samples become valid later.
      while (source.latest && source.reader.take(context().start_ns)) continue;
      taken_from_ = static_cast<std::size_t>(&source - sources_.data());
      return &source;
    }
    return nullptr;
  }
  /// Which connection take() came upon, in the order in which they were connected.
  [[nodiscard]] std::size_t taken_from() const noexcept { return taken_from_; }
  void begin_read() noexcept { is_new_ = false; }
  void accept(const channel::SampleInfo& info) noexcept {
    is_new_ = true;
    sequence_ = info.sequence;
    stamp_ns_ = info.stamp_ns;
    if (direction() == PortDirection::event) record(channel::FlightKind::event);
  }
  /// Counts a sample that was taken last and came too late to be of use.
  void count_late() noexcept {
    if (sources_.empty()) return;
    auto& late = sources_[taken_from_].reader.link().block().late;
    late.store(late.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  static void refuse(Source& source) noexcept {
    auto& refused = source.reader.link().block().refused;
    refused.store(refused.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

 private:
  /// The last sample that was taken is not to be given to anybody: it was written while its module did not
  /// execute, or that has stopped since, or it is too old; or there was none yet.
  [[nodiscard]] bool distrusted() const noexcept {
    if (sequence_ < watched_.trusted_from()) return true;  // SYNC: trusted
    const std::int64_t deadline = watched_.block().deadline_ns;
    return deadline > 0 && context().start_ns - stamp_ns_ > deadline;
  }

  std::vector<Source> sources_;
  std::vector<Source> aside_;  // in place of these, while the port stands by
  channel::Link watched_;
  bool is_safe_ = false;
  std::size_t turn_ = 0;
  std::size_t taken_from_ = 0;
  std::uint64_t sequence_ = 0;
  std::int64_t stamp_ns_ = 0;
  bool is_new_ = false;
};

/// T is a struct of an IDL file, see takt_add_idl().
template <class T>
class InPort : public InPortBase {
 public:
  using Options = PortOptions;

  /// Of a component: a member of it.
  InPort(Component& owner, std::string name, Options options = {})
      : InPort(&owner, std::move(name), PortDirection::in, std::move(options)) {}
  /// Of a program: a global variable, or one that is there before initPeriodExe() or initSporadicExe().
  explicit InPort(std::string name, Options options = {})
      : InPort(nullptr, std::move(name), PortDirection::in, std::move(options)) {}

  /// Goes on to the next sample: the newest of a connection that holds the latest value, the oldest of a
  /// queue. False when none has come since; value() stays as it is then. The safe value comes like a sample:
  /// once, when it takes the place of what was there.
  bool read() noexcept {
    const bool found = next();
    if (!watched() || !know_safe()) return found;
    settle(found);
    if (is_safe()) value_ = safe_.get();
    return is_new();
  }

  /// The last sample that was read, or the safe value; T{} before the first. The reference is good until the
  /// next read().
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
      own_[0] = other.value();  // it has the room: it was decoded into such a one
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
    T& other = value_ == own_.data() ? own_[1] : own_[0];  // what is no sample must not spoil the last one
    const channel::LinkReader& reader = source.reader;
    if (!PortType<T>::decode(reader.link().payload(reader.buffer()), reader.info().size, other)) return false;
    value_ = &other;
    return true;
  }

  /// Decoded when it is needed for the first time: that of another device comes when the cell begins to run.
  bool know_safe() noexcept {
    if (safe_known_) return true;
    const auto bytes = watched().safe();
    safe_known_ =
        !bytes.empty() && PortType<T>::decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), *safe_);
    return safe_known_;
  }

  std::array<T, 2> own_{};   // decoded from bytes in turn
  std::unique_ptr<T> safe_;  // null where no output with a safe value is connected
  bool safe_known_ = false;
  const T* value_ = own_.data();
};

}  // namespace takt
