// A port as far as its type does not matter: what the host ties to the links of its connections, and what
// `takt describe` shows. Authors use InPort, EventPort and OutPort.
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

enum class PortDirection { in, event, out };
/// "in", "event", "out"
const char* to_text(PortDirection direction) noexcept;

/// What a port is there for: samples of its own, or, with another one, a service or a client.
enum class PortRole {
  plain,
  service,  ///< its module answers requests, in run()
  handler,  ///< the same, by a handler on a thread of its own
  client,   ///< its module asks
};
/// "port", "service", "handler", "client"
const char* to_text(PortRole role) noexcept;

/// The two ports that a service or client NAME is made of are NAME/request and NAME/reply.
inline constexpr const char* kRequestPort = "/request";
inline constexpr const char* kReplyPort = "/reply";

/// What may be said of any port.
struct PortOptions {
  std::string text{};  ///< one sentence for `takt describe`
};

/// What the ports of a module are told by whoever runs it.
struct PortContext {
  std::int64_t start_ns =
      0;  ///< when the present run() began: the stamp of what is written, and `now` of ages
  channel::WakeWord* wake_word = nullptr;  ///< for links that wake somebody
  /// From when on what is written may be read: with timing="let" the end of the period; 0: at once.
  std::int64_t valid_ns = 0;
  /// Where samples are recorded while run() is called; null: nowhere.
  channel::FlightWriter* flight = nullptr;
  std::uint32_t module = 0;  ///< its index on the device, for that record
};

class PortBase {
 public:
  PortBase(const PortBase&) = delete;
  PortBase& operator=(const PortBase&) = delete;
  virtual ~PortBase();

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] PortDirection direction() const noexcept { return direction_; }
  [[nodiscard]] PortRole role() const noexcept { return role_; }
  [[nodiscard]] const TypeInfo& type() const noexcept { return type_; }
  [[nodiscard]] const std::string& text() const noexcept { return options_.text; }

  /// Somebody is at the other end of a connection. Real-time.
  [[nodiscard]] virtual bool connected() const noexcept = 0;
  /// read() would find a sample. Real-time.
  [[nodiscard]] bool has_news() const noexcept { return news_at() <= context().start_ns; }
  /// From when on, monotonic: 0 for at once, channel::kNever when there is none. Real-time; also for another
  /// thread than the one that reads.
  [[nodiscard]] virtual std::int64_t news_at() const noexcept { return channel::kNever; }

  // For whoever runs the module, while it is not running.

  /// The context outlives the port's use. `place`: of the port among those of its module.
  void serve(const PortContext& context, std::uint32_t place = 0) noexcept {
    context_ = &context;
    place_ = place;
  }
  /// The port becomes a side of this link, beside those that it has. `values` are the payloads of a link
  /// without place for them: as many values of the port's type as the link has buffers, from make_values() of
  /// either end; null: the link carries bytes.
  virtual void connect(channel::Link link, void* values) = 0;
  /// Another instance's port serves the links that are connected from now on, until take_over(): till then
  /// nothing is read or written here.
  void stand_by() noexcept { attach_ = channel::Attach::later; }
  /// Goes on where `before` is: the same port of another instance of the module, with the same links. That
  /// one stands by from now on. Real-time.
  virtual void take_over(PortBase& before) noexcept = 0;
  /// Makes values with the room that they may need. They are for ever: nobody knows who still looks at one.
  /// Null from a port whose values are no C++ class.
  [[nodiscard]] virtual void* make_values(std::uint32_t number) const = 0;
  /// Bytes of one value; the same for two ports that share values.
  [[nodiscard]] virtual std::size_t value_size() const noexcept = 0;
  /// Of an output, the safe value that its author gave it, as CDR; empty: none.
  [[nodiscard]] virtual const std::vector<std::byte>& safe() const noexcept { return kNoSafe; }

 protected:
  /// Of a component; or, without one, of the program or of the module in C form that is being loaded.
  PortBase(Component* owner, std::string name, PortDirection direction, const TypeInfo& type,
           PortOptions options);
  void be(PortRole role) noexcept { role_ = role; }
  [[nodiscard]] const PortContext& context() const noexcept { return *context_; }
  [[nodiscard]] channel::Attach attach() const noexcept { return attach_; }
  /// A sample went in or out, in run().
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

/// The ports without a component of this program, or of the module in C form that this thread has loaded
/// since it was asked last. They take themselves away when they end before they were asked for.
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
