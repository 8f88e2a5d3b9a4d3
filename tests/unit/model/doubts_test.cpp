#include <takt/model/doubts.hpp>

#include <chrono>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model::doubts_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using testing::HasSubstr;

/// A module "writer" with an output "out" and a module "reader" with an input "in" and an event port "event".
class Doubts : public testing::Test {
 protected:
  Doubts() {
    cell.devices.resize(1);
    cell.devices[0].name = "d";
    cell.devices[0].modules.resize(2);
    writer().name = "writer";
    writer().line = 3;
    writer().operation = Operation::periodic;
    writer().period = milliseconds{2};
    reader().name = "reader";
    reader().line = 7;
    reader().operation = Operation::sporadic;
    reader().deadline = milliseconds{1};
    const Type type{"t::T", {}};
    ports = {{std::vector<Port>{{"out", Direction::out, type, ""}},
              std::vector<Port>{{"in", Direction::in, type, ""}, {"event", Direction::event, type, ""}}}};
    cell.file = "cell.xml";
  }

  Module& writer() { return cell.devices[0].modules[0]; }
  Module& reader() { return cell.devices[0].modules[1]; }
  Connection& connect(const std::string& to) {
    Connection connection;
    connection.from = {"d", "writer", "out"};
    connection.to = {"d", "reader", to};
    connection.line = 12;
    cell.connections = {connection};
    return cell.connections[0];
  }
  [[nodiscard]] std::string text() const { return to_text(doubts(cell, ports)); }

  Cell cell;
  CellPorts ports;
};

TEST_F(Doubts, WarnOfAnEventPortThatHoldsOnlyTheLatestValue) {
  Connection& connection = connect("event");
  EXPECT_EQ(text(),
            "cell.xml:12: error: the connection to event port d.reader.event holds only the latest value, so "
            "a new event replaces an event that the module has not read yet; write kind=\"queue\" "
            "depth=\"8\" to keep up to 8 events");
  connection.kind = ConnectionKind::queue;
  connection.depth_given = true;
  EXPECT_EQ(text(), "");
  connect("in");
  EXPECT_EQ(text(), "");
}

TEST_F(Doubts, WarnOfAQueueWithoutADepth) {
  Connection& connection = connect("event");
  connection.kind = ConnectionKind::queue;
  EXPECT_EQ(
      text(),
      "cell.xml:12: error: the queue to d.reader.event has no depth, so it holds 1 sample: a new sample "
      "replaces one that was not read yet; write depth=\"8\" to keep up to 8 samples, or "
      "depth=\"1\" if one is enough");
  connection.to = {};
  EXPECT_THAT(text(), HasSubstr("the queue from d.writer.out has"));
}

TEST_F(Doubts, WarnOfAnEventPortOfAPeriodicModule) {
  Connection& connection = connect("event");
  connection.kind = ConnectionKind::queue;
  connection.depth_given = true;
  reader().operation = Operation::periodic;
  reader().deadline.reset();
  EXPECT_THAT(text(),
              HasSubstr("cell.xml:12: error: event port d.reader.event belongs to a periodic module"));
}

TEST_F(Doubts, WarnOfValuesThatBecomeStaleBeforeTheNextOneIsWritten) {
  Connection& connection = connect("in");
  connection.deadline = milliseconds{2};
  EXPECT_EQ(text(), "");
  connection.deadline = microseconds{500};
  EXPECT_EQ(text(),
            "cell.xml:12: error: the values of d.writer.out become stale after 500 us, before the module "
            "writes the next one: its period is 2 ms; write a deadline that is longer than the period");
  writer().period.reset();
  writer().operation = Operation::non_real;
  EXPECT_EQ(text(), "");
}

TEST_F(Doubts, WarnOfTimesThatProbablyLackAUnit) {
  writer().budget = microseconds{10};
  EXPECT_EQ(text(), "");
  writer().budget = Nanoseconds{500};
  writer().lines.budget = 5;
  reader().deadline = Nanoseconds{9999};
  EXPECT_EQ(text(),
            "cell.xml:5: error: the budget of 'writer' is only 500 ns, which is less than most machines need "
            "to wake a thread; write a unit if you meant one, as in 500us: a number alone is in ns\n"
            "cell.xml:7: error: the deadline of 'reader' is only 9.999 us, which is less than most machines "
            "need to wake a thread; write a unit if you meant one, as in 500us: a number alone is in ns");
}

}  // namespace
}  // namespace takt::model::doubts_test
