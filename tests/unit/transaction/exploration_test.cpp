// Explores every state that the devices of a cell can reach with next(), and checks each of them.
//
// A device can do one of these at any moment, in any order, any number of times:
// - decide: next() with what it has heard and its own clock;
// - hear another device: any stage of it that is not older than the last one heard. So a message can be
//   delayed, overtaken by a newer one, or repeated. A message that never arrives is one that is delayed for
//   ever, and a cut network is a delay of all messages;
// - lose another device;
// - receive T0 from the operator. The operator may send it to any of the devices, repeatedly, late or never;
// - fail;
// - crash and restart. Then it has heard nothing, and it has undone the change, unless it was prepared or
//   final. So only the change itself, and whether it is final, must be on disk;
// - let time pass. Each device has its own clock, and the clocks may differ by any amount.
#include <takt/transaction/transaction.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "../../full_form.hpp"

namespace takt::transaction::exploration_test {
namespace {

constexpr std::int64_t kT0 = 100'000'000'000;

// The instants at which next() decides differently.
enum class Clock : unsigned { early, operator_silent, begins, t0, too_late };
constexpr unsigned kLast = static_cast<unsigned>(Clock::too_late);
std::int64_t ns(unsigned clock) {
  switch (static_cast<Clock>(clock)) {
    case Clock::early:
      return kT0 - 2 * kOperatorSilent.count();
    case Clock::operator_silent:
      return kT0 - kBegins.count() - 1;
    case Clock::begins:
      return kT0 - kBegins.count();
    case Clock::t0:
      return kT0;
    case Clock::too_late:
      return kT0 + kHeardWithin.count() + 1;
  }
  return 0;
}

constexpr std::size_t kMost = 3;  // devices of a cell
// What one device knows. A cell of three devices fits into 51 bits, so millions of cells fit into memory.
struct Device {
  Stage stage = Stage::prepared;
  unsigned reached = 1;  // a bit for each stage in which it has been
  unsigned clock = 0;
  std::array<unsigned, kMost> heard{};  // for each device of the cell: 0 for nothing, or its stage plus 1
};
using Cell = std::array<Device, kMost>;
using Key = std::uint64_t;

unsigned bit(Stage stage) { return 1U << static_cast<unsigned>(stage); }
Stage stage_of(unsigned heard) { return static_cast<Stage>(heard - 1); }
unsigned heard_as(Stage stage) { return static_cast<unsigned>(stage) + 1; }

// The names of the devices have no meaning, so cells that differ only in the order of their devices are
// equal. The key of a cell is the smallest number of all these orders.
Key key_of(const Cell& cell, std::size_t size) {
  std::array<unsigned, kMost> own{};
  for (std::size_t i = 0; i < size; ++i)
    own[i] = static_cast<unsigned>(cell[i].stage) << 8 | cell[i].reached << 3 | cell[i].clock;
  std::array<std::size_t, kMost> order{0, 1, 2};
  const auto last = order.begin() + static_cast<std::ptrdiff_t>(size);
  const auto before = [&own](std::size_t one, std::size_t other) { return own[one] < own[other]; };
  std::sort(order.begin(), last, before);
  // Only devices that differ in nothing but in what they have heard can change places.
  const bool fixed = std::adjacent_find(order.begin(), last, [&before](std::size_t one, std::size_t other) {
                       return !before(one, other);
                     }) == last;
  if (!fixed) std::sort(order.begin(), last);
  Key smallest = ~Key{0};
  do {
    if (!fixed && !std::is_sorted(order.begin(), last, before)) continue;
    Key key = 0;
    for (std::size_t i = 0; i < size; ++i) key = key << 11 | own[order[i]];
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j < size; ++j) {
        if (i != j) key = key << 3 | cell[order[i]].heard[order[j]];
      }
    }
    smallest = std::min(smallest, key);
  } while (!fixed && std::next_permutation(order.begin(), last));
  return smallest;
}
Cell cell_of(Key key, std::size_t size) {
  Cell cell{};
  const auto take = [&key](int bits) {
    const auto value = static_cast<unsigned>(key & ((1U << bits) - 1));
    key >>= bits;
    return value;
  };
  for (std::size_t i = size; i-- > 0;) {
    for (std::size_t j = size; j-- > 0;) {
      if (i != j) cell[i].heard[j] = take(3);
    }
  }
  for (std::size_t i = size; i-- > 0;) {
    cell[i].clock = take(3);
    cell[i].reached = take(5);
    cell[i].stage = static_cast<Stage>(take(3));
  }
  return cell;
}
std::string text_of(const Cell& cell, std::size_t size) {
  const auto letter = [](unsigned heard) { return "-PARUF"[heard]; };
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    text += std::string{text.empty() ? "" : "  "} + letter(heard_as(cell[i].stage)) + " at " +
            std::to_string(cell[i].clock) + " hears ";
    for (std::size_t j = 0; j < size; ++j) text += letter(cell[i].heard[j]);
  }
  return text;
}

