// A thread module in memory: a .so in the paper's C form or a C++ component, behind one set of hooks.
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

/// Exceptions of a hook and what it said by takt_fail() become its Result. run() and condition() are for the
/// executor's thread; everything else for one thread at a time, with the module out of the tables.
class ThreadModule final : public executor::Body {
 public:
  ThreadModule() = default;
  ~ThreadModule() override;
  ThreadModule(const ThreadModule&) = delete;
  ThreadModule& operator=(const ThreadModule&) = delete;

  /// Its constructors run. Fails when the file is no component: it cannot be loaded, or lacks run(), or lacks
  /// condition() where `sporadic`.
  Result<void> load(const std::string& path, os::Library::Globals globals, bool sporadic);
  /// Its destructors run.
  void unload();
  /// Leaves it where it is, because a thread may never have come out of it.
  void abandon() noexcept;
  [[nodiscard]] bool loaded() const noexcept { return component_ != nullptr || run_ != nullptr; }

  /// It has these properties and no others: a C++ component, or a module in the C form that declares some.
  /// One that declares none takes any.
  [[nodiscard]] bool declares_properties() const noexcept {
    return component_ != nullptr || !properties_.empty();
  }
  /// In the order of their declaration; of a module in the C form those of the file.
  [[nodiscard]] const std::vector<PropertyBase*>& properties() const noexcept { return properties_; }
  /// Sets properties that are declared, also while it runs; in force from its next call on. All or none: one
  /// problem for each that it does not have or does not take.
  Result<void> set(const irp::Property::Values& values) { return live_.set(values); }
  /// The value that such a property has, or will have from the next call on.
  [[nodiscard]] Result<std::string> get(const std::string& property) const { return live_.get(property); }

  /// Properties that are declared are set, and what the module does not have or take is refused; a module in
  /// the C form is shown all of them.
  Result<void> initialize(const irp::Property& property);
  Result<void> start();
  Result<void> error(ErrorType type);
  Result<void> recover();
  Result<void> destruct();

  executor::Outcome run(const Cycle& cycle) noexcept override;
  executor::Outcome condition(const Cycle& cycle, bool* ready) noexcept override;

  [[nodiscard]] bool has_news(Instant now) const noexcept override;

  /// What `before` has saved is ours from now on, its links and how old its inputs are. False where it has
  /// saved something since follow().
  bool take_over(executor::Body& before) noexcept override;
  /// Its handlers answer from now on. After take_over(), while no handler of either is called.
  void take_over_handlers(ThreadModule& before) noexcept;

  /// Before it is loaded: it is to take the place of another instance that runs, and serves no link until
  /// then.
  void stand_by() noexcept { stands_by_ = true; }
  /// Fails with all that keeps it from taking the place of `before`: ports and properties that are not the
  /// same, and what cannot be handed over. Its ports are in the order of the other's then.
  Result<void> match(const ThreadModule& before);
  /// Is given what `before` has saved up to now; what is of another version is translated by restore(). Fails
  /// where that does. After initialize(); may be called again until it takes over.
  Result<void> follow(const ThreadModule& before);
  /// This instance or the one that it took the place of, whichever took over last.
  void say_who_serves(std::atomic<ThreadModule*>& place) noexcept { serves_ = &place; }

  /// It has services that handlers answer.
  [[nodiscard]] bool has_handlers() const noexcept {
    return component_ != nullptr && !component_->services().empty();
  }
  /// A request waits for a handler. As serve().
  [[nodiscard]] bool has_request() noexcept;
  /// Has one answered: by its handler, or, while the module is not EXECUTING, with that. False when there was
  /// none. For a thread of its own beside run() and condition(); not at once with anything else.
  bool serve(bool executing);

