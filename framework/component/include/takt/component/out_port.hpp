// takt::OutPort: an output of a component.
//
//   takt::OutPort<motion::JointEffort> effort{*this, "effort"};
//   ...
//   effort.write(value);
//
// An output can have a safe value. Readers get the safe value while this module does not execute, or if the
// last sample is too old:
//
//   takt::OutPort<motion::JointEffort> effort{*this, "effort", {.safe = motion::JointEffort{}}};
//
// write() sends the sample to every connected reader; without a reader, it does nothing. write() never waits:
// a slow reader loses its oldest samples, and the connection counts the lost samples.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <takt/component/owner.hpp>
#include <takt/component/port.hpp>
#include <takt/core/check.hpp>

namespace takt {

/// The result of OutPort::write().
enum class Written {
  yes,    ///< the value was sent to every connected reader, or no reader is connected
  unfit,  ///< the value was sent to no reader, and counted, because a string or sequence exceeds its bound or
          ///< an enumerator is invalid
};

/// The options of an output.
template <class T>
struct OutPortOptions {
  std::string text{};  ///< one sentence for `takt describe`
  /// The safe value: what readers of the latest value get if the last sample is not trusted. A descriptor may
  /// set a different safe value.
  std::optional<T> safe{};
};

/// The part of OutPort that does not depend on the type of the samples.
class OutPortBase : public PortBase {
 public:
  [[nodiscard]] bool connected() const noexcept override {
    const std::vector<Sink>& sinks = sinks_.empty() ? aside_ : sinks_;
    return std::any_of(sinks.begin(), sinks.end(), [](const Sink& sink) { return sink.enabled(); });
  }
  [[nodiscard]] const std::vector<std::byte>& safe() const noexcept override { return safe_; }
  void take_over(PortBase& port) noexcept override {
    auto& before = static_cast<OutPortBase&>(port);
    before.sinks_.swap(before.aside_);
    if (sinks_.empty()) sinks_.swap(aside_);
    for (Sink& sink : sinks_) sink.writer.attach();
  }

 protected:
  using PortBase::PortBase;

  struct Sink {
    channel::LinkWriter writer;
    void* values = nullptr;  ///< the C++ objects of the link; null: the link carries bytes
    [[nodiscard]] bool enabled() const noexcept {
      return writer.link().block().enabled.load(std::memory_order_relaxed) != 0;
    }
    [[nodiscard]] std::byte* payload() const noexcept { return writer.link().payload(writer.buffer()); }
  };

  void set_safe(std::vector<std::byte> bytes) noexcept { safe_ = std::move(bytes); }
  void add(channel::Link link, void* values) {
    (attach() == channel::Attach::now ? sinks_ : aside_)
        .push_back({channel::LinkWriter{link, attach()}, values});
  }
  void publish(Sink& sink, std::uint32_t size) const noexcept {
    sink.writer.publish(size, context().start_ns, context().valid_ns);
    record(channel::FlightKind::write);
    const std::uint32_t wake_bits = sink.writer.link().block().wake_bits;
    if (wake_bits != 0 && context().wake_word != nullptr) context().wake_word->note(wake_bits);
  }

