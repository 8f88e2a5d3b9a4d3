// Connects a program to the nodes of a domain, so that the program can observe and command them.
#pragma once

#include <memory>

#include <takt/client/observer.hpp>
#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

#include <takt/client/network.hpp>

namespace takt::client {

struct Connection {
  std::shared_ptr<dds::Participant> participant;
  std::unique_ptr<Observer> observer;
  std::unique_ptr<Operator> sender;
  int domain = 0;
};

/// Connects to a domain. `cell` is the descriptor with which the caller works, or null. If `network` sets no
/// domain or no discovery, the function uses the domain or discovery of `cell`.
Result<Connection> connect(const Network& network, const model::Cell* cell = nullptr,
                           Observer::Options options = {});

}  // namespace takt::client
