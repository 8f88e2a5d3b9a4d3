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
    : world_(world),
      draws_(world.seed, "network"),
      message_draws_(world.seed, "messages"),
      ways_(world.cell.connections.size()) {}

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
  const auto arrival =
      past_cuts(ordered(from, to), world_.kernel.now() + latency(message_draws_), reliable, message_draws_);
  if (!arrival) return;
  Instant& last = last_told_[{from, to}];
  last = std::max(*arrival, last + Nanoseconds{1});
  world_.kernel.at(last, std::move(arrive));
}

void Network::connect(std::uint32_t connection, Device& device, SimulatedLink& link) {
  const model::Connection& model = world_.cell.connections[connection];
  ways_[connection].to = &device;
  ways_[connection].link = &link;
  ways_[connection].between =
      ordered(device_of(world_.cell, model.from.device), device_of(world_.cell, model.to.device));
}

void Network::send(std::uint32_t connection, const std::byte* sample, std::int64_t wall_ns) {
  Way& way = ways_[connection];
  if (way.to == nullptr) return;  // the reader is an external program
  const model::Connection& model = world_.cell.connections[connection];
  const Instant now = world_.kernel.now();
  const Nanoseconds late = std::exchange(way.to_delay, Nanoseconds{0});
  auto arrival = past_cuts(way.between, now + latency(draws_) + late,
                           model.reliability == model::Reliability::reliable, draws_);
  if (way.to_lose != 0) {
    --way.to_lose;
    arrival.reset();
  }
  if (!arrival) {
    ++way.lost;
    world_.listener.on_event(
        {.at = now, .what = What::lost, .connection = connection, .number = number_of(sample)});
    return;
  }
  way.last = std::max(*arrival, way.last + Nanoseconds{1});  // keeps the order of the samples
  std::array<std::byte, kSampleBytes> bytes{};
  std::memcpy(bytes.data(), sample, bytes.size());
  world_.kernel.at(way.last, [&way, bytes, wall_ns] { way.to->arrive(*way.link, bytes.data(), wall_ns); });
}

void Network::cut(std::uint32_t a, std::uint32_t b, Nanoseconds time) {
  Instant& until = cut_until_[ordered(a, b)];
  until = std::max(until, world_.kernel.now() + time);
}

bool Network::is_cut(std::uint32_t connection) const {
  const auto cut = cut_until_.find(ways_[connection].between);
  return ways_[connection].to != nullptr && cut != cut_until_.end() && world_.kernel.now() < cut->second;
}

void Network::lose(std::uint32_t connection, std::uint64_t count) { ways_[connection].to_lose += count; }

void Network::delay(std::uint32_t connection, Nanoseconds by) { ways_[connection].to_delay += by; }

}  // namespace takt::simulation
