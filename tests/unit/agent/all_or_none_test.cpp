// Deploys and updates a cell on the agents of one to three devices on virtual time, while links are cut,
// programs are killed or paused, and commands arrive twice. The agents are real. The network, the operator
// and the work of the devices are models.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <full_form.hpp>

#include "fake_device.hpp"

namespace takt::agent::all_or_none_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Phase = Supervised::Phase;

std::string cell_of(std::size_t devices, const std::string& period = "1000000") {
  std::string text = "<cell name=\"cell\">";
  for (std::size_t i = 0; i < devices; ++i)
    text += "<device name=\"d" + std::to_string(i) +
            "\"><module><name>m</name><filename>m.so</filename><moduletype>thread</moduletype>"
            "<operationtype>periodic</operationtype><period>" +
            period + "</period><priority>1</priority></module></device>";
  return text + "</cell>";
}

/// A disk that survives the node, and takes some time for each write.
class Disk final : public DeploymentStore {
 public:
  explicit Disk(std::function<Instant()> now) : now_(std::move(now)) {}

  void save(const Kept& kept, const std::vector<std::string>& undeployed) override {
    next_ = Content{kept, undeployed};
    written_at_ = now_() + takes;
  }
  [[nodiscard]] std::optional<Result<void>> saved() const override {
    write();
    if (next_) return std::nullopt;
    return Result<void>{};
  }
  [[nodiscard]] Result<Kept> kept() const override { return content_.kept; }
  [[nodiscard]] Result<std::vector<std::string>> undeployed() const override { return content_.undeployed; }
  /// The node has died: what it was writing is lost.
  void lose() {
    write();
    next_.reset();
  }

  Nanoseconds takes{0};

 private:
  struct Content {
    Kept kept;
    std::vector<std::string> undeployed;
  };
  void write() const {
    if (next_ && now_() >= written_at_) content_ = *std::exchange(next_, std::nullopt);
  }

  std::function<Instant()> now_;
  Instant written_at_{};
  mutable std::optional<Content> next_;
  mutable Content content_;
};

/// A fault in one run. Times are counted from the operator's first command.
struct Fault {
  enum class Kind {
    cut,
    cut_one_way,
    pause,
    kill,
    restart,    ///< the node is killed, and a new one with the same disk starts `lasts` later
    doubled,    ///< each command to the device arrives a second time, `lasts` later
    slow_disk,  ///< from then on, each write of the device's disk takes `lasts`
  };
  Kind kind = Kind::cut;
  std::size_t at = 0;     ///< index of a device; the operator if equal to the number of devices
  std::size_t other = 0;  ///< for a cut: the other end of the link
  milliseconds from{0};
  milliseconds lasts{0};

  [[nodiscard]] std::string text() const {
    const std::vector<std::string> kinds{"cut",     "one-way cut",   "pause",    "kill",
                                         "restart", "second copies", "slow disk"};
    return kinds[static_cast<std::size_t>(kind)] + " of " + std::to_string(at) + " (" +
           std::to_string(other) + ") from " + std::to_string(from.count()) + " ms for " +
           std::to_string(lasts.count()) + " ms";
  }
};

class World {
 public:
  struct Update {
    std::optional<std::size_t> fails_on{};  ///< the device whose new version does not start
  };
  /// If `update` is given, the operator deploys the cell and then updates it. The update restarts all
  /// devices.
  World(std::size_t devices, std::vector<Fault> faults, std::optional<Update> update = {})
      : faults_(std::move(faults)), update_(update) {
    for (std::size_t i = 0; i < devices; ++i) {
      disks_.push_back(std::make_shared<Disk>([this] { return now(); }));
      nodes_.push_back(new_node(i));
    }
    for (const Fault& fault : faults_) {
      if (fault.kind == Fault::Kind::restart) restarts_.push_back(fault);
    }
    heard_.assign(devices, std::vector<Instant>(devices + 1, now()));
    lost_.assign(devices, std::vector<bool>(devices + 1, true));
    phase_since_.assign(devices, now());
    phase_.assign(devices, Phase::preparing);
    sent_.resize(devices);
    replied_.resize(devices);
    seen_.resize(devices);
    restarted_.resize(devices);
    ever_started_.assign(devices, false);
    ever_ran_.assign(devices, false);
  }

  void run_until(milliseconds end) {
    while (time_ < end) {
      step_machines();
      step_devices();
      if (operator_present()) step_operator();
      time_ += time_ < seconds{8} ? kTick : 5 * kTick;
    }
  }

