#include "client.hpp"

#include "identity.hpp"

namespace takt::tool {

Result<Client> connect(const Network& network, const model::Cell* cell, client::Observer::Options options) {
  const auto domain = domain_of(network, cell);
  if (!domain) return domain.problems();
  const auto security = identity_of(network);
  if (!security) return security.problems();
  auto participant = dds::Participant::create({.name = "takt",
                                               .domain = *domain,
                                               .discovery = discovery_of(network, cell),
                                               .interfaces = interfaces(),
                                               .security = *security});
  if (!participant) return participant.problems();
  auto observer = client::Observer::create(*participant, std::move(options));
  if (!observer) return observer.problems();
  auto asker = client::Operator::create(*participant, **observer, *domain);
  if (!asker) return asker.problems();
  return Client{std::move(*participant), std::move(*observer), std::move(*asker), *domain};
}

}  // namespace takt::tool
