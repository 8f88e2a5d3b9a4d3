// A thread module: loads a .so that is a module in the paper's C form or a C++ component, and calls the hooks
// of either kind through the same functions.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/module.h>
#include <takt/channel/layout.hpp>
#include <takt/channel/link.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/component.hpp>
#include <takt/component/live_properties.hpp>
#include <takt/component/port.hpp>
#include <takt/core/clock.hpp>
#include <takt/core/result.hpp>
#include <takt/executor/body.hpp>
#include <takt/model/cell.hpp>
#include <takt/os/library.hpp>

namespace takt::host {

/// If a hook throws or calls takt_fail(), the function that called the hook returns the error. Only the
/// executor's thread calls run() and condition(). All other functions are called by one thread at a time,
/// while the module is out of the tables, unless their comments allow more.
class ThreadModule final : public executor::Body {
 public:
  ThreadModule() = default;
  ~ThreadModule() override;
  ThreadModule(const ThreadModule&) = delete;
  ThreadModule& operator=(const ThreadModule&) = delete;

  /// Loads the file, or the sealed copy of it, if given (os::Library::open()). This runs the constructors.
  /// Fails if the file cannot be loaded or has no run(). Also fails if `sporadic` is true and the file has
  /// neither condition() nor an event port.
  Result<void> load(const std::string& path, os::Library::Globals globals, bool sporadic, os::Fd copy = {},
                    os::Library::Origin origin = os::Library::Origin::searched);
  /// Unloads the file, which runs the file's destructors. If a thread that the module has started still runs,
  /// reports it, leaves the file in memory, and returns false. The thread may then use this object, too, so
  /// do not delete it.
  bool unload();
  /// Leaves the module in memory, because a thread may still be running its code.
  void abandon() noexcept;
  [[nodiscard]] bool loaded() const noexcept { return component_ != nullptr || run_ != nullptr; }

  /// True for a C++ component, and for a module in the C form that declares properties. Such a module accepts
  /// only the properties that it declares. A module in the C form that declares no properties accepts any
  /// property.
  [[nodiscard]] bool declares_properties() const noexcept {
    return component_ != nullptr || !properties_.empty();
  }
  /// The declared properties, in the order of declaration. For a module in the C form, these are the
  /// properties that its file declares.
  [[nodiscard]] const std::vector<PropertyBase*>& properties() const noexcept { return properties_; }
  /// Sets all these declared properties or none, even while the module runs. The new values take effect when
  /// the module is called next. Fails with one problem for each property that the module does not have, and
  /// for each value that its property does not accept.
  Result<void> set(const irp::Property::Values& values) { return live_.set(values); }
  /// Returns the value that a declared property has, or that it will have when the module is called next.
  [[nodiscard]] Result<std::string> get(const std::string& property) const { return live_.get(property); }

  /// Sets the declared properties and calls initialize(). If the module declares properties, it rejects any
  /// other property, and values that a property does not accept. A module in the C form can read all
  /// properties.
  Result<void> initialize(const irp::Property& property);
  Result<void> start();
  Result<void> error(ErrorType type);
  Result<void> recover();
  Result<void> destruct();

  executor::Outcome run(const Cycle& cycle) noexcept override;
  executor::Outcome condition(const Cycle& cycle, bool* ready) noexcept override;

  [[nodiscard]] bool has_news(Instant now) const noexcept override;

  /// Takes over the saved state, the link positions and the age of the inputs from `before`. Returns false
  /// and takes over nothing if follow() has translated a saved state of `before` and `before` has saved a new
  /// state since then.
  bool take_over(executor::Body& before) noexcept override;
  /// From now on, this instance's handlers answer requests. Call this after take_over(), while no handler of
  /// either instance is being called.
  void take_over_handlers(ThreadModule& before) noexcept;

  /// Marks this instance as one that will replace a running instance. Its ports use no link until
  /// take_over(). Call stand_by() before load().
  void stand_by() noexcept { stands_by_ = true; }
  /// Fails, with a list of all differences, if ports or properties of this instance differ from those of
  /// `before`. On success, the ports of this instance are in the same order as those of `before`.
  Result<void> match(const ThreadModule& before);
  /// Gives this instance the state that `before` saved last. If the version or size of the state differs, the
  /// component's restore() translates it; fails if restore() fails. Call follow() after initialize(), and
  /// again after a take_over() that returned false.
  Result<void> follow(const ThreadModule& before);
  /// take_over() will store the address of this instance in `place`.
  void track_active_in(std::atomic<ThreadModule*>& place) noexcept { active_ = &place; }

  /// True if the module has services that handlers answer.
  [[nodiscard]] bool has_handlers() const noexcept {
    return component_ != nullptr && !component_->services().empty();
  }
  /// True if a request waits for a handler. Any thread that may call serve() may call this.
  [[nodiscard]] bool has_request() noexcept;
  /// Answers one request: calls the handler if `executing` is true, and otherwise rejects the request.
  /// Returns false if there was no request. A thread may call serve() while another thread is in run() or
  /// condition(), but not while another thread is in any other function of this object.
  bool serve(bool executing);

