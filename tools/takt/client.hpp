// A command's connection to the nodes of a domain.
#pragma once

#include <memory>

#include <takt/client/observer.hpp>
#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

#include "network.hpp"

namespace takt::tool {

struct Client {
  std::shared_ptr<dds::Participant> participant;
  std::unique_ptr<client::Observer> observer;
  std::unique_ptr<client::Operator> asker;
  int domain = 0;
};

/// `cell`: the descriptor of the command, if it has one.
Result<Client> connect(const Network& network, const model::Cell* cell = nullptr,
                       client::Observer::Options options = {});

}  // namespace takt::tool