  /// Null for a module in the C form.
  [[nodiscard]] const Component* component() const noexcept { return component_; }
  [[nodiscard]] const char* component_name() const noexcept {
    return factory_ == nullptr ? "" : factory_->name;
  }
  /// Its ports, in the order of their declaration; of a module in the C form those of the file.
  [[nodiscard]] const std::vector<PortBase*>& ports() const noexcept { return ports_; }
  /// Null when it has none of that name.
  [[nodiscard]] PortBase* port(const std::string& name) const noexcept;
  /// Before it is loaded. For ports that wake somebody; null: they wake nobody. And where it is counted how
  /// often the module was put into the tables; null: once.
  /// `timing` and `period`: of a periodic module.
  void attach(channel::WakeWord* wake_word, const channel::ModuleBlock* block,
              model::Timing timing = model::Timing::direct, Nanoseconds period = {}) noexcept {
    context_.wake_word = wake_word;
    handler_context_.wake_word = wake_word;
    block_ = block;
    period_ = period;
    logical_ = timing == model::Timing::let;
  }
  /// What it saves goes there after each run() from now on. Before it is loaded: what is there is restored by
  /// initialize().
  void save_in(channel::SavedState& place) noexcept { place_.store(&place, std::memory_order_relaxed); }
  /// Where it saves something, its version and size; else null.
  [[nodiscard]] const takt_saved_state* saves() const noexcept {
    return saved_.data == nullptr ? nullptr : &saved_;
  }
  /// What became of what a former instance had saved, in words; empty: there was nothing, or it saves
  /// nothing.
  [[nodiscard]] const std::string& restored() const noexcept { return restored_; }
  /// What run() writes and which events it takes is recorded there, as of the module with this index. The
  /// writer is that of the thread that calls run(), and outlives the module.
  void record_to(channel::FlightWriter* flight, std::uint32_t index) noexcept {
    flight_ = flight;
    context_.module = index;
  }
  /// What hooks write is stamped by this clock, not by the machine's. Outlives the module.
  void keep_time_by(Clock& clock) noexcept { clock_ = &clock; }
  /// Before each run() it is looked whether this input's newest value is older than the link's deadline,
  /// counted from the module's first release in the tables on. It is late then, which is counted; where it is
  /// an error, run() is not called.
  void watch(channel::Link link, const PortBase& input, bool stale_is_error);
  /// The hooks that it defines, in the order of their lives.
  [[nodiscard]] std::vector<std::string> hooks() const;

 private:
  using Hook = void (*)();
  Result<void> take_ports(const std::string& path);
  void serve_ports();
  Result<void> take_properties(const std::string& path);
  Result<void> take_saved(const std::string& path);
  void restore();
  void save() noexcept;
  /// It has a condition, of its own or by an event port.
  [[nodiscard]] bool may_be_ready() const noexcept;
  /// What a hook writes has the time at which it was called; it sees what was set until then.
  void begin_hook() noexcept;
  template <class Call>
  Result<void> guarded(Call&& call);
  template <class Function, class... Arguments>
  Result<void> call(Function function, Arguments&&... arguments);
  [[nodiscard]] Instant now() const noexcept;

  os::Library library_;
  const ComponentFactory* factory_ = nullptr;
  Component* component_ = nullptr;  // made and destroyed by its factory, in its own library
  void (*initialize_)(const irp::Property&) = nullptr;
  Hook start_ = nullptr;
  Hook run_ = nullptr;
  int (*condition_)() = nullptr;
  struct Watched {
    channel::Link link;
    bool is_error;
    std::string text;  // of the error
    bool late = false;
  };
  /// Null when none is stale that must not be.
  const char* look_at_inputs(Instant start) noexcept;

  std::vector<PortBase*> ports_;
  std::vector<PropertyBase*> properties_;
  takt_saved_state saved_{};                          // what it saves; no data: nothing
  std::atomic<channel::SavedState*> place_{nullptr};  // null: it is saved nowhere
  std::optional<std::uint64_t> translated_;  // which of what the other one saved restore() was given last
  bool stands_by_ = false;
  std::atomic<ThreadModule*>* serves_ = nullptr;
  std::string restored_;
  PortContext context_;
  Clock* clock_ = nullptr;       // null: the machine's
  std::size_t served_last_ = 0;  // which of its services: each has its turn
  PortContext handler_context_;  // of the ports that handlers use: they are not at run()'s
  std::vector<Watched> watched_;
  const channel::ModuleBlock* block_ = nullptr;
  channel::FlightWriter* flight_ = nullptr;
  Nanoseconds period_{0};
  bool logical_ = false;               // inputs as of the release, outputs at the end of the period
  std::uint64_t entered_ = 0;          // as it was at the last run()
  std::int64_t watched_since_ns_ = 0;  // the first release since then
  LiveProperties live_;
  void (*error_)(int) = nullptr;
  Hook recover_ = nullptr;
  Hook destruct_ = nullptr;
};

}  // namespace takt::host
