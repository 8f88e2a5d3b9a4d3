// A loaded thread module: a .so in the paper's C form or a C++ component, behind one set of hooks.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/module.h>
#include <takt/channel/layout.hpp>
#include <takt/channel/link.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/component.hpp>
#include <takt/component/port.hpp>
#include <takt/core/clock.hpp>
#include <takt/core/result.hpp>
#include <takt/executor/body.hpp>
#include <takt/host/live_properties.hpp>
#include <takt/model/cell.hpp>
#include <takt/os/library.hpp>

namespace takt::host {

/// If a hook throws or calls takt_fail(), the function that called the hook returns the error. Only the
/// executor's thread calls run() and condition(). All other functions are called by one thread at a time,
/// while the module is out of the tables.
class ThreadModule final : public executor::Body {
 public:
  ThreadModule() = default;
  ~ThreadModule() override;
  ThreadModule(const ThreadModule&) = delete;
  ThreadModule& operator=(const ThreadModule&) = delete;

  /// Loads the file, which runs its constructors. Fails if the file cannot be loaded or has no run(). Also
  /// fails if `sporadic` is true and the file has neither condition() nor an event port.
  Result<void> load(const std::string& path, os::Library::Globals globals, bool sporadic);
  /// Unloads the file, which runs its destructors.
  void unload();
  /// Leaves the module in memory, because a thread may still be inside it.
  void abandon() noexcept;
  [[nodiscard]] bool loaded() const noexcept { return component_ != nullptr || run_ != nullptr; }

  /// True for a C++ component, and for a module in the C form that declares properties. Such a module accepts
  /// only the properties that it declares. A module in the C form without declarations accepts any property.
  [[nodiscard]] bool declares_properties() const noexcept {
    return component_ != nullptr || !properties_.empty();
  }
  /// The declared properties, in the order of declaration; for a module in the C form those of the file.
  [[nodiscard]] const std::vector<PropertyBase*>& properties() const noexcept { return properties_; }
  /// Sets all these declared properties or none, even while the module runs; they take effect at its next
  /// call. Fails with one problem for each property that the module does not have or whose value it does not
  /// accept.
  Result<void> set(const irp::Property::Values& values) { return live_.set(values); }
  /// The value that a declared property has, or will have at the next call.
  [[nodiscard]] Result<std::string> get(const std::string& property) const { return live_.get(property); }

  /// Sets the declared properties and calls initialize(). Rejects properties that the module does not have
  /// and values that it does not accept. A module in the C form can read all properties.
  Result<void> initialize(const irp::Property& property);
  Result<void> start();
  Result<void> error(ErrorType type);
  Result<void> recover();
  Result<void> destruct();

  executor::Outcome run(const Cycle& cycle) noexcept override;
  executor::Outcome condition(const Cycle& cycle, bool* ready) noexcept override;

  [[nodiscard]] bool has_news(Instant now) const noexcept override;

  /// Takes over the saved state, the links and the age of the inputs of `before`. Returns false if `before`
  /// has saved its state since follow().
  bool take_over(executor::Body& before) noexcept override;
  /// From now on, this instance's handlers answer requests. Call it after take_over(), while no handler of
  /// either instance is being called.
  void take_over_handlers(ThreadModule& before) noexcept;

  /// Marks this instance as one that will replace a running instance; until then it serves no link. Call it
  /// before load().
  void stand_by() noexcept { stands_by_ = true; }
  /// Fails if ports or properties of this instance differ from those of `before`, with a list of all
  /// differences. On success, the ports of this instance are in the same order as those of `before`.
  Result<void> match(const ThreadModule& before);
  /// Gives this instance the state that `before` saved last; restore() translates the state of another
  /// version. Fails if restore() fails. Call it after initialize(), as often as needed until take_over().
  Result<void> follow(const ThreadModule& before);
  /// When this instance takes over, it stores its address in `place`.
  void track_active_in(std::atomic<ThreadModule*>& place) noexcept { active_ = &place; }

  /// Whether the module has services that handlers answer.
  [[nodiscard]] bool has_handlers() const noexcept {
    return component_ != nullptr && !component_->services().empty();
  }
  /// Whether a request waits for a handler. The thread rules of serve() apply.
  [[nodiscard]] bool has_request() noexcept;
  /// Answers one request. The handler answers it, or it is rejected if the module is not in EXECUTING.
  /// Returns false if there was no request. May be called at the same time as run() and condition(), on
  /// another thread, but not at the same time as any other function.
  bool serve(bool executing);