  /// Writes the value into every enabled link. `encode` is called once, and its bytes are copied into every
  /// link that carries bytes. `assign` copies the value into a link that carries C++ objects.
  template <class Encode, class Assign>
  Written write_all(const Encode& encode, const Assign& assign) noexcept {
    const std::byte* bytes = nullptr;
    std::uint32_t size = 0;
    for (Sink& sink : sinks_) {
      if (!sink.enabled()) continue;
      if (sink.values != nullptr) {
        assign(sink.values, sink.writer.buffer());
        publish(sink, 0);
        continue;
      }
      if (bytes == nullptr) {
        size = encode(sink.payload(), sink.writer.link().stride());
        if (size == 0) return refuse();
        bytes = sink.payload();
      } else {
        std::memcpy(sink.payload(), bytes, size);  // readers do not change the buffer to which `bytes` points
      }
      publish(sink, size);
    }
    return Written::yes;
  }
  /// Writes the value into one link. Does nothing if the link has no reader. `index`: links are numbered from
  /// 0, in the order in which they were connected.
  template <class Encode, class Assign>
  Written write_one(std::size_t index, const Encode& encode, const Assign& assign) noexcept {
    if (index >= sinks_.size() || !sinks_[index].enabled()) return Written::yes;
    Sink& sink = sinks_[index];
    std::uint32_t size = 0;
    if (sink.values != nullptr) {
      assign(sink.values, sink.writer.buffer());
    } else if (size = encode(sink.payload(), sink.writer.link().stride()); size == 0) {
      return refuse();
    }
    publish(sink, size);
    return Written::yes;
  }
  Written refuse() noexcept {
    for (const Sink& sink : sinks_) {
      auto& unfit = sink.writer.link().block().unfit;
      unfit.store(unfit.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    }
    return Written::unfit;
  }

 private:
  std::vector<Sink> sinks_;
  std::vector<Sink> aside_;  // the links while the port is standing by; sinks_ is then empty
  std::vector<std::byte> safe_;
};

/// An output for samples of type T, a struct of an IDL file (see takt_add_idl()).
template <class T>
class OutPort : public OutPortBase {
 public:
  /// The options of the output.
  using Options = OutPortOptions<T>;

  /// Constructs an output as a member of a component. Allocates memory, so not for real-time threads. Throws
  /// std::invalid_argument if the safe value does not fit its type: a string or sequence exceeds its bound,
  /// or an enumerator is invalid.
  OutPort(detail::Owner owner, std::string name, Options options = {})
      : OutPort(owner.component(), std::move(name), std::move(options)) {}
  /// Constructs an output in a process module. The output must be a global variable, or must be constructed
  /// before initPeriodExe() or initSporadicExe() is called. Allocates memory. Throws std::invalid_argument if
  /// the safe value does not fit its type.
  explicit OutPort(std::string name, Options options = {})
      : OutPort(nullptr, std::move(name), std::move(options)) {
    static_assert(detail::InProgram<T>,
                  "pass *this as the first argument: takt::OutPort<T> out{*this, \"out\"}; only a program, "
                  "which includes <takt/process.hpp>, omits it");
  }

  /// Sends a value to all connected readers. The stamp of the sample is the start of the current run(). Every
  /// hook may call it. A real-time thread may call it, but only one thread at a time.
  Written write(const T& value) noexcept {
    if (!PortType<T>::fits(value)) return refuse();
    return write_all(encoding(value), assigning(value));
  }

  void connect(channel::Link link, void* values) override {
    TAKT_CHECK(values != nullptr || link.stride() >= PortType<T>::info.max_size);
    add(link, values);
  }
  [[nodiscard]] void* make_values(std::uint32_t number) const override {
    return detail::make_values<T>(number);
  }
  [[nodiscard]] std::size_t value_size() const noexcept override { return sizeof(T); }

 protected:
  OutPort(Component* owner, std::string name, Options options)
      : OutPortBase(owner, std::move(name), PortDirection::out, PortType<T>::info,
                    {.text = std::move(options.text)}) {
    if (!options.safe) return;
    std::vector<std::byte> bytes(PortType<T>::info.max_size);
    bytes.resize(PortType<T>::encode(*options.safe, bytes.data(), static_cast<std::uint32_t>(bytes.size())));
    if (bytes.empty())
      throw std::invalid_argument(
          "the safe value of output '" + this->name() + "' does not fit type " + PortType<T>::info.name +
          ": a string or sequence is longer than its bound, or an enumerator is invalid");
    set_safe(std::move(bytes));
  }
  /// Sends a value to one connected reader. `index`: readers are numbered from 0, in the order of connection.
  Written write_to(std::size_t index, const T& value) noexcept {
    if (!PortType<T>::fits(value)) return refuse();
    return write_one(index, encoding(value), assigning(value));
  }

 private:
  static auto encoding(const T& value) noexcept {
    return
        [&value](std::byte* to, std::uint32_t size) noexcept { return PortType<T>::encode(value, to, size); };
  }
  static auto assigning(const T& value) noexcept {
    return [&value](void* values, std::uint32_t buffer) noexcept { static_cast<T*>(values)[buffer] = value; };
  }
};

}  // namespace takt
