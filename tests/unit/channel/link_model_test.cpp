// Tests a small link with a few samples in every interleaving of its writer and its reader, and with every
// moment at which the writer or the reader can die and be replaced. The test runs the real code of the link,
// but with atomics that hand control to a scheduler before each step. The scheduler tries all orders of
// steps, and visits each state once.
#include <takt/channel/link.hpp>

#include <gtest/gtest.h>
#include <ucontext.h>
#include <full_form.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <unordered_set>
#include <vector>

namespace takt::channel::link_model_test {
namespace {

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
  hash ^= value + 0x9e37'79b9'7f4a'7c15 + (hash << 12) + (hash >> 4);
  hash *= 0xff51'afd7'ed55'8ccd;
  return hash ^ (hash >> 32);
}

/// The writer or the reader of the link, stopped between two of its steps. The scheduler never resumes a
/// killed writer or reader.
class Fiber {
 public:
  static Fiber* running;

  void begin(std::function<void()> script) {
    script_ = std::move(script);
    done = false;
    known = 0;
    ::getcontext(&mine_);
    mine_.uc_stack.ss_sp = stack_.get();
    mine_.uc_stack.ss_size = kStack;
    mine_.uc_link = &scheduler_;
    ::makecontext(&mine_, reinterpret_cast<void (*)()>(&Fiber::main), 0);
  }
  /// Runs this writer or reader up to its next step.
  void resume() {
    running = this;
    ::swapcontext(&scheduler_, &mine_);
    running = nullptr;
  }
  void pause() { ::swapcontext(&mine_, &scheduler_); }
  void learn(std::uint64_t value) { known = mixed(known, value); }

  bool done = true;
  /// Hash of everything that this writer or reader has read. Together with its script, the hash determines
  /// its state.
  std::uint64_t known = 0;

 private:
  static void main() {
    running->script_();
    running->done = true;
  }
  static constexpr std::size_t kStack = 64 * 1024;
  std::unique_ptr<char[]> stack_ = std::make_unique<char[]>(kStack);
  std::function<void()> script_;
  ucontext_t mine_{};
  ucontext_t scheduler_{};
};
Fiber* Fiber::running = nullptr;

void step() {
  if (Fiber::running != nullptr) Fiber::running->pause();
}
template <class T>
T learned(T value) {
  if (Fiber::running != nullptr) Fiber::running->learn(static_cast<std::uint64_t>(value) + 1);
  return value;
}

template <class T>
class Stepped {
 public:
  T load(std::memory_order) const noexcept {
    step();
    return learned(value_);
  }
  void store(T value, std::memory_order) noexcept {
    step();
    value_ = value;
    learned(0);
  }
  bool compare_exchange_strong(T& expected, T value, std::memory_order, std::memory_order) noexcept {
    step();
    if (value_ == expected) {
      value_ = value;
      return learned(true);
    }
    expected = learned(value_);
    return false;
  }

 private:
  T value_;
};

struct Limits {
  std::uint32_t depth;
  int samples;       ///< number of samples that each writer publishes
  int takes;         ///< how often each reader tries to take a sample
  int writer_kills;  ///< how often a writer may be killed and replaced
  int reader_kills;
};

enum class Move : std::uint8_t { write, read, kill_writer, kill_reader };

class World {
 public:
  explicit World(Limits limits) : limits_(limits), memory_(Link::layout(options()).size() + 64) {
    auto address = reinterpret_cast<std::uintptr_t>(memory_.data());
    start_ = memory_.data() + (64 - address % 64) % 64;
    size_ = Link::layout(options()).size();
  }

  void begin() {
    std::memset(start_, 0, size_);
    Link::format(start_, options());
    link_ = Link{start_};
    writer_kills_ = reader_kills_ = 0;
    last_read_ = 0;
    wrong_.clear();
    begin_writer();
    begin_reader();
  }

  [[nodiscard]] bool can(Move move) const {
    switch (move) {
      case Move::write:
        return !writer_.done;
      case Move::read:
        return !reader_.done;
      case Move::kill_writer:
        return !writer_.done && writer_kills_ < limits_.writer_kills;
      case Move::kill_reader:
        return !reader_.done && reader_kills_ < limits_.reader_kills;
    }
    return false;
  }
  void make(Move move) {
    switch (move) {
      case Move::write:
        writer_.resume();
        break;
      case Move::read:
        reader_.resume();
        break;
      case Move::kill_writer:
        ++writer_kills_;
        begin_writer();
        break;
      case Move::kill_reader:
        ++reader_kills_;
        begin_reader();
        break;
    }
  }

