// Connects a program to the nodes of a domain, so that it can observe and command them.
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
  std::unique_ptr<Operator> asker;
  int domain = 0;
};

/// Connects to the domain. `cell` is the descriptor that the caller works with, or null. If `network` sets no
/// domain or discovery, those of `cell` are used.
Result<Connection> connect(const Network& network, const model::Cell* cell = nullptr,
                           Observer::Options options = {});

}  // namespace takt::client
