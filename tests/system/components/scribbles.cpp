// After `after` runs, writes `words` random words into the memory that its host shares with the node, with
// other hosts and with process modules. Then the module continues normally.
#include <takt/component.hpp>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <vector>

class Scribbles : public takt::Component {
  takt::Property<std::int64_t> after{*this, "after", 100};
  takt::Property<std::int64_t> words{*this, "words", 20000};
  takt::Property<std::int64_t> seed{*this, "seed", 1};
  struct Region {
    std::uint64_t* begin;
    std::size_t words;
  };
  std::vector<Region> regions_;
  std::mt19937_64 random_;
  std::int64_t runs_ = 0;

  takt::Result<void> initialize() override {
    std::ifstream maps{"/proc/self/maps"};
    for (std::string line; std::getline(maps, line);) {
      if (line.find("rw-s") == std::string::npos || line.find("memfd:takt-") == std::string::npos) continue;
      std::size_t dash = 0;
      const std::uintptr_t begin = std::stoull(line, &dash, 16);
      const std::uintptr_t end = std::stoull(line.substr(dash + 1), nullptr, 16);
      regions_.push_back({reinterpret_cast<std::uint64_t*>(begin), (end - begin) / sizeof(std::uint64_t)});
    }
    random_.seed(static_cast<std::uint64_t>(seed.value()));
    std::printf("%zu memories\n", regions_.size());
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    if (runs_++ != after) return;
    for (std::int64_t n = 0; n < words; ++n) {
      const Region& region = regions_[random_() % regions_.size()];
      // Two of three values are small, as in most fields. The others are values that no valid field contains.
      const std::uint64_t value = random_();
      region.begin[random_() % region.words] = n % 3 == 0 ? value : value % (n % 3 == 1 ? 16 : 2000);
    }
  }
};
TAKT_COMPONENT(Scribbles)
