// Where samples come in. A connection says whether the port holds the latest value or a queue of them;
// reading is the same:
//
//   takt::InPort<motion::JointState> measured{*this, "measured"};
//   ...
//   if (measured.read()) ...              the next sample, if one has come
//   use(measured.value().position());     the last one that was read
//
// Everything but the constructor is for every hook, also on the real-time thread: it neither waits nor
// allocates. One thread at a time, as the hooks are called.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <takt/component/port.hpp>

namespace takt {

/// The part that does not depend on the type.
class InPortBase : public PortBase {
 public:
  [[nodiscard]] bool connected() const noexcept override { return !sources_.empty(); }
  [[nodiscard]] std::int64_t news_at() const noexcept override {
    std::int64_t first = channel::kNever;
    for (const Source& source : sources_) first = std::min(first, source.reader.news_at());
    return first;
  }

  /// A sample was read at some time; value() is the last one.
  [[nodiscard]] bool has_value() const noexcept { return sequence_ != 0; }
  /// The last read() found a sample.
  [[nodiscard]] bool is_new() const noexcept { return is_new_; }
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

  void add(channel::Link link, const void* values) {
    const bool latest = link.block().is_queue == 0 && link.depth() > 1;
    sources_.push_back({channel::LinkReader{link}, values, latest});
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
  std::vector<Source> sources_;
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
  /// queue. False when none has come since; value() stays as it is then.
  bool read() noexcept {
    begin_read();
    for (int refused = 0; refused < kMostRefused; ++refused) {
      Source* source = take();
      if (source == nullptr) return false;
      const channel::SampleInfo info = source->reader.info();
      const std::uint32_t buffer = source->reader.buffer();
      if (source->values != nullptr) {
        value_ = static_cast<const T*>(source->values) + buffer;
      } else {
        T& other =
            value_ == own_.data() ? own_[1] : own_[0];  // what is no sample must not spoil the last one
        if (!PortType<T>::decode(source->reader.link().payload(buffer), info.size, other)) {
          refuse(*source);
          continue;
        }
        value_ = &other;
      }
      accept(info);
      return true;
    }
    return false;
  }

  /// The last sample that was read; T{} before the first. The reference is good until the next read().
  [[nodiscard]] const T& value() const noexcept { return *value_; }

  void connect(channel::Link link, void* values) override {
    if (values == nullptr) {
      for (T& own : own_) PortType<T>::reserve(own);
    }
    add(link, values);
  }
  [[nodiscard]] void* make_values(std::uint32_t number) const override {
    return detail::make_values<T>(number);
  }
  [[nodiscard]] std::size_t value_size() const noexcept override { return sizeof(T); }

 protected:
  InPort(Component* owner, std::string name, PortDirection direction, Options options)
      : InPortBase(owner, std::move(name), direction, PortType<T>::info, std::move(options)) {}

 private:
  std::array<T, 2> own_{};  // decoded from bytes in turn
  const T* value_ = own_.data();
};

}  // namespace takt
