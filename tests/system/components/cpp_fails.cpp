// A component in C++ whose run() fails in its `after`-th run (100) since the start and since each recovery.
// `how` is throw or say (it returns a failure).
#include <takt/component.hpp>

#include <stdexcept>

class CppFails : public takt::Component {
  takt::Property<std::int64_t> after{*this, "after", 100, {.min = 1, .text = "The run that fails."}};
  takt::Property<std::string> how{*this, "how", "throw", {.text = "throw or say"}};
  takt::Property<bool> recoverable{*this, "recoverable", true, {.text = "Whether recover() succeeds."}};
  std::int64_t runs_ = 0;

  void run(const takt::Cycle&) override {
    if (++runs_ < after) return;
    if (how.value() == "throw") throw std::runtime_error("run() threw as it was asked to");
    fail("run() failed as it was asked to");
  }
  takt::Result<void> recover() override {
    if (!recoverable) return takt::fail("recover() failed as it was asked to");
    runs_ = 0;
    return {};
  }
};
TAKT_COMPONENT(CppFails)
