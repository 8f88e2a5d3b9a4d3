// A periodic process module whose property `ports` determines its ports: with ports=a,b,c it has the outputs
// a, b and c.
#include <takt/process.hpp>

#include <cstdio>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "sample.hpp"

int main(int argc, char* argv[]) {
  std::string names;
  for (int i = 1; i < argc; ++i) {
    if (const std::string argument = argv[i]; argument.starts_with("ports=")) names = argument.substr(6);
  }
  if (names.empty()) {
    std::fprintf(
        stderr, "property 'ports' is missing; name the ports that there are to be\nthere is nothing to do\n");
    return 1;
  }
  std::vector<std::unique_ptr<takt::OutPort<samples::Count>>> ports;
  std::istringstream list{names};
  for (std::string name; std::getline(list, name, ',');)
    ports.push_back(std::make_unique<takt::OutPort<samples::Count>>(name));
  initPeriodExe();
  samples::Count count;
  while (true) {
    waitPeriod();
    for (const auto& port : ports) port->write(count);
  }
}