// The rules under test. A wrong variant replaces one of them.
struct Rules {
  std::function<State(const State&, const Others&, std::int64_t)> next = transaction::next;
  std::function<Result<State>(const State&, std::int64_t, std::int64_t)> receive_t0 = transaction::receive_t0;
  std::function<bool(const State&, const Others&)> settled = transaction::settled;
  std::function<Stage(Stage)> restarted = [](Stage stage) {
    return stage == Stage::armed || stage == Stage::running ? Stage::undone : stage;
  };
};

// All cells that were seen, in the order in which they were seen first, and for each the index of the cell
// from which it was reached. A hash table tells which cells are new.
class Seen {
 public:
  // Adds a cell if it is new.
  void add(Key key, std::size_t from) {
    if (keys_.size() * 2 >= table_.size()) grow();
    Key& place = place_of(key);
    if (place != kFree) return;
    place = key;
    keys_.push_back(key);
    from_.push_back(static_cast<std::uint32_t>(from));
  }
  [[nodiscard]] std::size_t size() const { return keys_.size(); }
  [[nodiscard]] Key at(std::size_t index) const { return keys_[index]; }
  [[nodiscard]] std::size_t from(std::size_t index) const { return from_[index]; }

 private:
  static constexpr Key kFree = ~Key{0};

  Key& place_of(Key key) {
    std::size_t slot = (key * 0x9E3779B97F4A7C15U) >> 24;
    while (true) {
      Key& place = table_[slot++ & (table_.size() - 1)];
      if (place == kFree || place == key) return place;
    }
  }
  void grow() {
    table_.assign(std::max<std::size_t>(1024, table_.size() * 4), kFree);
    for (const Key key : keys_) place_of(key) = key;
  }

  std::vector<Key> keys_;
  std::vector<std::uint32_t> from_;
  std::vector<Key> table_;  // its size is a power of 2
};

class Exploration {
 public:
  Exploration(std::size_t size, Rules rules) : size_(size), rules_(std::move(rules)) {}

  // Returns what is wrong in a state that can be reached, with the way to it. Empty if nothing is wrong.
  std::string run() {
    see({});
    for (at_ = 0; at_ < seen_.size() && wrong_.empty(); ++at_) {
      const Cell cell = cell_of(seen_.at(at_), size_);
      check(cell);
      for (std::size_t i = 0; i < size_ && wrong_.empty(); ++i) move(cell, i);
    }
    return wrong_;
  }
  [[nodiscard]] std::size_t states() const { return seen_.size(); }
  [[nodiscard]] std::size_t all_final() const { return all_final_; }
  [[nodiscard]] std::size_t all_undone() const { return all_undone_; }

