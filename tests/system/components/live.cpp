// A correct component in C++. At the end it reports all values that its property had during its runs, in
// order, and whether the value changed while run() was executing.
#include <array>
#include <fstream>

#include <takt/component.hpp>

class Live : public takt::Component {
  takt::Property<std::int64_t> step{*this, "step", 1, {.unit = "mm", .min = 1, .max = 1000}};
  takt::Property<std::string> label{*this, "label", "none"};
  takt::Property<std::string> file{*this, "file", ""};
  std::array<std::int64_t, 100> seen_{};
  std::size_t count_ = 0;
  std::uint64_t changed_ = 0;

  void run(const takt::Cycle&) noexcept override {
    const std::int64_t now = step;
    if (count_ < seen_.size() && (count_ == 0 || seen_[count_ - 1] != now)) seen_[count_++] = now;
    for (int look = 0; look < 1000; ++look) changed_ += step != now ? 1 : 0;
  }
  void destruct() override {
    if (file.value().empty()) return;
    std::ofstream out{file.value()};
    out << R"({"steps":[)";
    for (std::size_t i = 0; i < count_; ++i) out << (i == 0 ? "" : ",") << seen_[i];
    out << R"(],"changed":)" << changed_ << R"(,"label":")" << label.value() << R"("})" << '\n';
  }
};
TAKT_COMPONENT(Live)