  /// True if the device executes the cell, or is about to execute it.
  [[nodiscard]] bool runs(std::size_t i) const {
    return !killed(i) && nodes_[i]->work.supervised > 0 && nodes_[i]->work.phase == Phase::running;
  }
  [[nodiscard]] bool is_new(std::size_t i) const {
    return nodes_[i]->work.cell.devices[i].modules[0].period == milliseconds{2};
  }
  /// True if a device has ever executed the new version.
  [[nodiscard]] bool has_run_new() const { return has_run_new_; }
  [[nodiscard]] bool waits(std::size_t i) const { return nodes_[i]->status().state() == DEVICE_WAITING; }
  [[nodiscard]] bool killed(std::size_t who) const {
    for (const Fault& fault : faults_) {
      if (fault.kind == Fault::Kind::kill && fault.at == who && time_ >= fault.from) return true;
    }
    return false;
  }
  [[nodiscard]] std::size_t devices() const { return nodes_.size(); }
  [[nodiscard]] bool all_ran_at_exit() const { return all_ran_at_exit_; }
  enum class Exit { none, ok, unchanged, unknown };
  [[nodiscard]] Exit exit() const { return exit_; }
  /// The number of devices that have received T0 from the operator.
  [[nodiscard]] std::size_t have_t0() const { return have_t0_; }
  [[nodiscard]] bool all_started() const {
    return std::find(ever_started_.begin(), ever_started_.end(), false) == ever_started_.end();
  }

 private:
  static constexpr milliseconds kTick{20};
  static constexpr milliseconds kLease{300};

  [[nodiscard]] Instant now() const { return from_ns(5'000'000'000) + time_; }
  [[nodiscard]] bool is_operator(std::size_t who) const { return who == nodes_.size(); }
  [[nodiscard]] bool operator_present() const { return active(nodes_.size()); }
  [[nodiscard]] bool active(std::size_t who) const {
    if (killed(who)) return false;
    for (const Fault& fault : faults_) {
      const bool is_away = fault.kind == Fault::Kind::pause || fault.kind == Fault::Kind::restart;
      if (is_away && fault.at == who && time_ >= fault.from && time_ < fault.from + fault.lasts) return false;
    }
    return true;
  }
  [[nodiscard]] bool link(std::size_t from, std::size_t to) const {
    for (const Fault& fault : faults_) {
      if (time_ < fault.from || time_ >= fault.from + fault.lasts) continue;
      const bool there = fault.at == from && fault.other == to;
      const bool back = fault.at == to && fault.other == from;
      if (fault.kind == Fault::Kind::cut && (there || back)) return false;
      if (fault.kind == Fault::Kind::cut_one_way && there) return false;
    }
    return active(from) && active(to);
  }

  [[nodiscard]] std::unique_ptr<FakeDevice> new_node(std::size_t i) const {
    auto node = std::make_unique<FakeDevice>(disks_[i], false, nullptr, "", "d" + std::to_string(i));
    node->work.inspected = Inspected{.paths = {"/m.so"}};
    node->now = now();
    return node;
  }
  void step_machines() {
    for (const Fault& fault : faults_) {
      if (fault.kind == Fault::Kind::slow_disk && time_ >= fault.from) disks_[fault.at]->takes = fault.lasts;
    }
    for (Fault& fault : restarts_) {
      if (time_ < fault.from + fault.lasts || fault.lasts == milliseconds{0}) continue;
      fault.lasts = milliseconds{0};
      nodes_[fault.at].reset();
      disks_[fault.at]->lose();
      nodes_[fault.at] = new_node(fault.at);
      restarted_[fault.at] = now();
      nodes_[fault.at]->agent.resume();
    }
  }

  /// Returns `status` as device `to` receives it. It then contains an immediate answer to that device's own
  /// status.
  [[nodiscard]] DeviceStatus answer(DeviceStatus status, std::size_t to) const {
    status.time_ns(nodes_[to]->wall());
    StatusEcho& echo = status.echoes().emplace_back();
    wire::set(echo.node(), "node of d" + std::to_string(to));
    echo.monotonic_ns(to_ns(now()));
    return status;
  }
  void step_devices() {
    const std::size_t n = nodes_.size();
    // While the link between two nodes is up, the newest status of each reaches the other. After the link was
    // down, the status arrives again.
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t to = 0; to <= n; ++to) {
        if (to == i || !link(i, to)) {
          if (to != i && active(to) && !lost_[i][to] && now() - heard_[i][to] > kLease) {
            lost_[i][to] = true;
            if (is_operator(to))
              seen_[i].alive = false;
            else
              nodes_[to]->agent.others().lost(i + 1);
          }
          continue;
        }
        heard_[i][to] = now();
        lost_[i][to] = false;
        DeviceStatus status = nodes_[i]->status();
        status.sequence_number(++sequence_);
        if (is_operator(to))
          seen_[i] = {status, true};
        else
          nodes_[to]->agent.receive(answer(status, to), i + 1, now());
      }
    }
    // Commands are resent until they have arrived.
    for (std::size_t i = 0; i < n; ++i) {
      if (!active(i)) continue;
      FakeDevice& node = *nodes_[i];
      node.now = now();
      if (link(n, i)) {
        for (const wire::WholeCommand& command : std::exchange(sent_[i], {})) {
          node.receive(command);
          have_t0_ += command.head.kind() == COMMAND_RUN ? 1 : 0;
          for (const Fault& fault : faults_) {
            if (fault.kind == Fault::Kind::doubled && fault.at == i)
              copies_.push_back({now() + fault.lasts, i, command});
          }
        }
        const auto due = std::stable_partition(copies_.begin(), copies_.end(), [&](const Copy& copy) {
          return copy.device != i || copy.at > now();
        });
        for (auto copy = due; copy != copies_.end(); ++copy) {
          if (is_answered(i, copy->command)) node.receive(copy->command);
        }
        copies_.erase(due, copies_.end());
      }
      work(i);
      node.agent.step();
      if (link(i, n)) {
        for (const wire::WholeReply& reply : node.published.replies) replied_[i].push_back(reply);
        node.published.replies.clear();
      }
      ever_started_[i] = ever_started_[i] || node.status().state() >= DEVICE_STARTED;
      has_run_new_ |= update_ && runs(i) && is_new(i);
      ever_ran_[i] = ever_ran_[i] || node.status().state() == DEVICE_RUNNING;
    }
  }