 private:
  static State state_of(const Device& device) {
    State state{.stage = device.stage, .operator_heard_ns = ns(0)};
    if (device.stage != Stage::prepared) state.t0_ns = kT0;
    return state;
  }
  [[nodiscard]] Others others_of(const Cell& cell, std::size_t mine) const {
    Others others;
    for (std::size_t j = 0; j < size_; ++j) {
      if (j == mine) continue;
      auto& heard = others[std::to_string(j)];
      if (cell[mine].heard[j] != 0) heard = Heard{.stage = stage_of(cell[mine].heard[j]), .t0_ns = kT0};
    }
    return others;
  }
  // A decision depends only on the device itself, so each is computed only once.
  struct Decision {
    Stage stage;
    bool settled;
  };
  Decision decide(const Cell& cell, std::size_t mine) {
    const Device& device = cell[mine];
    std::size_t key = static_cast<unsigned>(device.stage) << 3 | device.clock;
    for (std::size_t j = 0; j < size_; ++j) {
      if (j != mine) key = key << 3 | device.heard[j];
    }
    std::optional<Decision>& decision = decisions_[key];
    if (!decision) {
      const State state = state_of(device);
      const Others others = others_of(cell, mine);
      decision = {rules_.next(state, others, ns(device.clock)).stage, rules_.settled(state, others)};
    }
    return *decision;
  }
  Stage with_t0(const Device& device) {
    std::optional<Stage>& stage = with_t0_[static_cast<unsigned>(device.stage) << 3 | device.clock];
    if (!stage) {
      const auto accepted = rules_.receive_t0(state_of(device), kT0, ns(device.clock));
      stage = accepted ? accepted->stage : device.stage;
    }
    return *stage;
  }

  void see(const Cell& cell) { seen_.add(key_of(cell, size_), at_); }
  void enter(const Cell& before, std::size_t i, Stage stage) {
    Cell cell = before;
    if (stage == cell[i].stage) return;
    cell[i].stage = stage;
    cell[i].reached |= bit(stage);
    if (before[i].stage == Stage::final) complain("a final device has left this stage", cell);
    if (stage == Stage::running) {
      for (std::size_t j = 0; j < size_; ++j) {
        if ((cell[j].reached & bit(Stage::armed)) == 0)
          complain("a device begins, but not all were armed", cell);
      }
    }
    see(cell);
  }
  // Everything that device i can do.
  void move(const Cell& cell, std::size_t i) {
    const Device& device = cell[i];
    enter(cell, i, decide(cell, i).stage);
    enter(cell, i, with_t0(device));
    enter(cell, i, fail({.stage = device.stage}, "").stage);
    if (device.clock < kLast) {
      Cell later = cell;
      ++later[i].clock;
      see(later);
    }
    Cell crashed = cell;
    crashed[i].stage = rules_.restarted(device.stage);
    crashed[i].reached |= bit(crashed[i].stage);
    crashed[i].heard = {};
    see(crashed);
    for (std::size_t j = 0; j < size_; ++j) {
      if (j == i) continue;
      Cell heard = cell;
      heard[i].heard[j] = 0;
      see(heard);
      for (unsigned stage = std::max(device.heard[j], 1U); stage <= heard_as(Stage::final); ++stage) {
        if ((cell[j].reached & bit(stage_of(stage))) == 0) continue;
        heard[i].heard[j] = stage;
        see(heard);
      }
    }
  }

  void check(const Cell& cell) {
    const auto last = cell.begin() + static_cast<std::ptrdiff_t>(size_);
    const auto in = [](Stage stage) {
      return [stage](const Device& device) { return device.stage == stage; };
    };
    const auto all = [&](Stage stage) { return std::all_of(cell.begin(), last, in(stage)); };
    const bool any_final = std::any_of(cell.begin(), last, in(Stage::final));
    bool rests = true;  // everything was heard, all time limits have passed, and no device decides anything
    for (std::size_t i = 0; i < size_; ++i) {
      const Device& device = cell[i];
      rests = rests && device.clock == kLast && decide(cell, i).stage == device.stage;
      for (std::size_t j = 0; j < size_; ++j)
        rests = rests && (j == i || device.heard[j] == heard_as(cell[j].stage));
      if (any_final && (device.reached & bit(Stage::running)) == 0)
        complain("a device is final, but not all have begun", cell);
      if (any_final && device.stage == Stage::undone && decide(cell, i).settled)
        complain("one device is final, and another has gone back for good", cell);
    }
    if (!rests) return;
    if (all(Stage::final))
      ++all_final_;
    else if (all(Stage::undone))
      ++all_undone_;
    else
      complain("the devices disagree although each has heard everything", cell);
  }
  void complain(const std::string& what, const Cell& cell) {
    if (!wrong_.empty()) return;
    wrong_ = what + ":\n  " + text_of(cell, size_);
    for (std::size_t i = at_; i != 0; i = seen_.from(i))
      wrong_ += "\n  " + text_of(cell_of(seen_.at(i), size_), size_);
  }

