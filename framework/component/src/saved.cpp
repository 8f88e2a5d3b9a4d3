#include <takt/component.hpp>

namespace takt {

SavedBase::SavedBase(Component* owner, void* data, std::uint32_t size, std::uint32_t version)
    : data_(data), size_(size), version_(version), owned_(owner != nullptr) {
  if (!owned_)
    detail::add_loose_saved(*this);
  else if (!detail::report_late("Saved value"))
    owner->saved_.push_back(this);
}

SavedBase::~SavedBase() {
  if (!owned_) detail::remove_loose_saved(*this);
}

}  // namespace takt