  // The command server drops a second copy as long as the first is not answered.
  [[nodiscard]] bool is_answered(std::size_t i, const wire::WholeCommand& command) const {
    const auto answers = [&command](const wire::WholeReply& reply) {
      return reply.head.id() == command.head.id();
    };
    const auto& replies = nodes_[i]->published.replies;
    return std::any_of(replies.begin(), replies.end(), answers) ||
           std::any_of(replied_[i].begin(), replied_[i].end(), answers);
  }

  // Models the work of the device: it takes some time to prepare and to stop.
  void work(std::size_t i) {
    FakeDevice& node = *nodes_[i];
    if (node.work.supervised == 0 || node.work.phase != phase_[i]) {
      phase_[i] = node.work.phase;
      phase_since_[i] = now();
    }
    if (node.work.supervised == 0) return;
    const Nanoseconds lasted = now() - phase_since_[i];
    if (update_ && update_->fails_on == i && is_new(i) && node.work.phase == Phase::preparing) {
      node.work.failures = {fail("the new version does not start")};
      node.work.phase = Phase::ended;
      return;
    }
    node.work.failures.clear();
    if (node.work.phase == Phase::preparing && lasted >= milliseconds{60 + 100 * i})
      node.work.phase = Phase::ready;
    if (node.work.phase == Phase::stopping && lasted >= milliseconds{100}) node.work.phase = Phase::ended;
  }

