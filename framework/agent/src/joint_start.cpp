#include <takt/agent/joint_start.hpp>

namespace takt::agent {

namespace {

// Returns the names of the devices whose condition is one of `first` to `last`.
std::string heard(const std::map<std::string, Heard>& others, Heard first, Heard last) {
  std::string names;
  for (const auto& [name, what] : others) {
    if (what >= first && what <= last) names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

}  // namespace

void JointStart::fail(const std::string& why) {
  stage_ = Stage::failed;
  why_ = why;
}

void JointStart::step(Instant now, const std::map<std::string, Heard>& others) {
  if (stage_ == Stage::armed) {
    const std::string missing = heard(others, Heard::nothing, Heard::prepared);
    if (now >= t0_ && !missing.empty()) return fail("T0 came before it was heard from " + missing);
    if (now < t0_ - kBegins || !missing.empty()) return;
    stage_ = Stage::begun;
  }
  if (stage_ != Stage::begun && stage_ != Stage::started) return;
  if (const std::string ended = heard(others, Heard::ended, Heard::prepared); !ended.empty())
    return fail("it does not run on " + ended);
  if (now < t0_) return;
  stage_ = Stage::started;
  const std::string silent = heard(others, Heard::nothing, Heard::armed);
  if (silent.empty())
    stage_ = Stage::running;
  else if (now - t0_ > kHeardWithin)
    fail("within " + takt::to_text(kHeardWithin) + " of T0 it was not heard to run on " + silent);
}

}  // namespace takt::agent
