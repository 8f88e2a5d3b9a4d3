#include <takt/client/connection.hpp>

#include <takt/client/identity.hpp>

namespace takt::client {

Result<Connection> connect(const Network& network, const model::Cell* cell, Observer::Options options) {
  const auto domain = domain_of(network, cell);
  if (!domain) return domain.problems();
  const auto security = identity_of(network);
  if (!security) return security.problems();
  const model::Discovery discovery = discovery_of(network, cell);
  auto participant = dds::Participant::create({.name = "takt",
                                               .domain = *domain,
                                               .discovery = discovery,
                                               .interfaces = interfaces(),
                                               .security = *security});
  if (!participant) return participant.problems();
  auto observer = Observer::create(*participant, std::move(options));
  if (!observer) return observer.problems();
  auto sender =
      Operator::create(*participant, **observer, *domain, options_of(*domain, discovery), network.progress);
  if (!sender) return sender.problems();
  return Connection{std::move(*participant), std::move(*observer), std::move(*sender), *domain};
}

}  // namespace takt::client
