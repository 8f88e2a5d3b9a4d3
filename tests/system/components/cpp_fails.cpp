// A component in C++ whose run() fails in the `after`-th cycle (default 100) after the start and after each
// recovery. If `how` is throw, run() throws; if `how` is fail, run() returns a failure. `more` is the end of
// the text of each failure.
#include <takt/component.hpp>

#include <stdexcept>

class CppFails : public takt::Component {
  takt::Property<std::int64_t> after{*this, "after", 100, {.min = 1, .text = "The run that fails."}};
  takt::Property<std::string> how{*this, "how", "throw", {.text = "throw or fail"}};
  takt::Property<bool> recoverable{*this, "recoverable", true, {.text = "Whether recover() succeeds."}};
  takt::Property<bool> initializable{
      *this, "initializable", true, {.text = "Whether initialize() succeeds."}};
  takt::Property<std::string> more{*this, "more", ""};
  std::int64_t runs_ = 0;

  takt::Result<void> initialize() override {
    if (!initializable) return takt::fail("initialize() failed as it was asked to" + more.value());
    return {};
  }
  void run(const takt::Cycle&) override {
    if (++runs_ < after) return;
    if (how.value() == "throw") throw std::runtime_error("run() threw as it was asked to");
    fail(("run() failed as it was asked to" + more.value()).c_str());
  }
  takt::Result<void> recover() override {
    if (!recoverable) return takt::fail("recover() failed as it was asked to" + more.value());
    runs_ = 0;
    return {};
  }
};
TAKT_COMPONENT(CppFails)
