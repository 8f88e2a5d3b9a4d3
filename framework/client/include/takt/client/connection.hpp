// A command's connection to the nodes of a domain.
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

/// `cell`: the descriptor of the command, if it has one.
Result<Connection> connect(const Network& network, const model::Cell* cell = nullptr,
                           Observer::Options options = {});

}  // namespace takt::client