  const std::size_t size_;
  const Rules rules_;
  Seen seen_;
  std::size_t at_ = 0;  // index of the cell from which the present moves start
  std::array<std::optional<Decision>, 1U << 12U> decisions_;
  std::array<std::optional<Stage>, 1U << 6U> with_t0_;
  std::size_t all_final_ = 0;
  std::size_t all_undone_ = 0;
  std::string wrong_;
};

void explore(std::size_t size) {
  const auto began = std::chrono::steady_clock::now();
  Exploration exploration{size, {}};
  EXPECT_EQ(exploration.run(), "");
  EXPECT_GT(exploration.all_final(), 0U);
  EXPECT_GT(exploration.all_undone(), 0U);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  std::printf("%zu devices: %zu states in %.1f s; at rest, all are final in %zu and undone in %zu\n", size,
              exploration.states(), took.count(), exploration.all_final(), exploration.all_undone());
}

TEST(TransactionExploration, TwoDevicesAlwaysAgree) { explore(2); }
TEST(TransactionExploration, ThreeDevicesAlwaysAgree) {
  if (kSanitized && !full_form()) GTEST_SKIP() << "takes minutes with a sanitizer";
  explore(3);
}

// Each wrong variant leads two devices into a state that is wrong.
std::string wrong(Rules rules) {
  const std::string found = Exploration{2, std::move(rules)}.run();
  return found.substr(0, found.find(':'));
}

TEST(TransactionExploration, FindsADeviceThatBeginsWithoutHearingTheOthers) {
  const auto blind = [](const State& mine, const Others& others, std::int64_t now_ns) {
    Others assumed = others;
    if (mine.stage == Stage::armed) {
      for (auto& [name, heard] : assumed) heard = Heard{.stage = Stage::armed, .t0_ns = kT0};
    }
    return next(mine, assumed, now_ns);
  };
  EXPECT_EQ(wrong({.next = blind}), "a device begins, but not all were armed");
}

TEST(TransactionExploration, FindsADeviceThatSavesNothingOnDisk) {
  EXPECT_NE(wrong({.restarted = [](Stage) { return Stage::prepared; }}), "");
}

TEST(TransactionExploration, FindsADeviceThatDoesNotGoForwardAgain) {
  const auto stubborn = [](const State& mine, const Others& others, std::int64_t now_ns) {
    return mine.stage == Stage::undone ? mine : next(mine, others, now_ns);
  };
  EXPECT_EQ(wrong({.next = stubborn}), "the devices disagree although each has heard everything");
}

TEST(TransactionExploration, FindsAFinalDeviceThatGoesBack) {
  const auto hesitant = [](const State& mine, const Others& others, std::int64_t now_ns) {
    State state = mine;
    for (const auto& [name, heard] : others) {
      if (heard && heard->stage == Stage::undone && mine.stage == Stage::final) state.stage = Stage::undone;
    }
    return state.stage == mine.stage ? next(mine, others, now_ns) : state;
  };
  EXPECT_EQ(wrong({.next = hesitant}), "a final device has left this stage");
}

TEST(TransactionExploration, FindsADeviceThatTakesT0AfterItHasUndoneTheChange) {
  const auto forgetful = [](const State& mine, std::int64_t t0_ns, std::int64_t now_ns) {
    State state = mine;
    if (mine.stage == Stage::undone) state.stage = Stage::prepared;
    return receive_t0(state, t0_ns, now_ns);
  };
  EXPECT_NE(wrong({.receive_t0 = forgetful}), "");
}

TEST(TransactionExploration, FindsADeviceThatForgetsTheChangeTooEarly) {
  const auto hasty = [](const State& mine, const Others&) { return mine.stage == Stage::undone; };
  EXPECT_EQ(wrong({.settled = hasty}), "one device is final, and another has gone back for good");
}

}  // namespace
}  // namespace takt::transaction::exploration_test
