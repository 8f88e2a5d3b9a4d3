// A sporadic thread module for `takt bench`. Its condition is true in one of `every` rows; `every` is a
// property.
#include <takt/component.hpp>

#include "filter_step.hpp"

class BenchSporadic : public takt::Component {
  takt::Property<std::int64_t> every{
      *this, "every", 10, {.min = 1, .text = "The number of rows from one event to the next."}};

  std::int64_t rows_ = 0;
  takt::bench::Work work_;

  bool condition() override { return ++rows_ % every == 0; }
  void run(const takt::Cycle&) noexcept override { work_.step(); }
};
TAKT_COMPONENT(BenchSporadic)
