#include <takt/channel/check_reporter.hpp>

#include <takt/channel/violations.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/library.hpp>

namespace takt::channel {

Result<CheckReporter> CheckReporter::find() {
  CheckReporter reporter;
  const auto find = [](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(os::loaded_function(name));
  };
  find(reporter.enter_, "takt_check_enter");
  find(reporter.leave_, "takt_check_leave");
  // libtakt_check.so removes this environment variable when it is loaded. So if the variable is still set,
  // the library is missing.
  if (!os::environment(kCheckFd).empty() || (reporter.enter_ == nullptr) != (reporter.leave_ == nullptr)) {
    return fail(
        "the dynamic loader did not load libtakt_check.so",
        "put it into the directory of takt-host, and remove the file capabilities of takt-host (setcap -r)");
  }
  return reporter;
}

const char* to_text(ViolationKind kind) noexcept {
  switch (kind) {
    case ViolationKind::allocation:
      return "allocation";
    case ViolationKind::lock:
      return "lock";
    case ViolationKind::system_call:
      return "system call";
    case ViolationKind::page_fault:
      break;
  }
  return "page fault";
}

}  // namespace takt::channel