  /// The component object; null for a module in the C form.
  [[nodiscard]] const Component* component() const noexcept { return component_; }
  [[nodiscard]] const char* component_name() const noexcept {
    return factory_ == nullptr ? "" : factory_->name;
  }
  /// The module's ports, in the order of declaration; for a module in the C form those of the file.
  [[nodiscard]] const std::vector<PortBase*>& ports() const noexcept { return ports_; }
  /// The port of this name; null if there is none.
  [[nodiscard]] PortBase* port(const std::string& name) const noexcept;
  /// Call it before load(). Ports ring `wake_word`; if it is null, they wake nobody. `block` counts how often
  /// the module was put into the tables; null means once. `timing` and `period` only matter for a periodic
  /// module.
  void attach(channel::WakeWord* wake_word, const channel::ModuleBlock* block,
              model::Timing timing = model::Timing::direct, Nanoseconds period = {}) noexcept {
    context_.wake_word = wake_word;
    handler_context_.wake_word = wake_word;
    block_ = block;
    period_ = period;
    logical_ = timing == model::Timing::let;
  }
  /// From now on, the module's state is saved in `place` after each run(). If save_in() is called before
  /// load(), initialize() restores the state in `place`.
  void save_in(channel::SavedState& place) noexcept { place_.store(&place, std::memory_order_relaxed); }
  /// Version and size of the state that the module saves; null if it saves nothing.
  [[nodiscard]] const takt_saved_state* saves() const noexcept {
    return saved_.data == nullptr ? nullptr : &saved_;
  }
  /// A sentence that says whether a former instance's saved state was restored. Empty if there was no saved
  /// state, or if this module saves nothing.
  [[nodiscard]] const std::string& restored() const noexcept { return restored_; }
  /// From now on, `flight` records the samples that run() writes and the events that it takes, under this
  /// module index. The writer belongs to the thread that calls run(), and outlives the module.
  void record_to(channel::FlightWriter* flight, std::uint32_t index) noexcept {
    flight_ = flight;
    context_.module = index;
  }
  /// Samples that hooks write get the time of this clock instead of the machine's. The clock outlives the
  /// module.
  void keep_time_by(Clock& clock) noexcept { clock_ = &clock; }
  /// From now on, the module checks before each run() whether this input's newest value is older than the
  /// link's deadline. The age counts from the module's first release in the tables, at the earliest. The link
  /// counts how often the value becomes too old. With `stale_is_error`, run() is not called while the value
  /// is too old.
  void watch(channel::Link link, const PortBase& input, bool stale_is_error);
  /// The hooks that the module defines, in lifecycle order.
  [[nodiscard]] std::vector<std::string> hooks() const;

 private:
  using Hook = void (*)();
  Result<void> take_ports(const std::string& path);
  void serve_ports();
  Result<void> take_properties(const std::string& path);
  Result<void> take_saved(const std::string& path);
  void restore();
  void save() noexcept;
  /// Whether the module has a condition() or an event port.
  [[nodiscard]] bool may_be_ready() const noexcept;
  /// Prepares the call of a hook: samples that the hook writes get the time of this call, and the hook sees
  /// the properties that were set before.
  void begin_hook() noexcept;
  template <class Call>
  Result<void> guarded(Call&& call);
  template <class Function, class... Arguments>
  Result<void> call(Function function, Arguments&&... arguments);
  [[nodiscard]] Instant now() const noexcept;

  os::Library library_;
  const ComponentFactory* factory_ = nullptr;
  Component* component_ = nullptr;  // made and destroyed by its factory, in the factory's library
  void (*initialize_)(const irp::Property&) = nullptr;
  Hook start_ = nullptr;
  Hook run_ = nullptr;
  int (*condition_)() = nullptr;
  struct Watched {
    channel::Link link;
    bool is_error;
    std::string text;  // the error message
    bool late = false;
  };
  /// Returns the error message of the first stale input with `is_error`; null if there is none.
  const char* check_inputs(Instant start) noexcept;

  std::vector<PortBase*> ports_;
  std::vector<PropertyBase*> properties_;
  takt_saved_state saved_{};                          // the state to save; data is null if there is none
  std::atomic<channel::SavedState*> place_{nullptr};  // null if nothing is saved
  std::optional<std::uint64_t> translated_;  // number of the old instance's state last given to restore()
  bool stands_by_ = false;
  std::atomic<ThreadModule*>* active_ = nullptr;
  std::string restored_;
  PortContext context_;
  Clock* clock_ = nullptr;       // null for the machine's clock
  std::size_t served_last_ = 0;  // index of the service that was served last; services take turns
  PortContext handler_context_;  // for the ports that handlers use; its time differs from run()'s
  std::vector<Watched> watched_;
  const channel::ModuleBlock* block_ = nullptr;
  channel::FlightWriter* flight_ = nullptr;
  Nanoseconds period_{0};
  bool logical_ = false;       // timing="let": inputs as of the release, outputs at the end of the period
  std::uint64_t entered_ = 0;  // block_->entered at the last run()
  std::int64_t watched_since_ns_ = 0;  // first release since the module entered the tables
  LiveProperties live_;
  void (*error_)(int) = nullptr;
  Hook recover_ = nullptr;
  Hook destruct_ = nullptr;
};

}  // namespace takt::host
