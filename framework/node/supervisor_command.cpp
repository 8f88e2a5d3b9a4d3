// What an operator may ask of a module while the device runs.
#include <takt/node/supervisor.hpp>

namespace takt::node {

const char* name_of(Verb verb) noexcept {
  switch (verb) {
    case Verb::initialize:
      return "initialize";
    case Verb::start:
      return "start";
    case Verb::stop:
      return "stop";
    case Verb::recover:
      return "recover";
    case Verb::reset:
      return "reset";
    case Verb::destruct:
      return "destruct";
  }
  return "?";
}

void Supervisor::order(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) {
  done({.code = REPLY_REFUSED,
        .state = members_.at(module)->state(),
        .text = std::string{name_of(verb)} + " is not known here"});
}

}  // namespace takt::node