  // The operator behaves as client::deploy() and Operator::send() do.
  void step_operator() {
    const std::size_t n = nodes_.size();
    switch (stage_) {
      case 0:
        for (std::size_t i = 0; i < n; ++i) {
          wire::WholeCommand prepare = command(i, COMMAND_PREPARE);
          prepare.data = cell_of(n);
          send(i, prepare, seconds{10});
        }
        stage_ = 1;
        return;
      case 1:
        if (const Replies replies = all_replies(seconds{10}); replies != Replies::open) {
          if (replies == Replies::bad) return undo(false);
          for (std::size_t i = 0; i < n; ++i) {
            wire::WholeCommand change = command(i, COMMAND_CHANGE);
            change.data = changes();
            send(i, change, seconds{10});
          }
          stage_ = 2;
        }
        return;
      case 2:
        if (const Replies replies = all_replies(seconds{10}); replies != Replies::open) {
          if (replies == Replies::bad) return undo(false);
          t0_ = wall() + 1'000'000'000;
          for (std::size_t i = 0; i < n; ++i) {
            wire::WholeCommand run = command(i, COMMAND_RUN);
            run.head.time_ns(t0_);
            send(i, run, milliseconds{800});
          }
          stage_ = 3;
        }
        return;
      case 3:
        if (const Replies replies = all_replies(milliseconds{800}); replies != Replies::open) {
          if (replies == Replies::bad) return undo(true);
          stage_ = 4;
        }
        return;
      case 4: {
        bool all = true;
        bool failed = wall() - t0_ > 6'000'000'000;
        for (const Seen& seen : seen_) {
          const bool ours = seen.status.transaction() == "d1" && seen.status.undeployed() != "d1" &&
                            seen.status.t0_ns() == t0_ && seen.status.stage() != STAGE_UNDONE;
          all &= seen.alive && ours && seen.status.stage() == STAGE_FINAL;
          failed |= seen.alive && !ours && wall() > t0_;
        }
        if (!all && !failed) return;
        if (failed) return undo(true);
        exit_ = update_ ? Exit::none : Exit::ok;
        all_ran_at_exit_ = std::find(ever_ran_.begin(), ever_ran_.end(), false) == ever_ran_.end();
        stage_ = update_ ? 10 : 6;
        return;
      }
      case 5:
        if (const Replies replies = all_replies(seconds{120}); replies != Replies::open) {
          exit_ = replies == Replies::bad || (run_sent_ && unreached_) ? Exit::unknown : Exit::unchanged;
          stage_ = 6;
        }
        return;
      default:
        return update_ ? step_update() : void();
    }
  }

  // The operator behaves as client::update() does.
  void step_update() {
    const std::size_t n = nodes_.size();
    if (!open_.empty() && now() - kept_alive_ > seconds{4}) {
      kept_alive_ = now();
      for (std::size_t i = 0; i < n; ++i) {
        if (link(n, i)) nodes_[i]->receive(command(i, COMMAND_REPORT));
      }
    }
    const auto send_all = [&](CommandKind kind, Nanoseconds limit) {
      kept_alive_ = now();
      for (std::size_t i = 0; i < n; ++i) {
        if (kind == COMMAND_PUT_BACK && !seen_[i].alive) continue;
        wire::WholeCommand c = command(i, kind);
        c.head.property("u1");
        c.head.time_ns(t0_);
        if (kind == COMMAND_PREPARE) c.data = cell_of(n, "2000000");
        if (kind == COMMAND_CHANGE) c.data = changes();
        send(i, c, limit);
      }
      ++stage_;
    };
    const auto count = [&](TransactionStage stage) {
      return static_cast<std::size_t>(std::count_if(seen_.begin(), seen_.end(), [stage](const Seen& seen) {
        return seen.alive && seen.status.transaction() == "u1" && seen.status.stage() == stage;
      }));
    };
    switch (stage_) {
      case 10:
        return send_all(COMMAND_PREPARE, seconds{10});
      case 11:
        if (const Replies replies = all_replies(seconds{120}); replies == Replies::good)
          send_all(COMMAND_CHANGE, seconds{10});
        else if (replies == Replies::bad)
          stage_ = 20;
        return;
      case 12:
        if (const Replies replies = all_replies(seconds{120}); replies == Replies::good) {
          t0_ = wall() + 1'000'000'000;
          run_sent_ = true;
          send_all(COMMAND_RUN, milliseconds{800});
        } else if (replies == Replies::bad) {
          stage_ = 20;
        }
        return;
      case 13:
        if (const Replies replies = all_replies(milliseconds{800}); replies != Replies::open)
          stage_ = replies == Replies::good ? 14 : 20;
        return;
      case 14:
        if (count(STAGE_FINAL) == n) {
          exit_ = Exit::ok;
          stage_ = 6;
        } else if (count(STAGE_UNDONE) > 0 || wall() - t0_ > 6'000'000'000) {
          stage_ = 20;
        }
        return;
      case 20:
        return send_all(COMMAND_PUT_BACK, seconds{10});
      case 21:
        if (const Replies replies = all_replies(seconds{120}); replies != Replies::open) {
          if (!run_sent_) {
            exit_ = any(REPLY_OK) && replies == Replies::good ? Exit::unchanged : Exit::unknown;
            stage_ = 6;
            return;
          }
          judged_from_ = now();
          stage_ = 22;
        }
        return;
      case 22:
        if (count(STAGE_UNDONE) < n && count(STAGE_FINAL) < n && now() - judged_from_ < seconds{6}) return;
        exit_ = count(STAGE_FINAL) > 0     ? Exit::ok
                : count(STAGE_UNDONE) == n ? Exit::unchanged
                                           : Exit::unknown;
        stage_ = 6;
        return;
      default:
        return;
    }
  }
  [[nodiscard]] bool any(ReplyCode code) const { return std::count(codes_.begin(), codes_.end(), code) != 0; }

