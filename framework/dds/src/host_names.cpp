#include "host_names.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include <takt/core/words.hpp>

namespace takt::dds {

namespace {

constexpr Nanoseconds kLookUp = std::chrono::seconds{3};
constexpr Nanoseconds kLookUpIfAlive = std::chrono::minutes{1};
/// A peer announces itself more often than this.
constexpr Nanoseconds kAliveFor = std::chrono::seconds{3};
/// Each look-up under way has a thread.
constexpr std::size_t kLookUpsAtOnce = 16;
/// The first number of the placeholders. No machine has such an address (RFC 1112, section 4).
constexpr std::uint8_t kPlaceholder = 240;

std::size_t name_index(const os::Ipv4& placeholder) {
  return placeholder[2] * std::size_t{256} + placeholder[3];
}

std::string addresses_text(const std::vector<os::Ipv4>& addresses) {
  std::string text;
  for (const os::Ipv4& each : addresses) text += (text.empty() ? "" : ", ") + os::in_dots(each);
  return text;
}

}  // namespace

os::Ipv4 HostNames::add(const std::string& role, const std::string& host) {
  if (const auto address = os::from_dots(host)) return *address;
  return add({.role_and_name = role + " " + in_quotes(host), .name = host});
}

os::Ipv4 HostNames::add_server(const std::string& host) {
  const auto address = os::from_dots(host);
  return add({.role_and_name = "discovery server " + in_quotes(host),
              .name = address ? "" : host,
              .addresses = address ? std::vector{*address} : std::vector<os::Ipv4>{}});
}

os::Ipv4 HostNames::add(Host host) {
  const std::size_t index = hosts_.size();
  hosts_.push_back(std::move(host));
  return {kPlaceholder, 0, static_cast<std::uint8_t>(index / 256), static_cast<std::uint8_t>(index % 256)};
}

bool HostNames::is_placeholder(const os::Ipv4& address) noexcept { return address.front() == kPlaceholder; }

void HostNames::step(Instant now) {
  std::vector<std::size_t> begin;
  std::vector<std::string> news;
  {
    const std::lock_guard lock{mutex_};
    for (std::size_t i = 0; i < hosts_.size(); ++i) {
      Host& host = hosts_[i];
      if (host.addresses.empty()) {
        if (!host.reason.empty() && !std::exchange(host.warned, true))
          news.push_back("warning: " + host.role_and_name + " cannot be resolved yet: " + host.reason +
                         "; trying again");
      } else if (host.addresses != host.told) {
        if (std::exchange(host.warned, false) || !host.told.empty())
          news.push_back(host.role_and_name + " has the address " + addresses_text(host.addresses));
        host.told = host.addresses;
      }
      if (std::exchange(host.heard, false)) host.alive = now;
      const bool is_alive = host.alive && now - *host.alive < kAliveFor;
      if (host.name.empty() || host.under_way || under_way_ == kLookUpsAtOnce) continue;
      if (host.looked_up && now - *host.looked_up < (is_alive ? kLookUpIfAlive : kLookUp)) continue;
      host.under_way = true;
      ++under_way_;
      host.looked_up = now;
      begin.push_back(i);
    }
  }
  for (const std::string& each : news) {
    if (tell_) tell_(each);
  }
  for (const std::size_t i : begin) {
    look_up_(hosts_[i].name, [i, weak = weak_from_this()](const Result<std::vector<os::Ipv4>>& result) {
      if (const auto self = weak.lock()) self->found(i, result);
    });
  }
}

void HostNames::found(std::size_t index, const Result<std::vector<os::Ipv4>>& result) {
  {
    const std::lock_guard lock{mutex_};
    Host& host = hosts_[index];
    host.under_way = false;
    --under_way_;
    if (result) {
      host.addresses = *result;
      std::sort(host.addresses.begin(), host.addresses.end());  // name services change the order
      host.addresses.erase(std::unique(host.addresses.begin(), host.addresses.end()), host.addresses.end());
    } else {
      host.reason = result.problems().front().what;
    }
  }
  ended_.notify_all();
}

void HostNames::announced(const os::Ipv4& placeholder, const std::vector<os::Ipv4>& addresses) {
  const std::lock_guard lock{mutex_};
  hosts_.at(name_index(placeholder)).announced = addresses;
}

void HostNames::heard(const os::Ipv4& address) {
  if (hosts_.empty()) return;
  const std::lock_guard lock{mutex_};
  for (Host& host : hosts_) {
    for (const auto* list : {&host.addresses, &host.announced})
      host.heard |= std::find(list->begin(), list->end(), address) != list->end();
  }
}

void HostNames::wait(Nanoseconds limit) {
  std::unique_lock lock{mutex_};
  ended_.wait_for(lock, limit, [this] { return under_way_ == 0; });
}

std::vector<os::Ipv4> HostNames::addresses(const os::Ipv4& placeholder) const {
  const std::lock_guard lock{mutex_};
  const std::size_t index = name_index(placeholder);
  if (index >= hosts_.size()) return {};
  std::vector<os::Ipv4> all = hosts_[index].addresses;
  for (const os::Ipv4& each : hosts_[index].announced) {
    if (std::find(all.begin(), all.end(), each) == all.end()) all.push_back(each);
  }
  return all;
}

std::string HostNames::unresolved() const {
  const std::lock_guard lock{mutex_};
  std::string text;
  for (const Host& host : hosts_) {
    if (!host.addresses.empty()) continue;
    text += (text.empty() ? "" : "; ") + host.role_and_name + " cannot be resolved: " +
            (host.reason.empty() ? "the name service has not answered yet" : host.reason);
  }
  return text;
}

}  // namespace takt::dds
