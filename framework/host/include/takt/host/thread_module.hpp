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

/// An exception or a takt_fail() of a hook becomes its Result. Only the executor's thread calls run() and
/// condition(). One thread at a time calls everything else, while the module is out of the tables.
class ThreadModule final : public executor::Body {
 public:
  ThreadModule() = default;
  ~ThreadModule() override;
  ThreadModule(const ThreadModule&) = delete;
  ThreadModule& operator=(const ThreadModule&) = delete;

  /// Runs the file's constructors. Fails if the file is not a component: it cannot be loaded, has no run(),
  /// or has neither condition() nor an event port although `sporadic`.
  Result<void> load(const std::string& path, os::Library::Globals globals, bool sporadic);
  /// Runs the file's destructors.
  void unload();
  /// Leaves the module in memory, because a thread may still be inside it.
  void abandon() noexcept;
  [[nodiscard]] bool loaded() const noexcept { return component_ != nullptr || run_ != nullptr; }

  /// True for a C++ component, and for a module in the C form that declares properties: it accepts these and
  /// no others. A module in the C form that declares none accepts any.
  [[nodiscard]] bool declares_properties() const noexcept {
    return component_ != nullptr || !properties_.empty();
  }
  /// In the order of declaration; for a module in the C form those of the file.
  [[nodiscard]] const std::vector<PropertyBase*>& properties() const noexcept { return properties_; }
  /// Sets declared properties, even while the module runs; they take effect at its next call. All or none:
  /// one problem for each property that it does not have or whose value it does not accept.
  Result<void> set(const irp::Property::Values& values) { return live_.set(values); }
  /// The value that a declared property has, or will have at the next call.
  [[nodiscard]] Result<std::string> get(const std::string& property) const { return live_.get(property); }

  /// Sets the declared properties; rejects those that the module does not have and values that it does not
  /// accept. A module in the C form sees all of them.
  Result<void> initialize(const irp::Property& property);
  Result<void> start();
  Result<void> error(ErrorType type);
  Result<void> recover();
  Result<void> destruct();

  executor::Outcome run(const Cycle& cycle) noexcept override;
  executor::Outcome condition(const Cycle& cycle, bool* ready) noexcept override;

  [[nodiscard]] bool has_news(Instant now) const noexcept override;

  /// Takes over the saved state, the links and the age of the inputs of `before`. Returns false if `before`
  /// has saved something since follow().
  bool take_over(executor::Body& before) noexcept override;
  /// From now on this instance's handlers answer. Call it after take_over(), while no handler of either
  /// instance is being called.
  void take_over_handlers(ThreadModule& before) noexcept;

  /// Call it before load(): this instance will replace another one that runs, and serves no link until then.
  void stand_by() noexcept { stands_by_ = true; }
  /// Fails with everything that prevents this instance from replacing `before`: ports and properties that
  /// differ. On success, its ports are in the same order as the other's.
  Result<void> match(const ThreadModule& before);
  /// Gives this instance what `before` has saved so far; restore() translates the state of another version.
  /// Fails if that fails. Call it after initialize(), as often as needed until take_over().
  Result<void> follow(const ThreadModule& before);
  /// `place` always points to the instance that took over last: this one or the one that it replaced.
  void track_active_in(std::atomic<ThreadModule*>& place) noexcept { active_ = &place; }

  /// Whether it has services that handlers answer.
  [[nodiscard]] bool has_handlers() const noexcept {
    return component_ != nullptr && !component_->services().empty();
  }
  /// Whether a request waits for a handler. Thread rules as for serve().
  [[nodiscard]] bool has_request() noexcept;
  /// Answers one request: by its handler, or with a rejection while the module is not EXECUTING. Returns
  /// false if there was none. May run on a separate thread beside run() and condition(), but not at the same
  /// time as anything else.
  bool serve(bool executing);

