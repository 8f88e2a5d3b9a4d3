#include "network.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace takt::simulation {

namespace {

using std::chrono::microseconds;

/// The latency of a sample on an idle local network, from the gateway of one node to the gateway of another.
constexpr Nanoseconds kShortest = microseconds{60};
constexpr Nanoseconds kUsual = microseconds{250};
constexpr Nanoseconds kLongestDelay = microseconds{3000};
constexpr double kSeldom = 0.002;
/// The maximum time from the end of a cut until a reliable writer sends again.
constexpr Nanoseconds kResend = microseconds{2000};

std::pair<std::uint32_t, std::uint32_t> ordered(std::uint32_t a, std::uint32_t b) {
  return std::minmax(a, b);
}

std::uint32_t device_of(const model::Cell& cell, const std::string& name) {
  const auto found = std::find_if(cell.devices.begin(), cell.devices.end(),
                                  [&name](const model::Device& device) { return device.name == name; });
  return static_cast<std::uint32_t>(found - cell.devices.begin());
}

}  // namespace

Network::Network(const World& world)
    : world_(world), draws_(world.seed, "network"), message_draws_(world.seed, "messages") {
  for (const SimulatedCell& version : world.versions) {
    for (const std::uint32_t number : version.numbers)
      ways_.resize(std::max<std::size_t>(ways_.size(), number + 1));
  }
}

Nanoseconds Network::latency(Draws& draws) {
  return draws.chance(kSeldom) ? draws.between(kUsual, kLongestDelay) : draws.between(kShortest, kUsual);
}

std::optional<Instant> Network::past_cuts(std::pair<std::uint32_t, std::uint32_t> between, Instant arrival,
                                          bool reliable, Draws& draws) const {
  const auto cut = cut_until_.find(between);
  if (cut == cut_until_.end() || arrival > cut->second) return arrival;
  if (!reliable) return std::nullopt;
  return cut->second + draws.between(Nanoseconds{0}, kResend);
}

void Network::tell(std::uint32_t from, std::uint32_t to, bool reliable, std::function<void()> arrive) {
  const Instant uncut = world_.kernel.now() + latency(message_draws_) +
                        message_draws_.between(Nanoseconds{0}, world_.message_delay);
  const auto arrival = past_cuts(ordered(from, to), uncut, reliable, message_draws_);
  if (!arrival) return;
  Instant& last = last_told_[{from, to}];
  last = std::max(*arrival, last + Nanoseconds{1});
  world_.kernel.at(last, std::move(arrive));
}

void Network::connect(Device& device, SimulatedLink& link) {
  Way& way = ways_[link.number()];
  way.to = &device;
  way.link = &link;
  way.between = ordered(device_of(world_.cell(), link.model().from.device),
                        device_of(world_.cell(), link.model().to.device));
}

void Network::disconnect(const Device& device) {
  for (Way& way : ways_) {
    if (way.to == &device) way.to = nullptr;
  }
}

void Network::send(std::uint32_t version, const SimulatedLink& from, const std::byte* sample,
                   std::int64_t wall_ns) {
  Way& way = ways_[from.number()];
  if (way.to == nullptr) return;  // the reader is an external program, or its device is not there
  const Instant now = world_.kernel.now();
  const Nanoseconds late = std::exchange(way.to_delay, Nanoseconds{0});
  auto arrival = past_cuts(way.between, now + latency(draws_) + late,
                           from.model().reliability == model::Reliability::reliable, draws_);
  if (way.to_lose != 0) {
    --way.to_lose;
    arrival.reset();
  }
  if (!arrival) {
    ++way.lost;
    world_.listener.on_event({.at = now,
                              .what = What::lost,
                              .version = version,
                              .connection = from.connection(),
                              .number = number_of(sample)});
    return;
  }
  way.last = std::max(*arrival, way.last + Nanoseconds{1});  // keeps the order of the samples
  std::array<std::byte, kSampleBytes> bytes{};
  std::memcpy(bytes.data(), sample, bytes.size());
  world_.kernel.at(way.last, [&way, bytes, wall_ns] {
    if (way.to != nullptr) way.to->arrive(*way.link, bytes.data(), wall_ns);
  });
}

void Network::cut(std::uint32_t a, std::uint32_t b, Nanoseconds time) {
  Instant& until = cut_until_[ordered(a, b)];
  until = std::max(until, world_.kernel.now() + time);
}

bool Network::is_cut(std::uint32_t connection) const {
  const Way& way = ways_[connection];
  const auto cut = cut_until_.find(way.between);
  return way.to != nullptr && cut != cut_until_.end() && world_.kernel.now() < cut->second;
}

}  // namespace takt::simulation