  wire::WholeCommand command(std::size_t i, CommandKind kind) {
    wire::WholeCommand c;
    c.head.id(std::to_string(++ids_));
    c.head.device("d" + std::to_string(i));
    c.head.kind(kind);
    c.head.deployment("d1");
    c.head.property("d1");
    c.head.value("cell.xml");
    return c;
  }
  /// Returns the data of COMMAND_CHANGE.
  [[nodiscard]] std::string changes() const {
    std::string names;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      names += std::string{i == 0 ? "\"d" : ", \"d"} + std::to_string(i) + "\"";
    return R"({"safe": [], "devices": [)" + names + "]}";
  }
  void send(std::size_t i, wire::WholeCommand c, Nanoseconds limit) {
    c.head.deadline_ns(wall() + limit.count());
    open_.push_back({i, c.head.id().to_string(), now(), {}});
    sent_[i].push_back(c);
  }
  [[nodiscard]] std::int64_t wall() const { return to_ns(now()) + 1'700'000'000'000'000'000; }

  enum class Replies { open, good, bad };
  // Waits for the replies to all commands that are open. As in Operator::send(), a command fails if its
  // node is lost for 700 ms, or if the limit has passed.
  Replies all_replies(Nanoseconds limit) {
    bool bad = false;
    std::vector<ReplyCode> codes;
    for (Open& one : open_) {
      one.done.reset();
      for (const wire::WholeReply& reply : replied_[one.device]) {
        if (reply.head.id() != one.id || one.done)
          continue;  // as in Operator::send(), the first reply counts
        codes.push_back(reply.head.code());
        one.done = reply.head.code() == REPLY_OK ? 1 : 2;
      }
      const bool restarted =
          restarted_[one.device] > one.sent && now() - restarted_[one.device] > milliseconds{700};
      const bool gone = restarted || (!seen_[one.device].alive &&
                                      now() - heard_[one.device][nodes_.size()] > milliseconds{1000});
      if (!one.done && (gone || now() - one.sent > limit)) one.done = 2;
      if (!one.done) return Replies::open;
      bad |= *one.done == 2;
    }
    open_.clear();
    codes_ = codes;
    for (auto& queue : sent_) queue.clear();
    return bad ? Replies::bad : Replies::good;
  }
  void undo(bool run_sent) {
    run_sent_ = run_sent;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (seen_[i].alive)
        send(i, command(i, COMMAND_UNDEPLOY), seconds{10});
      else
        unreached_ = true;
    }
    stage_ = 5;
  }

  struct Seen {
    DeviceStatus status{};
    bool alive = false;
  };
  struct Copy {
    Instant at;
    std::size_t device;
    wire::WholeCommand command;
  };
  struct Open {
    std::size_t device;
    std::string id;
    Instant sent;
    std::optional<int> done;  // 1: REPLY_OK; 2: any other reply, or none
  };

  std::vector<Fault> faults_;
  std::optional<Update> update_;
  Instant kept_alive_{};
  std::vector<ReplyCode> codes_;
  milliseconds time_{0};
  std::vector<std::shared_ptr<Disk>> disks_;  // outlive the nodes
  std::vector<std::unique_ptr<FakeDevice>> nodes_;
  std::vector<Fault> restarts_;              // those that are still to come; `lasts` is 0 for the others
  std::vector<std::vector<Instant>> heard_;  // by sender and receiver
  std::vector<std::vector<bool>> lost_;
  std::vector<Instant> phase_since_;
  std::vector<Phase> phase_;
  std::vector<bool> ever_started_;
  std::vector<bool> ever_ran_;
  bool has_run_new_ = false;
  std::uint64_t sequence_ = 0;
  std::size_t have_t0_ = 0;
  // The following members are the state of the operator.
  int stage_ = 0;
  int ids_ = 0;
  std::int64_t t0_ = 0;
  bool run_sent_ = false;
  bool unreached_ = false;
  Instant judged_from_{};
  bool all_ran_at_exit_ = false;
  std::vector<Open> open_;
  std::vector<std::vector<wire::WholeCommand>> sent_;
  std::vector<Copy> copies_;
  std::vector<std::vector<wire::WholeReply>> replied_;
  std::vector<Seen> seen_;
  std::vector<Instant> restarted_;  // when the node that now runs on the device was started
  Exit exit_ = Exit::none;
};