  /// Null for a module in the C form.
  [[nodiscard]] const Component* component() const noexcept { return component_; }
  [[nodiscard]] const char* component_name() const noexcept {
    return factory_ == nullptr ? "" : factory_->name;
  }
  /// Its ports, in the order of declaration; for a module in the C form those of the file.
  [[nodiscard]] const std::vector<PortBase*>& ports() const noexcept { return ports_; }
  /// Null if there is no port of that name.
  [[nodiscard]] PortBase* port(const std::string& name) const noexcept;
  /// Call it before load(). Ports ring `wake_word`; if null, they wake nobody. `block` counts how often the
  /// module was put into the tables; null means once. `timing` and `period` are those of a periodic module.
  void attach(channel::WakeWord* wake_word, const channel::ModuleBlock* block,
              model::Timing timing = model::Timing::direct, Nanoseconds period = {}) noexcept {
    context_.wake_word = wake_word;
    handler_context_.wake_word = wake_word;
    block_ = block;
    period_ = period;
    logical_ = timing == model::Timing::let;
  }
  /// From now on the module's state is saved there after each run(). If called before load(), initialize()
  /// restores what is there.
  void save_in(channel::SavedState& place) noexcept { place_.store(&place, std::memory_order_relaxed); }
  /// Version and size of what it saves; null if it saves nothing.
  [[nodiscard]] const takt_saved_state* saves() const noexcept {
    return saved_.data == nullptr ? nullptr : &saved_;
  }
  /// What became of the state that a former instance saved, in words; empty if there was none, or if this
  /// module saves nothing.
  [[nodiscard]] const std::string& restored() const noexcept { return restored_; }
  /// Records there what run() writes and which events it takes, under this module index. The writer belongs
  /// to the thread that calls run(), and outlives the module.
  void record_to(channel::FlightWriter* flight, std::uint32_t index) noexcept {
    flight_ = flight;
    context_.module = index;
  }
  /// Stamps what hooks write with the time of this clock, not the machine's. The clock outlives the module.
  void keep_time_by(Clock& clock) noexcept { clock_ = &clock; }
  /// Before each run(), checks whether this input's newest value is older than the link's deadline. Time
  /// counts from the module's first release in the tables. A late value is counted; with `stale_is_error`,
  /// run() is then not called.
  void watch(channel::Link link, const PortBase& input, bool stale_is_error);
  /// The hooks that it defines, in lifecycle order.
  [[nodiscard]] std::vector<std::string> hooks() const;

 private:
  using Hook = void (*)();
  Result<void> take_ports(const std::string& path);
  void serve_ports();
  Result<void> take_properties(const std::string& path);
  Result<void> take_saved(const std::string& path);
  void restore();
  void save() noexcept;
  /// Whether it has a condition: its own, or an event port.
  [[nodiscard]] bool may_be_ready() const noexcept;
  /// Samples that a hook writes carry the time of its call. The hook sees the properties set so far.
  void begin_hook() noexcept;
  template <class Call>
  Result<void> guarded(Call&& call);
  template <class Function, class... Arguments>
  Result<void> call(Function function, Arguments&&... arguments);
  [[nodiscard]] Instant now() const noexcept;

  os::Library library_;
  const ComponentFactory* factory_ = nullptr;
  Component* component_ = nullptr;  // its factory makes and destroys it, in its own library
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
  /// The error message of an input that is stale although it must not be; null if there is none.
  const char* check_inputs(Instant start) noexcept;

  std::vector<PortBase*> ports_;
  std::vector<PropertyBase*> properties_;
  takt_saved_state saved_{};                          // what it saves; without data: nothing
  std::atomic<channel::SavedState*> place_{nullptr};  // null: nothing is saved
  std::optional<std::uint64_t> translated_;  // number of the other instance's state last given to restore()
  bool stands_by_ = false;
  std::atomic<ThreadModule*>* active_ = nullptr;
  std::string restored_;
  PortContext context_;
  Clock* clock_ = nullptr;       // null: the machine's
  std::size_t served_last_ = 0;  // index of a service: they take turns
  PortContext handler_context_;  // for the ports that handlers use: their time is not run()'s
  std::vector<Watched> watched_;
  const channel::ModuleBlock* block_ = nullptr;
  channel::FlightWriter* flight_ = nullptr;
  Nanoseconds period_{0};
  bool logical_ = false;               // logical time: inputs as of the release, outputs at the period's end
  std::uint64_t entered_ = 0;          // block_->entered at the last run()
  std::int64_t watched_since_ns_ = 0;  // first release since the module entered the tables
  LiveProperties live_;
  void (*error_)(int) = nullptr;
  Hook recover_ = nullptr;
  Hook destruct_ = nullptr;
};

}  // namespace takt::host