  /// The component object; null for a module in the C form.
  [[nodiscard]] const Component* component() const noexcept { return component_; }
  [[nodiscard]] const char* component_name() const noexcept {
    return factory_ == nullptr ? "" : factory_->name;
  }
  /// The module's ports, in the order of declaration. For a module in the C form, these are the ports that
  /// its file declares.
  [[nodiscard]] const std::vector<PortBase*>& ports() const noexcept { return ports_; }
  /// Returns the port with this name; null if there is none.
  [[nodiscard]] PortBase* port(const std::string& name) const noexcept;
  /// Sets the objects that the module uses. Call this before load(). The module's ports note in `wake_word`
  /// which readers must be woken; if `wake_word` is null, no reader is woken. `block` counts how often the
  /// module was put into the tables, and contains the ring for the module's log lines. If `block` is null,
  /// the module counts as put into the tables once, and writes no log. `timing` and `period` only matter for
  /// a periodic module.
  void attach(channel::WakeWord* wake_word, channel::ModuleBlock* block,
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
  /// Returns version, size and address of the state that the module saves; null if it saves nothing.
  [[nodiscard]] const takt_saved_state* saves() const noexcept {
    return saved_.data == nullptr ? nullptr : &saved_;
  }
  /// A sentence that states whether a former instance's saved state was restored. Empty if there was no saved
  /// state, or if this module saves nothing.
  [[nodiscard]] const std::string& restored() const noexcept { return restored_; }
  /// From now on, `flight` records the samples that run() writes and the events that run() takes, under this
  /// module index. The writer belongs to the thread that calls run(), and outlives the module.
  void record_to(channel::FlightWriter* flight, std::uint32_t index) noexcept {
    flight_ = flight;
    context_.module = index;
  }
  /// From now on, samples that hooks write get the time of this clock instead of the machine's clock. `clock`
  /// must outlive the module.
  void keep_time_by(Clock& clock) noexcept { clock_ = &clock; }
  /// From now on, the module checks before each run() whether the newest value of `input` is older than the
  /// deadline of `link`. When the module enters the tables, the age of the value is counted from the module's
  /// next release. The link counts each time that the value becomes too old. If `stale_is_error` is true,
  /// run() is not called while the value is too old.
  void check_deadline(channel::Link link, const PortBase& input, bool stale_is_error);
  /// Returns the names of the hooks that a module in the C form defines, in lifecycle order.
  [[nodiscard]] std::vector<std::string> hooks() const;

 private:
  using Hook = void (*)();
  Result<void> take_ports(const std::string& path);
  void serve_ports();
  Result<void> take_properties(const std::string& path);
  Result<void> take_saved(const std::string& path);
  void restore();
  void save() noexcept;
  /// True if the module has its own condition() or an event port.
  [[nodiscard]] bool may_be_ready() const noexcept;
  /// Prepares a call of a hook: samples that the hook writes get the present time, and the hook sees all
  /// properties that were set before.
  void begin_hook() noexcept;
  template <class Call>
  Result<void> guarded(Call&& call);
  template <class Function, class... Arguments>
  Result<void> call(Function function, Arguments&&... arguments);
  [[nodiscard]] Instant now() const noexcept;
  [[nodiscard]] channel::LogRing* log_ring() const noexcept {
    return block_ == nullptr ? nullptr : &block_->log;
  }

  os::Library library_;
  std::shared_ptr<const char> own_threads_ = std::make_shared<const char>();  // see own_threads.hpp
  const ComponentFactory* factory_ = nullptr;
  Component* component_ = nullptr;  // created and destroyed by the functions of factory_
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
  /// Returns the error message of the first input that is too old and has `is_error`; null if there is none.
  const char* check_inputs(Instant start) noexcept;

  std::vector<PortBase*> ports_;
  std::vector<PropertyBase*> properties_;
  takt_saved_state saved_{};                          // the state to save; data is null if there is none
  std::atomic<channel::SavedState*> place_{nullptr};  // null if nothing is saved
  // Number of the old instance's saved state that was last passed to restore(); none if no call of restore()
  // was needed.
  std::optional<std::uint64_t> translated_;
  bool stands_by_ = false;
  std::atomic<ThreadModule*>* active_ = nullptr;
  std::string restored_;
  PortContext context_;
  Clock* clock_ = nullptr;       // null for the machine's clock
  std::size_t served_last_ = 0;  // index of the service that was served last; services take turns
  PortContext handler_context_;  // for the ports that handlers use; its time differs from that of run()
  std::vector<Watched> watched_;
  channel::ModuleBlock* block_ = nullptr;
  channel::FlightWriter* flight_ = nullptr;
  Nanoseconds period_{0};
  // True for timing="let": run() reads the inputs as they were at its release, and its outputs become valid
  // at the end of the period.
  bool logical_ = false;
  std::uint64_t entered_ = 0;  // value of block_->entered at the last check of inputs
  // The first release after the module entered the tables; the ages of inputs count from this time.
  std::int64_t watched_since_ns_ = 0;
  LiveProperties live_;
  void (*error_)(int) = nullptr;
  Hook recover_ = nullptr;
  Hook destruct_ = nullptr;
};

}  // namespace takt::host