  [[nodiscard]] std::uint64_t state() const {
    std::uint64_t hash = mixed(writer_.known, reader_.known);
    hash = mixed(hash, static_cast<std::uint64_t>(writer_kills_ * 8 + reader_kills_));
    hash = mixed(hash, last_read_);
    hash = mixed(hash, (writer_.done ? 2U : 0U) + (reader_.done ? 1U : 0U));
    for (std::size_t i = 0; i < size_; i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, start_ + i, 8);
      hash = mixed(hash, word);
    }
    return hash;
  }

  /// Checks the final state, after the writer and the reader (or their replacements) are done: every buffer
  /// must have exactly one owner, and the remaining samples must be complete.
  void check_end() {
    LinkWriter writer{link_};
    LinkReader reader{link_};
    std::set<std::uint32_t> owned{writer.buffer(), reader.buffer()};
    for (std::uint32_t i = 0; i < limits_.depth; ++i)
      owned.insert(SlotWord::index(link_.slot(i).load(std::memory_order_seq_cst)));
    if (owned.size() != limits_.depth + 2) wrong_ = "a buffer has two owners";
    const std::uint64_t newest = writer.next() - 1;
    std::uint64_t expected = 0;
    while (reader.take()) {
      check(reader);
      if (expected != 0 && reader.info().sequence != expected) wrong_ = "a sample is missing among the rest";
      expected = reader.info().sequence + 1;
    }
    if (last_read_ > newest) wrong_ = "a sample was read that was never published";
    if (expected != 0 && expected != newest + 1) wrong_ = "the newest sample is missing";
    // Checks that the link can carry one more sample.
    fill(writer, writer.next());
    writer.publish(16, 1);
    if (!reader.has_news() || !reader.take() || reader.info().sequence != newest + 1)
      wrong_ = "the link does not continue";
    check(reader);
  }
  [[nodiscard]] const std::string& wrong() const { return wrong_; }

 private:
  using Link = BasicLink<Stepped>;
  using LinkWriter = BasicLinkWriter<Stepped>;
  using LinkReader = BasicLinkReader<Stepped>;

  [[nodiscard]] Link::Options options() const {
    return {.depth = limits_.depth, .payload = 16, .is_queue = limits_.depth > 1};
  }
  // A payload consists of two words. The writer and the reader access each word in a separate step.
  std::array<Stepped<std::uint64_t>, 2>& words(std::uint32_t buffer) {
    return *reinterpret_cast<std::array<Stepped<std::uint64_t>, 2>*>(link_.payload(buffer));
  }
  void fill(LinkWriter& writer, std::uint64_t value) {
    for (auto& word : words(writer.buffer())) word.store(value, std::memory_order_relaxed);
  }
  void check(LinkReader& reader) {
    const std::uint64_t sequence = reader.info().sequence;
    for (auto& word : words(reader.buffer())) {
      if (word.load(std::memory_order_relaxed) != sequence) wrong_ = "a sample is torn";
    }
    if (sequence <= last_read_) wrong_ = "a sample was read twice, or out of order";
    last_read_ = sequence;
  }

  void begin_writer() {
    writer_.begin([this] {
      LinkWriter writer{link_};
      for (int i = 0; i < limits_.samples; ++i) {
        fill(writer, writer.next());
        writer.publish(16, 1);
      }
    });
    writer_.resume();  // runs the writer up to its first step
  }
  void begin_reader() {
    reader_.begin([this] {
      LinkReader reader{link_};
      for (int i = 0; i < limits_.takes; ++i) {
        if (reader.take()) check(reader);
      }
    });
    reader_.resume();
  }

  Limits limits_;
  std::vector<std::byte> memory_;
  std::byte* start_ = nullptr;
  std::size_t size_ = 0;
  Link link_;
  Fiber writer_;
  Fiber reader_;
  int writer_kills_ = 0;
  int reader_kills_ = 0;
  std::uint64_t last_read_ = 0;
  std::string wrong_;
};

