#include "offsets.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace takt::schedule {
namespace {

/// The maximum number of search steps; each step visits one row. To try each position of each module once
/// takes one step per row and module. If these steps alone exceed half of the maximum, the search chooses no
/// offsets.
constexpr std::uint64_t kMaxSearchSteps = 20'000'000;

std::uint64_t count(Nanoseconds time) { return static_cast<std::uint64_t>(time.count()); }

class Search {
 public:
  explicit Search(std::span<const Shiftable> modules) : modules_(modules) {
    for (const Shiftable& module : modules) {
      basic_ = std::gcd(basic_, count(module.period));
      if (module.fixed) basic_ = std::gcd(basic_, count(module.offset));
    }
  }

  std::vector<Nanoseconds> run() {
    std::vector<Nanoseconds> offsets;
    for (const Shiftable& module : modules_) offsets.push_back(module.fixed ? module.offset : Nanoseconds{0});
    if (!count_rows()) return offsets;

    loads_.assign(rows_, 0);
    places_.assign(modules_.size(), 0);
    for (std::size_t i = 0; i < modules_.size(); ++i) {
      if (modules_[i].fixed) {
        put(i, count(modules_[i].offset) / basic_, modules_[i].weight);
      } else {
        free_.push_back(i);
        all_ += static_cast<std::int64_t>(rows_ / stride(i)) * modules_[i].weight;
      }
    }
    for (const std::int64_t load : loads_) all_ += load;
    // Place the modules with the fewest possible positions first. Of several modules with equally many
    // positions, place the one with the largest weight first.
    std::stable_sort(free_.begin(), free_.end(), [this](std::size_t a, std::size_t b) {
      if (modules_[a].period != modules_[b].period) return modules_[a].period < modules_[b].period;
      return modules_[a].weight > modules_[b].weight;
    });
    best_ = without_shift();
    best_places_.assign(modules_.size(), 0);
    least_ = std::max((all_ + static_cast<std::int64_t>(rows_) - 1) / static_cast<std::int64_t>(rows_),
                      heaviest());
    place_all();
    for (const std::size_t i : free_) {
      offsets[i] = Nanoseconds{static_cast<std::int64_t>(best_places_[i] * basic_)};
    }
    return offsets;
  }

 private:
  [[nodiscard]] std::uint64_t stride(std::size_t i) const { return count(modules_[i].period) / basic_; }

  bool count_rows() {
    if (modules_.empty()) return false;
    const std::uint64_t most = kMaxSearchSteps / 2 / modules_.size();
    std::uint64_t rows = 1;
    for (std::size_t i = 0; i < modules_.size(); ++i) {
      if (stride(i) > most) return false;
      rows *= stride(i) / std::gcd(rows, stride(i));  // cannot overflow, because both factors are at most
                                                      // `most`
      if (rows > most) return false;
    }
    rows_ = rows;
    return true;
  }

  void put(std::size_t i, std::uint64_t first, std::int64_t weight) {
    for (std::uint64_t row = first; row < rows_; row += stride(i)) loads_[row] += weight;
    steps_ += rows_ / stride(i);
  }
  [[nodiscard]] std::int64_t heaviest() const { return *std::max_element(loads_.begin(), loads_.end()); }
  std::int64_t without_shift() {
    for (const std::size_t i : free_) put(i, 0, modules_[i].weight);
    const std::int64_t result = heaviest();
    for (const std::size_t i : free_) put(i, 0, -modules_[i].weight);
    return result;
  }

  /// The load of the heaviest row that contains the module, if the module is at position `first`.
  std::int64_t heaviest_with(std::size_t i, std::uint64_t first) {
    std::int64_t most = 0;
    for (std::uint64_t row = first; row < rows_; row += stride(i)) most = std::max(most, loads_[row]);
    steps_ += rows_ / stride(i);
    return most + modules_[i].weight;
  }

  struct Candidate {
    std::int64_t load;
    std::uint64_t first;
  };
  /// The positions that the search still has to try for one module, while all modules before it are placed.
  struct Level {
    std::vector<Candidate> candidates;
    std::size_t next = 0;
    bool placed = false;
  };

  [[nodiscard]] Level level(std::size_t depth, std::int64_t heaviest) {
    Level result;
    // In an empty table, all positions are equivalent.
    const std::uint64_t to_try = depth == 0 && all_alike() ? 1 : stride(free_[depth]);
    for (std::uint64_t first = 0; first < to_try; ++first) {
      const std::int64_t load = std::max(heaviest, heaviest_with(free_[depth], first));
      if (load < best_) result.candidates.push_back({load, first});
    }
    std::stable_sort(result.candidates.begin(), result.candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.load < b.load; });
    return result;
  }

  // Searches depth first, and tries the positions with the lowest load first, so that even the first result
  // is good. Drops branches that cannot beat the best result so far.
  void place_all() {
    std::vector<Level> levels;
    if (!free_.empty()) levels.push_back(level(0, heaviest()));
    while (!levels.empty()) {
      Level& last = levels.back();
      const std::size_t i = free_[levels.size() - 1];
      if (last.placed) put(i, places_[i], -modules_[i].weight);
      last.placed = false;
      if (last.next == last.candidates.size() || last.candidates[last.next].load >= best_ ||
          best_ <= least_ || steps_ > kMaxSearchSteps) {
        levels.pop_back();
        continue;
      }
      const Candidate candidate = last.candidates[last.next++];
      places_[i] = candidate.first;
      put(i, candidate.first, modules_[i].weight);
      last.placed = true;
      if (levels.size() < free_.size()) {
        levels.push_back(level(levels.size(), candidate.load));
      } else {
        best_ = candidate.load;
        best_places_ = places_;
      }
    }
  }
  [[nodiscard]] bool all_alike() const { return free_.size() == modules_.size(); }

  std::span<const Shiftable> modules_;
  std::uint64_t basic_ = 0;
  std::uint64_t rows_ = 0;
  std::vector<std::int64_t> loads_;
  std::vector<std::size_t> free_;
  std::vector<std::uint64_t> places_;
  std::vector<std::uint64_t> best_places_;
  std::int64_t all_ = 0;
  std::int64_t least_ = 0;
  std::int64_t best_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace

std::vector<Nanoseconds> flatten(std::span<const Shiftable> modules) { return Search{modules}.run(); }

}  // namespace takt::schedule
