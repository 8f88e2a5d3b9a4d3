#include <takt/component/port.hpp>

#include <utility>

#include <takt/component.hpp>
#include <takt/component/owner.hpp>

namespace takt {

const char* to_text(PortDirection direction) noexcept {
  switch (direction) {
    case PortDirection::in:
      return "in";
    case PortDirection::event:
      return "event";
    case PortDirection::out:
      return "out";
  }
  return "?";
}

const char* to_text(PortRole role) noexcept {
  switch (role) {
    case PortRole::plain:
      return "port";
    case PortRole::service:
      return "service";
    case PortRole::handler:
      return "handler";
    case PortRole::client:
      return "client";
  }
  return "?";
}

const PortContext PortBase::kNobody{};
const std::vector<std::byte> PortBase::kNoSafe{};

PortBase::PortBase(Component* owner, std::string name, PortDirection direction, const TypeInfo& type,
                   PortOptions options)
    : name_(std::move(name)),
      direction_(direction),
      type_(type),
      options_(std::move(options)),
      owned_(owner != nullptr) {
  if (!owned_)
    detail::add_loose_port(*this);
  else if (!detail::report_late("port '" + name_ + "'"))
    owner->ports_.push_back(this);
}

PortBase::~PortBase() {
  if (!owned_) detail::remove_loose_port(*this);
}

}  // namespace takt