/// Runs one deployment with these faults, until 20 s after the last link works again. Checks that either all
/// devices run or none does, and that the operator's exit status told the truth.
World::Exit check(std::size_t devices, const std::vector<Fault>& faults) {
  std::string text;
  milliseconds whole{2500};
  bool device_killed = false;
  for (const Fault& fault : faults) {
    text += (text.empty() ? "" : "; ") + fault.text();
    whole = std::max(whole, fault.from + fault.lasts);
    device_killed |= fault.kind == Fault::Kind::kill && fault.at < devices;
  }
  SCOPED_TRACE(std::to_string(devices) + " devices: " + text);
  World world{devices, faults};
  world.run_until(whole + seconds{20});
  std::size_t alive = 0;
  std::size_t run = 0;
  for (std::size_t i = 0; i < devices; ++i) {
    if (world.killed(i)) continue;
    ++alive;
    run += world.runs(i) ? 1 : 0;
    EXPECT_TRUE(world.runs(i) || world.waits(i)) << "device " << i << " is between the two states";
  }
  EXPECT_TRUE(run == 0 || run == alive) << run << " of " << alive << " devices run";
  EXPECT_TRUE(!device_killed || run == 0 || world.all_started()) << "the others started without it";
  switch (world.exit()) {
    case World::Exit::ok:
      EXPECT_TRUE(world.all_ran_at_exit()) << "success was reported before all devices ran";
      EXPECT_EQ(run, alive) << "success was reported, and then the devices ended";
      break;
    case World::Exit::unchanged:
      EXPECT_EQ(run, 0U) << "it was reported that no device has changed";
      break;
    case World::Exit::unknown:
    case World::Exit::none:
      break;
  }
  return world.exit();
}

constexpr milliseconds kLast{5000};
/// The interval between two moments at which a test lets a fault begin.
milliseconds every(int full_ms, int short_ms) {
  if (full_form()) return milliseconds{full_ms};
  return milliseconds{kSanitized ? 12 * short_ms : short_ms};
}

/// The sizes of the cells. Code under sanitizers is ten times slower, and a larger cell shows them nothing
/// new.
std::vector<std::size_t> sizes() {
  if (kSanitized) return {2};
  return {2, 3};
}

TEST(AllOrNone, ACellRunsIfNothingGoesWrong) {
  for (const std::size_t devices : {1U, 2U, 3U}) EXPECT_EQ(check(devices, {}), World::Exit::ok);
}

TEST(AllOrNone, HoldsIfAnyLinkIsCutAtAnyMoment) {
  std::map<World::Exit, std::size_t> exits;
  for (const std::size_t devices : sizes()) {
    for (const Fault::Kind kind : {Fault::Kind::cut, Fault::Kind::cut_one_way}) {
      for (std::size_t at = 0; at <= 1; ++at) {
        for (std::size_t other = 0; other <= devices; ++other) {
          if (at == other || (other < at && kind == Fault::Kind::cut)) continue;
          for (milliseconds from{0}; from < kLast; from += every(60, 780)) {
            for (const int lasts : {100, 500, 1200, 4000, 30000})
              ++exits[check(devices, {{kind, at, other, from, milliseconds{lasts}}})];
          }
        }
      }
    }
  }
  EXPECT_GT(exits[World::Exit::ok], 10 * sizes().size());
  EXPECT_GT(exits[World::Exit::unchanged], 10 * sizes().size());
  if (!kSanitized) {
    EXPECT_GT(exits[World::Exit::unknown], 0U);  // only a few moments leave the operator in doubt
  }
}

TEST(AllOrNone, HoldsIfAllLinksOfTheOperatorAreCutAtAnyMoment) {
  for (const std::size_t devices : sizes()) {
    for (milliseconds from{0}; from < kLast; from += every(20, 260)) {
      for (const int lasts : {500, 2000, 30000}) {
        std::vector<Fault> cuts;
        for (std::size_t i = 0; i < devices; ++i)
          // The links do not break at the same moment, so a command may reach one device and not another.
          cuts.push_back({Fault::Kind::cut, i, devices, from + milliseconds{20} * i, milliseconds{lasts}});
        check(devices, cuts);
      }
    }
  }
}

