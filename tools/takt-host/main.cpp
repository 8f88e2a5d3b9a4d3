#include <takt/host/host.hpp>

#include "signatures.hpp"

int main() {
  takt::tool::require_signatures();
  return takt::host::run_host();
}