struct Found {
  std::size_t states = 0;
  std::size_t ends = 0;
  std::string wrong;
  std::vector<Move> path;
};

Found explore(Limits limits) {
  World world{limits};
  world.begin();
  Found found;
  std::unordered_set<std::uint64_t> seen;
  std::vector<Move> path;
  std::vector<std::vector<Move>> open;  // for each step of the current path, the moves not yet tried

  const auto moves = [&world] {
    std::vector<Move> possible;
    for (const Move move : {Move::kill_writer, Move::kill_reader, Move::write, Move::read}) {
      if (world.can(move)) possible.push_back(move);
    }
    return possible;
  };
  open.push_back(moves());
  while (!open.empty()) {
    if (open.back().empty()) {
      open.pop_back();
      if (path.empty()) break;
      path.pop_back();
      while (!open.empty() && open.back().empty() && !path.empty()) {
        open.pop_back();
        path.pop_back();
      }
      if (open.empty() || open.back().empty()) break;
      world.begin();  // returns to an earlier state by repeating the path from the start
      for (const Move move : path) world.make(move);
    }
    const Move move = open.back().back();
    open.back().pop_back();
    path.push_back(move);
    world.make(move);
    const bool is_new = seen.insert(world.state()).second;
    std::vector<Move> next;
    if (is_new) next = moves();
    if (is_new && next.empty()) {
      ++found.ends;
      world.check_end();
    }
    if (!world.wrong().empty()) {
      found.wrong = world.wrong();
      found.path = path;
      break;
    }
    open.push_back(std::move(next));
  }
  found.states = seen.size();
  return found;
}

std::string in_letters(const std::vector<Move>& path) {
  std::string text;
  for (const Move move : path) text += "wrWR"[static_cast<std::size_t>(move)];
  return text;
}

std::string name_of(const testing::TestParamInfo<Limits>& parameters) {
  const Limits& l = parameters.param;
  return "Depth" + std::to_string(l.depth) + "Samples" + std::to_string(l.samples) + "Takes" +
         std::to_string(l.takes) + "Kills" + std::to_string(l.writer_kills) + std::to_string(l.reader_kills);
}

class LinkModel : public testing::TestWithParam<Limits> {
 protected:
  static void expect_no_sample_wrong() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "the sanitizers do not support the separate stacks of the writer and the reader";
#endif
    const Found found = explore(GetParam());
    EXPECT_EQ(found.wrong, "") << "after " << in_letters(found.path) << " (capital: killed)";
    EXPECT_GT(found.ends, 1U);
    RecordProperty("states", static_cast<int>(found.states));
  }
};
class LargeLinkModel : public LinkModel {};

TEST_P(LinkModel, NeverLosesOrDuplicatesOrTearsASample) { expect_no_sample_wrong(); }

TEST_P(LargeLinkModel, NeverLosesOrDuplicatesOrTearsASample) {
  if (!full_form()) GTEST_SKIP() << "takes up to half a minute; runs in the full form only";
  expect_no_sample_wrong();
}

INSTANTIATE_TEST_SUITE_P(Small, LinkModel,
                         testing::Values(Limits{1, 3, 3, 0, 0}, Limits{2, 4, 3, 0, 0}, Limits{3, 5, 3, 0, 0},
                                         Limits{1, 2, 2, 1, 0}, Limits{1, 2, 2, 0, 1}, Limits{1, 1, 1, 1, 1},
                                         Limits{1, 1, 1, 2, 0}, Limits{1, 3, 1, 0, 2}, Limits{2, 3, 1, 1, 0},
                                         Limits{2, 4, 2, 0, 1}),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Large, LargeLinkModel,
                         testing::Values(Limits{1, 2, 2, 1, 1}, Limits{1, 2, 1, 2, 0}, Limits{2, 3, 2, 1, 0},
                                         Limits{2, 2, 2, 1, 1}, Limits{3, 5, 2, 0, 1}, Limits{3, 4, 2, 1, 0},
                                         Limits{3, 2, 2, 1, 1}, Limits{1, 1, 1, 2, 2}),
                         name_of);

}  // namespace
}  // namespace takt::channel::link_model_test