// The link to device 1 is cut, and then the operator is killed. At some moment of the cut, only device 0 has
// T0.
TEST(AllOrNone, ACellRunsIfTheOperatorIsLostAfterItHasSentT0ToOneDevice) {
  std::size_t ran = 0;
  for (milliseconds from{0}; from < seconds{1}; from += milliseconds{20}) {
    World world{
        2, {{Fault::Kind::cut, 1, 2, from, seconds{60}}, {Fault::Kind::kill, 2, 0, from + milliseconds{40}}}};
    world.run_until(seconds{30});
    EXPECT_EQ(world.runs(0), world.runs(1));
    ran += world.have_t0() == 1 && world.runs(0) ? 1 : 0;
  }
  EXPECT_GT(ran, 0U);
}

TEST(AllOrNone, HoldsIfAnyProgramDiesPausesOrIsRestartedAtAnyMoment) {
  for (const std::size_t devices : sizes()) {
    for (const std::size_t at : {std::size_t{0}, devices - 1, devices}) {
      for (milliseconds from{0}; from < kLast; from += every(20, 620)) {
        check(devices, {{Fault::Kind::kill, at, 0, from, milliseconds{0}}});
        for (const int lasts : {200, 1000, 4000, 30000}) {
          check(devices, {{Fault::Kind::pause, at, 0, from, milliseconds{lasts}}});
          if (at == devices) continue;
          const Fault restart{Fault::Kind::restart, at, 0, from, milliseconds{lasts}};
          check(devices, {restart});
          check(devices, {restart, {Fault::Kind::slow_disk, at, 0, {}, milliseconds{120}}});
        }
      }
    }
  }
}

TEST(AllOrNone, HoldsIfTwoFaultsOccur) {
  for (milliseconds from{0}; from < seconds{3}; from += every(100, 500)) {
    for (milliseconds second{0}; second < seconds{3}; second += every(100, 500)) {
      check(2, {{Fault::Kind::cut, 0, 1, from, seconds{4}}, {Fault::Kind::kill, 2, 0, second, seconds{0}}});
      check(2,
            {{Fault::Kind::restart, 0, 0, from, seconds{1}}, {Fault::Kind::kill, 2, 0, second, seconds{0}}});
      check(2, {{Fault::Kind::cut_one_way, 0, 1, from, seconds{4}},
                {Fault::Kind::restart, 0, 0, second, seconds{1}}});
      check(2, {{Fault::Kind::restart, 0, 0, from, seconds{1}},
                {Fault::Kind::restart, 1, 0, second, seconds{1}}});
      check(2, {{Fault::Kind::cut_one_way, 0, 1, from, seconds{4}},
                {Fault::Kind::cut, 0, 2, second, seconds{2}}});
      check(2, {{Fault::Kind::cut_one_way, 1, 0, from, seconds{4}},
                {Fault::Kind::cut, 0, 2, second, seconds{2}}});
    }
  }
}

// The command server drops a second copy with the same id as long as it remembers the first one.
TEST(AllOrNone, HoldsIfCommandsArriveTwice) {
  for (const std::size_t devices : {1U, 2U, 3U}) {
    for (const int late : {0, 20, 200, 900, 3000, 12000}) {
      const Fault doubled{Fault::Kind::doubled, 0, 0, {}, milliseconds{late}};
      EXPECT_EQ(check(devices, {doubled}), World::Exit::ok);
      for (milliseconds from{0}; from < kLast; from += every(60, 780)) {
        check(devices, {doubled, {Fault::Kind::cut, 0, devices, from, milliseconds{1200}}});
        check(devices, {doubled, {Fault::Kind::kill, devices, 0, from, milliseconds{0}}});
      }
    }
  }
}

/// Deploys a cell, and then updates it while these faults happen. Checks that in the end either all devices
/// run the new version or all run the old one, and that the operator's report was true.
World::Exit check_update(std::size_t devices, const std::vector<Fault>& faults, World::Update update = {}) {
  std::string text;
  milliseconds whole{6000};
  for (const Fault& fault : faults) {
    text += (text.empty() ? "" : "; ") + fault.text();
    whole = std::max(whole, fault.from + fault.lasts);
  }
  SCOPED_TRACE(std::to_string(devices) + " devices: " + text);
  World world{devices, faults, update};
  world.run_until(whole + seconds{20});
  std::size_t is_new = 0;
  for (std::size_t i = 0; i < devices; ++i) {
    EXPECT_TRUE(world.runs(i)) << "device " << i << " does not run";
    is_new += world.is_new(i) ? 1 : 0;
  }
  EXPECT_TRUE(is_new == 0 || is_new == devices) << is_new << " devices run the new version";
  const bool must_be_old = update.fails_on || world.exit() == World::Exit::unchanged;
  EXPECT_TRUE(!must_be_old || is_new == 0);
  EXPECT_TRUE(world.exit() != World::Exit::ok || is_new == devices);
  EXPECT_TRUE(!update.fails_on || !world.has_run_new()) << "a device began before all were ready";
  return world.exit();
}

