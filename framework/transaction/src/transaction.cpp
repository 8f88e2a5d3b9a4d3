#include <takt/transaction/transaction.hpp>

#include <algorithm>

#include <takt/core/span.hpp>

namespace takt::transaction {

namespace {

using Other = Others::value_type;

template <class Condition>
const Other* find(const Others& others, Condition condition) {
  const auto found = std::find_if(others.begin(), others.end(), [&condition](const Other& other) {
    return other.second && condition(*other.second);
  });
  return found == others.end() ? nullptr : &*found;
}

// Returns the names of the devices that were not heard in a stage that satisfies the condition.
template <class Condition>
std::string all_except(const Others& others, Condition condition) {
  std::string names;
  for (const auto& [name, heard] : others) {
    if (!heard || !condition(*heard)) names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

std::string not_heard(const std::string& names, const std::string& what) {
  return names + (names.find(',') == std::string::npos ? " was" : " were") + " not heard to " + what;
}

State at(const State& mine, Stage stage) {
  State state = mine;
  state.stage = stage;
  return state;
}

State undone(const State& mine, const std::string& why) {
  State state = at(mine, Stage::undone);
  state.why = why;
  return state;
}

State wait_for_t0(const State& mine, const Others& others, std::int64_t now_ns) {
  const Other* const armed = find(others, [](const Heard& heard) { return heard.stage != Stage::prepared; });
  if (armed != nullptr) {
    // The operator may have been lost after it has sent T0 to one device only.
    auto accepted = receive_t0(mine, armed->second->t0_ns, now_ns);
    return accepted ? *accepted : undone(mine, in_words(accepted.problems()));
  }
  if (span(mine.operator_heard_ns, now_ns) <= kOperatorSilent) return mine;
  return undone(mine, "no message of the operator arrived within " + takt::to_text(kOperatorSilent));
}

State wait_for_armed(const State& mine, const Others& others, std::int64_t now_ns) {
  const Nanoseconds since_t0 = span(mine.t0_ns, now_ns);
  if (since_t0 < -kBegins) return mine;
  const std::string missing = all_except(others, [&mine](const Heard& heard) {
    return heard.stage != Stage::prepared && heard.t0_ns == mine.t0_ns;
  });
  if (missing.empty()) return at(mine, Stage::running);
  if (since_t0 < Nanoseconds{0}) return mine;
  return undone(mine, not_heard(missing, "be ready before T0"));
}

State wait_for_running(const State& mine, const Others& others, std::int64_t now_ns) {
  const Nanoseconds since_t0 = span(mine.t0_ns, now_ns);
  if (since_t0 < Nanoseconds{0}) return mine;
  const std::string silent =
      all_except(others, [](const Heard& heard) { return heard.stage == Stage::running; });
  if (silent.empty()) return at(mine, Stage::final);
  if (since_t0 <= kHeardWithin) return mine;
  return undone(mine, not_heard(silent, "run within " + takt::to_text(kHeardWithin) + " of T0"));
}

}  // namespace

Result<State> receive_t0(const State& mine, std::int64_t t0_ns, std::int64_t now_ns) {
  if (mine.stage == Stage::undone) return takt::fail("it has been undone: " + mine.why);
  if (mine.stage != Stage::prepared) {
    if (mine.t0_ns == t0_ns) return mine;
    return takt::fail("it already has another start time");
  }
  const Nanoseconds ahead = span(now_ns, t0_ns);
  const std::string cure = "synchronise the clocks of the devices";
  if (ahead <= Nanoseconds{0})
    return takt::fail("the start time passed " + takt::to_text(-ahead) + " ago", cure);
  if (ahead > kFurthestStart) {
    return takt::fail("the start time is " + takt::to_text(ahead) + " in the future, more than the allowed " +
                          takt::to_text(kFurthestStart),
                      cure);
  }
  State state = at(mine, Stage::armed);
  state.t0_ns = t0_ns;
  return state;
}

State fail(const State& mine, const std::string& why) {
  return mine.stage == Stage::undone || mine.stage == Stage::final ? mine : undone(mine, why);
}

State next(const State& mine, const Others& others, std::int64_t now_ns) {
  if (mine.stage == Stage::final) return mine;
  if (const Other* const final =
          find(others, [](const Heard& heard) { return heard.stage == Stage::final; })) {
    State state = at(mine, Stage::final);
    state.t0_ns = final->second->t0_ns;
    state.why.clear();
    return state;
  }
  if (mine.stage == Stage::undone) return mine;
  if (const Other* const other =
          find(others, [](const Heard& heard) { return heard.stage == Stage::undone; }))
    return undone(mine, "device " + other->first + " has undone it");
  switch (mine.stage) {
    case Stage::prepared:
      return wait_for_t0(mine, others, now_ns);
    case Stage::armed:
      return wait_for_armed(mine, others, now_ns);
    default:
      return wait_for_running(mine, others, now_ns);
  }
}

bool settled(const State& mine, const Others& others) {
  const bool over = mine.stage == Stage::undone || mine.stage == Stage::final;
  return over &&
         all_except(others, [&mine](const Heard& heard) { return heard.stage == mine.stage; }).empty();
}

}  // namespace takt::transaction
