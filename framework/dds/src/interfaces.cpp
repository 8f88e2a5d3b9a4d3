#include "interfaces.hpp"

#include <algorithm>

namespace takt::dds {

namespace {

bool contains(const Interfaces::List& list, const os::InterfaceAddress& one) {
  return std::any_of(list.begin(), list.end(), [&](const os::InterfaceAddress& each) {
    return each.interface == one.interface && each.address == one.address;
  });
}

bool contains(const Interfaces::List& list, const os::Ipv4& address) {
  return std::any_of(list.begin(), list.end(),
                     [&](const os::InterfaceAddress& each) { return each.address == address; });
}

}  // namespace

bool is_group(const os::Ipv4& address) noexcept { return (address.front() & 0xF0) == 0xE0; }

Interfaces::Change Interfaces::update(const List& known_to_kernel) {
  const std::lock_guard lock{mutex_};
  List used;
  for (const os::InterfaceAddress& each : known_to_kernel) {
    if ((each.connected || contains(used_, each)) && allows(each.address)) used.push_back(each);
  }
  Change change;
  for (const os::InterfaceAddress& each : used) change.added |= !contains(used_, each);
  for (const os::InterfaceAddress& each : used_) {
    if (contains(used, each)) continue;
    change.any = true;
    change.removed_used |= heard_.erase(each.address) > 0;
    lost_.insert(each.address);
  }
  for (const os::InterfaceAddress& each : known_to_kernel) lost_.erase(each.address);
  change.any |= change.added;
  all_ = known_to_kernel;
  used_ = std::move(used);
  return change;
}

Interfaces::List Interfaces::used() const {
  const std::lock_guard lock{mutex_};
  return used_;
}

void Interfaces::settle() {
  const std::lock_guard lock{mutex_};
  settled_ = used_;
}

Interfaces::List Interfaces::for_groups() const {
  const std::lock_guard lock{mutex_};
  List list;
  for (const os::InterfaceAddress& each : settled_) {
    const bool first = list.empty() || list.back().interface != each.interface;
    if (first && (each.loopback || !options_.groups_stay_here)) list.push_back(each);
  }
  return list;
}

std::vector<os::Ipv4> Interfaces::announced() const {
  std::vector<os::Ipv4> addresses;
  for (const os::InterfaceAddress& each : used()) {
    if (!each.loopback) addresses.push_back(each.address);
  }
  if (addresses.empty()) addresses.push_back(os::kLoopbackAddress);
  return addresses;
}

bool Interfaces::is_mine(const os::Ipv4& address) const {
  if (address.front() == os::kLoopbackAddress.front()) return true;
  const std::lock_guard lock{mutex_};
  return contains(all_, address) || lost_.contains(address);
}

bool Interfaces::comes_from_here(const os::Ipv4& sender) {
  if (sender.front() == os::kLoopbackAddress.front()) return true;
  const std::lock_guard lock{mutex_};
  lost_.erase(sender);
  return contains(all_, sender);
}

bool Interfaces::allows(const os::Ipv4& address) const {
  return options_.only.empty() || address.front() == os::kLoopbackAddress.front() ||
         std::find(options_.only.begin(), options_.only.end(), address) != options_.only.end();
}

bool Interfaces::receives(const os::Ipv4& to, int interface) const {
  if (!is_group(to)) return allows(to);
  const List groups = for_groups();
  return std::any_of(groups.begin(), groups.end(),
                     [&](const os::InterfaceAddress& each) { return each.interface == interface; });
}

void Interfaces::heard_at(const os::Ipv4& address) {
  const std::lock_guard lock{mutex_};
  heard_.insert(address);
}

}  // namespace takt::dds