// The update begins about 1.4 s after the deployment, and takes about 1.6 s.
constexpr milliseconds kUpdates{1400};
constexpr milliseconds kUpdated{3600};

TEST(AllOrNone, AnUpdateIsMadeUnlessItFailsOnADevice) {
  for (const std::size_t devices : {1U, 2U, 3U}) {
    EXPECT_EQ(check_update(devices, {}), World::Exit::ok);
    EXPECT_EQ(check_update(devices, {}, {.fails_on = devices - 1}), World::Exit::unchanged);
  }
}

TEST(AllOrNone, HoldsForAnUpdateIfAnyLinkIsCutAtAnyMoment) {
  for (const std::size_t devices : sizes()) {
    for (const Fault::Kind kind : {Fault::Kind::cut, Fault::Kind::cut_one_way}) {
      for (std::size_t at = 0; at <= devices; ++at) {
        for (std::size_t other = 0; other <= devices; ++other) {
          if (at == other || (other < at && kind == Fault::Kind::cut)) continue;
          for (milliseconds from = kUpdates; from < kUpdated; from += every(40, 600)) {
            for (const int lasts : {100, 1200, 30000})
              check_update(devices, {{kind, at, other, from, milliseconds{lasts}}});
            check_update(devices, {{kind, at, other, from, milliseconds{1200}}}, {.fails_on = 0});
          }
        }
      }
    }
  }
}

TEST(AllOrNone, HoldsForAnUpdateIfADeviceIsRestartedOrPausesAtAnyMoment) {
  for (const std::size_t devices : sizes()) {
    for (milliseconds from = kUpdates; from < kUpdated; from += every(20, 160)) {
      for (const int lasts : {200, 1000, 4000, 30000}) {
        for (const Fault::Kind kind : {Fault::Kind::restart, Fault::Kind::pause})
          check_update(devices, {{kind, devices - 1, 0, from, milliseconds{lasts}}});
        check_update(devices, {{Fault::Kind::restart, devices - 1, 0, from, milliseconds{lasts}},
                               {Fault::Kind::slow_disk, devices - 1, 0, kUpdates, milliseconds{120}}});
      }
    }
  }
}

TEST(AllOrNone, HoldsForAnUpdateIfTwoFaultsOccur) {
  for (milliseconds from = kUpdates; from < kUpdated; from += every(100, 400)) {
    for (milliseconds second = kUpdates; second < kUpdated; second += every(100, 400)) {
      check_update(
          2, {{Fault::Kind::cut, 0, 1, from, seconds{4}}, {Fault::Kind::kill, 2, 0, second, seconds{0}}});
      check_update(
          2, {{Fault::Kind::restart, 0, 0, from, seconds{1}}, {Fault::Kind::kill, 2, 0, second, seconds{0}}});
      check_update(2, {{Fault::Kind::cut_one_way, 0, 1, from, seconds{4}},
                       {Fault::Kind::restart, 0, 0, second, seconds{1}}});
      check_update(2, {{Fault::Kind::restart, 0, 0, from, seconds{1}},
                       {Fault::Kind::restart, 1, 0, second, seconds{1}}});
      check_update(2, {{Fault::Kind::cut_one_way, 1, 0, from, seconds{4}},
                       {Fault::Kind::cut, 0, 2, second, seconds{2}}});
    }
  }
}

TEST(AllOrNone, HoldsForAnUpdateIfTheOperatorIsLostOrPausesAtAnyMoment) {
  for (const std::size_t devices : sizes()) {
    for (milliseconds from = kUpdates; from < kUpdated; from += every(20, 160)) {
      check_update(devices, {{Fault::Kind::kill, devices, 0, from, milliseconds{0}}});
      for (const int lasts : {500, 4000, 30000}) {
        check_update(devices, {{Fault::Kind::pause, devices, 0, from, milliseconds{lasts}}});
        std::vector<Fault> cuts;
        for (std::size_t i = 0; i < devices; ++i)
          cuts.push_back({Fault::Kind::cut, i, devices, from + milliseconds{20} * i, milliseconds{lasts}});
        check_update(devices, cuts);
      }
    }
  }
}

}  // namespace
}  // namespace takt::agent::all_or_none_test
