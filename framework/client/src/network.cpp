#include <takt/client/network.hpp>

#include <charconv>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>
#include <takt/os/environment.hpp>

namespace takt::client {

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

Result<int> domain_of(const Network& network, const model::Cell* cell) {
  if (network.domain) return *network.domain;
  const std::string text = os::environment("TAKT_DOMAIN");
  if (text.empty()) return cell == nullptr ? 0 : cell->domain;
  int domain = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), domain);
  if (error != std::errc{} || end != text.data() + text.size() || domain < 0 || domain > model::kMaxDomain)
    return fail("TAKT_DOMAIN is " + in_quotes(text),
                "set it to a number from 0 to " + std::to_string(model::kMaxDomain));
  return domain;
}

std::string domain_note(const Network& network, const model::Cell& cell) {
  const auto domain = domain_of(network, &cell);
  // Domain 0 is also the domain of a descriptor that names none.
  if (network.domain || cell.domain == 0 || !domain || *domain == cell.domain) return {};
  return "note: TAKT_DOMAIN sets domain " + std::to_string(*domain) + " instead of the descriptor's domain " +
         std::to_string(cell.domain);
}

model::Discovery discovery_of(const Network& network, const model::Cell* cell) {
  model::Discovery discovery;
  if (cell != nullptr) discovery = cell->discovery;
  if (!network.peers.empty()) {
    discovery.kind = model::Discovery::Kind::peers;
    discovery.peers = split(network.peers);
  }
  if (!network.server.empty()) {
    discovery.kind = model::Discovery::Kind::server;
    discovery.server = network.server;
  }
  return discovery;
}

std::string options_of(int domain, const model::Discovery& discovery) {
  std::string options = "--domain " + std::to_string(domain);
  if (discovery.kind == model::Discovery::Kind::server) options += " --server " + discovery.server;
  if (discovery.kind == model::Discovery::Kind::peers) {
    options += " --peers ";
    for (const std::string& peer : discovery.peers)
      options += (options.back() == ' ' ? "" : ",") + peer;
  }
  return options;
}

std::string security_of(const Network& network) {
  return network.security.empty() ? os::environment("TAKT_SECURITY") : network.security;
}

std::vector<std::string> interfaces() { return split(os::environment("TAKT_INTERFACE")); }

}  // namespace takt::client
