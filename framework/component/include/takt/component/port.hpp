// PortBase: the part of a port that does not depend on its type. The host connects it to links, and `takt
// describe` shows it. Authors use InPort, EventPort and OutPort.
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
/// "in", "event", "out"
const char* to_text(PortDirection direction) noexcept;

/// The purpose of a port: plain samples, or one of the two ports of a service or client.
enum class PortRole {
  plain,    ///< samples
  service,  ///< the module answers requests in run()
  handler,  ///< the module answers requests in a handler, on a thread of its own
  client,   ///< the module sends requests
};
/// "port", "service", "handler", "client"
const char* to_text(PortRole role) noexcept;

/// The suffixes of the two ports of a service or client NAME: NAME/request and NAME/reply.
inline constexpr const char* kRequestPort = "/request";
inline constexpr const char* kReplyPort = "/reply";

/// The options of ports and services. OutPort has more, see OutPortOptions.
struct PortOptions {
  std::string text{};  ///< one sentence for `takt describe`
};

/// What the code that runs a module passes to all ports of the module.
struct PortContext {
  /// Monotonic time in ns at which the current run() began: the stamp of written samples, and the time at
  /// which ages are measured.
  std::int64_t start_ns = 0;
  channel::WakeWord* wake_word = nullptr;  ///< wakes the sleeping readers of links
  /// Monotonic time in ns from which written samples may be read. With timing="let" it is the end of the
  /// period. 0 means at once.
  std::int64_t valid_ns = 0;
  /// Where samples are recorded while run() is called; null: nowhere.
  channel::FlightWriter* flight = nullptr;
  std::uint32_t module = 0;  ///< index of the module on its device, for `flight`
};

/// The base of every port. Registers itself with its component or program.
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

  /// Whether another port is connected: for an input an output, for an output at least one reader. A
  /// real-time thread may call it.
  [[nodiscard]] virtual bool connected() const noexcept = 0;
  /// Whether read() would find a sample. A real-time thread may call it.
  [[nodiscard]] bool has_news() const noexcept { return news_at() <= context().start_ns; }
  /// The monotonic time in ns from which read() finds a sample: 0 for at once, channel::kNever if there is no
  /// sample. Threads other than the reading one may call it too, and so may a real-time thread.
  [[nodiscard]] virtual std::int64_t news_at() const noexcept { return channel::kNever; }

  // Only the code that runs the module calls the following functions, and only while the module is not
  // running.

  /// Sets the context, which must outlive the use of the port. `place`: index of the port in its module.
  void serve(const PortContext& context, std::uint32_t place = 0) noexcept {
    context_ = &context;
    place_ = place;
  }
  /// Connects the port to a link, in addition to the links that it has. `values` is null if the link carries
  /// bytes. Otherwise the link itself holds no payloads, and `values` holds one value of the port's type for
  /// each buffer. make_values() of either connected port has created these values.
  virtual void connect(channel::Link link, void* values) = 0;
  /// Links that are connected from now on stay unused until take_over(), because the port of another instance
  /// uses them until then.
  void stand_by() noexcept { attach_ = channel::Attach::later; }
  /// Takes over the links of `before`, which is the same port of another instance of the module. `before`
  /// stops using the links. A real-time thread may call it.
  virtual void take_over(PortBase& before) noexcept = 0;
  /// Creates `number` values, each with memory for the largest sequences, and returns the first. They are
  /// never freed, because the connected port may still read one. Returns null if the port's values are not
  /// C++ objects. It allocates memory.
  [[nodiscard]] virtual void* make_values(std::uint32_t number) const = 0;
  /// The size of one value in bytes. It is the same for two ports that may share values.
  [[nodiscard]] virtual std::size_t value_size() const noexcept = 0;
  /// The safe value of an output as CDR, as its author declared it; empty: none.
  [[nodiscard]] virtual const std::vector<std::byte>& safe() const noexcept { return kNoSafe; }

 protected:
  /// `owner`: the component; null in a program, or in a module in C form that is being loaded.
  PortBase(Component* owner, std::string name, PortDirection direction, const TypeInfo& type,
           PortOptions options);
  void set_role(PortRole role) noexcept { role_ = role; }
  [[nodiscard]] const PortContext& context() const noexcept { return *context_; }
  [[nodiscard]] channel::Attach attach() const noexcept { return attach_; }
  /// Records in the flight record that run() read or wrote a sample.
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

/// The ports without a component: those of this program, or of the module in C form that this thread has
/// loaded since the last call. A port that is destroyed before the call is not in the list.
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
