#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include <takt/host/thread_module.hpp>
#include "subject.hpp"

namespace takt::testing {

namespace {
std::multiset<std::string>& taken_files() {
  static std::multiset<std::string> files;
  return files;
}
}  // namespace

bool LoadedFile::is_taken(const std::string& path) { return taken_files().count(path) != 0; }

void LoadedFile::take(const std::string& path) {
  release();
  taken_files().insert(path);
  path_ = path;
}

void LoadedFile::release() {
  if (const auto found = taken_files().find(path_); found != taken_files().end()) taken_files().erase(found);
  path_.clear();
}

namespace {

/// A thread module, loaded as the host loads it.
class ThreadSubject final : public Subject {
 public:
  ThreadSubject(std::string path, bool sporadic, Nanoseconds period, VirtualClock& clock,
                channel::ModuleBlock& block)
      : path_(std::move(path)), sporadic_(sporadic), log_(block.log) {
    module_.keep_time_by(clock);
    module_.attach(nullptr, &block, model::Timing::direct, sporadic ? Nanoseconds{0} : period);
    module_.save_in(*saved_);
  }

  // As in the host, all modules of a C++ component share one loaded file, and each further module in C gets
  // its own copy of the file.
  Result<void> load() override {
    module_.unload();
    file_.release();
    const bool copy = LoadedFile::is_taken(path_);
    auto loaded =
        module_.load(path_, copy ? os::Library::Globals::own : os::Library::Globals::shared, sporadic_);
    if (loaded && module_.component() == nullptr) file_.take(path_);
    return loaded;
  }
  Result<void> initialize(const irp::Property& properties) override { return module_.initialize(properties); }
  Result<void> start() override {
    auto started = module_.start();
    if (started) crashed_ = false;
    return started;
  }
  Result<void> error(ErrorType type) override { return module_.error(type); }
  Result<void> recover() override { return module_.recover(); }
  Result<void> destruct() override { return crashed_ ? Result<void>{} : module_.destruct(); }
  void crash() override { crashed_ = true; }
  [[nodiscard]] bool ended() const override { return crashed_; }
  channel::LogRing& log_ring() override { return log_; }
  void forget() override { saved_->clear(); }

  Result<void> check(const std::string& name, const std::string& text) override {
    if (module_.component() == nullptr) return {};  // a module in C checks its properties in initialize()
    return module_.set({{name, text}});
  }
  Result<void> set(const std::string& name, const std::string& text) override {
    if (module_.component() == nullptr) {
      return fail("a module in C reads its properties in initialize()",
                  "set them before initialize(), or after destruct() and reset()");
    }
    return module_.set({{name, text}});
  }
  [[nodiscard]] std::optional<Result<std::string>> get(const std::string& name) const override {
    if (module_.component() == nullptr) return std::nullopt;
    return module_.get(name);
  }

  [[nodiscard]] const std::vector<PortBase*>& ports() const override { return module_.ports(); }
  void check_deadline(channel::Link link, const PortBase& input, bool stale_is_error) override {
    module_.check_deadline(link, input, stale_is_error);
  }

  void enter(executor::Unit& unit) override { unit.body = &module_; }
  void serve(channel::ModuleBlock& block) override {  // the executor has already called run()
    while (module_.serve(block.in_tables != 0)) {
    }
  }

 private:
  std::string path_;
  bool sporadic_;
  channel::LogRing& log_;
  bool crashed_ = false;  // true from a crash until the module is started again
  LoadedFile file_;
  std::unique_ptr<channel::SavedState> saved_ = std::make_unique<channel::SavedState>();
  host::ThreadModule module_;
};

}  // namespace

std::unique_ptr<Subject> make_thread_subject(std::string path, bool sporadic, Nanoseconds period,
                                             VirtualClock& clock, channel::ModuleBlock& block) {
  return std::make_unique<ThreadSubject>(std::move(path), sporadic, period, clock, block);
}

}  // namespace takt::testing
