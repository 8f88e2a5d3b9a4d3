// A periodic module that uses SafeWatch to report the samples and safe values that it reads.
#include <takt/component.hpp>

#include <string>

#include "safe_value.hpp"

class SafeReader : public takt::Component {
  takt::InPort<samples::Count> in{*this, "in"};
  takt::Property<std::string> who{*this, "who", "reader"};
  takt::Property<std::int64_t> oldest{
      *this, "oldest", 0, {.unit = "ns", .min = 0, .text = "Of a sample; 0: of any age."}};

  SafeWatch watch_;
  std::string name_;

  takt::Result<void> initialize() override {
    name_ = who.value();
    watch_ = SafeWatch{std::chrono::nanoseconds{oldest}};
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    const bool news = in.read();
    if (in.has_value()) watch_.look(name_.c_str(), in, news);
  }
};
TAKT_COMPONENT(SafeReader)
