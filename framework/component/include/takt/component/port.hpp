// PortBase: the part of a port that does not depend on its type. The host or libtakt_process connects a port
// to links, and `takt describe` shows it. Authors use InPort, EventPort and OutPort.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/channel/flight.hpp>
#include <takt/channel/link.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/component/port_type.hpp>
#include <takt/core/time.hpp>

namespace takt {

class Component;

/// The direction of a port.
enum class PortDirection {
  in,     ///< an input
  event,  ///< an input whose samples make a sporadic module ready to run
  out     ///< an output
};
/// Returns "in", "event" or "out".
const char* to_text(PortDirection direction) noexcept;

/// The purpose of a port: plain samples, or one of the two ports of a service or client.
enum class PortRole {
  plain,    ///< samples
  service,  ///< the module answers requests in run()
  handler,  ///< the module answers requests in a handler, on a separate thread
  client,   ///< the module sends requests
};
/// Returns "port", "service", "handler" or "client".
const char* to_text(PortRole role) noexcept;

/// The suffixes of the two ports of a service or client NAME: NAME/request and NAME/reply.
inline constexpr const char* kRequestPort = "/request";
inline constexpr const char* kReplyPort = "/reply";

/// The options of ports and services. Outputs have more options, see OutPortOptions.
struct PortOptions {
  std::string text{};  ///< one sentence for `takt describe`
};

/// The data that the host or libtakt_process passes to all ports of a module that it runs.
struct PortContext {
  /// Monotonic time in ns at which the current run() began: the stamp of written samples, and the time at
  /// which ages are measured.
  std::int64_t start_ns = 0;
  channel::WakeBits* wake_word = nullptr;  ///< used to wake the sleeping readers of links
  /// Monotonic time in ns from which written samples may be read. With timing="let", this is the end of the
  /// writer's period. 0: at once.
  std::int64_t valid_ns = 0;
  /// The flight record, in which the ports record the events that run() reads and the samples that it writes;
  /// null: none.
  channel::FlightWriter* flight = nullptr;
  std::uint32_t module = 0;  ///< index of the module on its device, for `flight`
};

/// The base of every port. Registers itself with its component or process module.
class PortBase {
 public:
  PortBase(const PortBase&) = delete;
  PortBase& operator=(const PortBase&) = delete;
  virtual ~PortBase();

  /// The name of the port.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  /// The direction of the port.
  [[nodiscard]] PortDirection direction() const noexcept { return direction_; }
  /// The purpose of the port.
  [[nodiscard]] PortRole role() const noexcept { return role_; }
  /// The type of the port's samples.
  [[nodiscard]] const TypeInfo& type() const noexcept { return type_; }
  /// The description for `takt describe`; may be empty.
  [[nodiscard]] const std::string& text() const noexcept { return options_.text; }

  /// True if an output is connected to this input, or at least one reader to this output. A real-time thread
  /// may call it.
  [[nodiscard]] virtual bool connected() const noexcept = 0;
  /// True if read() would take a sample or the safe value. A real-time thread may call it.
  [[nodiscard]] bool has_news() const noexcept { return news_at() <= context().start_ns; }
  /// The monotonic time in ns from which read() finds a sample: 0 for at once, channel::kNever if there is no
  /// sample. Any thread may call it, including real-time threads and threads that do not read the port.
  [[nodiscard]] virtual std::int64_t news_at() const noexcept { return channel::kNever; }

  // Only the code that runs the module calls the following functions, and only while the module is not
  // running.

  /// Sets the context of the port. The context must exist as long as the port is used. `place`: index of the
  /// port in its module.
  void serve(const PortContext& context, std::uint32_t place = 0) noexcept {
    context_ = &context;
    place_ = place;
  }
  /// Connects the port to one more link. `values` is null if the link carries bytes. Otherwise the link
  /// itself holds no payloads, and `values` holds one value of the port's type for each buffer. make_values()
  /// of one of the two connected ports created these values.
  virtual void connect(channel::Link link, void* values) = 0;
  /// Makes the port stand by: until take_over() is called, it does not use the links that are connected from
  /// now on, because the same port of another instance of the module uses them.
  void stand_by() noexcept { attach_ = channel::Attach::later; }
  /// Takes over the links of `before`, the same port of another instance of the module. `before` stops using
  /// the links. A real-time thread may call it.
  virtual void take_over(PortBase& before) noexcept = 0;
  /// Creates `number` values, each with memory for the largest sequences, and returns the first. They are
  /// never freed, because the connected port may still read one. Returns null for a port in C form, whose
  /// values are not C++ objects. Allocates memory.
  [[nodiscard]] virtual void* make_values(std::uint32_t number) const = 0;
  /// The size of one value in bytes. It is the same for two ports that may share values.
  [[nodiscard]] virtual std::size_t value_size() const noexcept = 0;
  /// The safe value of an output as CDR, as its author declared it; empty: none.
  [[nodiscard]] virtual const std::vector<std::byte>& safe() const noexcept { return kNoSafe; }

 protected:
  /// `owner`: the component; null in a process module, or in a module in C form that is being loaded.
  PortBase(Component* owner, std::string name, PortDirection direction, const TypeInfo& type,
           PortOptions options);
  void set_role(PortRole role) noexcept { role_ = role; }
  [[nodiscard]] const PortContext& context() const noexcept { return *context_; }
  [[nodiscard]] channel::Attach attach() const noexcept { return attach_; }
  /// Adds an entry to the flight record: run() has read an event or written a sample.
  void record(channel::FlightKind kind) const noexcept {
    const PortContext& context = *context_;
    if (context.flight != nullptr) context.flight->add(kind, context.start_ns, context.module, place_);
  }

 private:
  static const PortContext kNobody;
  static const std::vector<std::byte> kNoSafe;

  std::string name_;
  PortDirection direction_;
  PortRole role_ = PortRole::plain;
  const TypeInfo& type_;
  PortOptions options_;
  bool owned_;
  const PortContext* context_ = &kNobody;
  std::uint32_t place_ = 0;
  channel::Attach attach_ = channel::Attach::now;
};

/// Returns the ports that belong to no component: in a process module, all its ports; in a host, those of the
/// module in C form that this thread has loaded since the last call. Ports that were destroyed before the
/// call are not in the list.
std::vector<PortBase*> take_loose_ports();

namespace detail {
void add_loose_port(PortBase& port);
void remove_loose_port(PortBase& port) noexcept;

template <class T>
void* make_values(std::uint32_t number) {
  T* values = new T[number]{};
  for (std::uint32_t i = 0; i < number; ++i) PortType<T>::reserve(values[i]);
  return values;
}
}  // namespace detail

}  // namespace takt
