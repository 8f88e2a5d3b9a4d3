// Provides the statuses of devices, as nodes would publish them, for the tests of the web page's data.
#pragma once

#include <string>
#include <vector>

#include <takt/descriptor/descriptor.hpp>
#include <takt/wire/cell_state.hpp>
#include <takt/wire/words.hpp>

namespace takt::tool::web::seen {

inline constexpr const char* kCell = R"(<cell name="press">
  <device name="robot">
    <module><name>servo</name><filename>servo.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>1000000</period><priority>1</priority>
      <budget>200000</budget></module>
    <module><name>slow</name><filename>slow.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>3000000</period><priority>2</priority></module>
    <module><name>react</name><filename>react.so</filename><moduletype>thread</moduletype>
      <operationtype>sporadic</operationtype><deadline>2000000</deadline><priority>3</priority></module>
  </device>
  <device name="line">
    <module><filename>vision.exe</filename><moduletype>process</moduletype>
      <operationtype>periodic</operationtype><period>10000000</period><priority>1</priority></module>
  </device>
  <connection from="robot.servo.angle" to="line.vision.angle" kind="latest" deadline="20000000"/>
  <connection from="robot.servo.angle" topic="plant/angle"/>
</cell>)";

inline model::Cell cell() { return descriptor::parse(kCell, "press.xml").value(); }

inline wire::ObservedDevice device(const std::string& name, DeviceState state = DEVICE_RUNNING) {
  wire::ObservedDevice device;
  DeviceStatus& s = device.status;
  wire::set(s.path(), wire::path_of("press", name));
  wire::set(s.cell(), "press");
  wire::set(s.device(), name);
  wire::set(s.node(), "node of " + name);
  wire::set(s.host_name(), "pc7");
  wire::set(s.deployment(), "d1");
  s.state(state);
  s.real_time(true);
  s.host_restarts(2);
  s.unacknowledged_alarms(3);
  return device;
}

inline LifecycleStatus status(const std::string& device, const std::string& name, LifecycleState state,
                              std::uint64_t sequence = 1) {
  LifecycleStatus s;
  wire::set(s.path(), wire::path_of("press", device, name));
  wire::set(s.cell(), "press");
  wire::set(s.device(), device);
  wire::set(s.name(), name);
  s.state(state);
  s.sequence_number(sequence);
  return s;
}

inline ModuleStatistics statistics(const std::string& name, std::uint64_t cycles) {
  ModuleStatistics s;
  wire::set(s.name(), name);
  s.cycles(cycles);
  s.overruns(3);
  Distribution d;
  d.mean(-1.5);
  d.p50(2);
  d.p99(40);
  d.p999(60.5);
  d.max(100);
  s.jitter_us(d);
  s.run_us(d);
  return s;
}

inline PortStatus port(bool matched, std::int64_t age_ns) {
  PortStatus s;
  s.matched(matched ? 1 : 0);
  s.connections(1);
  s.age_ns(age_ns);
  s.lost(4);
  return s;
}

/// Returns two devices: a running robot with all measurements, and a line that is lost.
inline std::vector<wire::ObservedDevice> cell_that_runs() {
  wire::ObservedDevice robot = device("robot");
  robot.deployment.modules["servo"] = status("robot", "servo", STATE_EXECUTING, 3);
  robot.deployment.modules["slow"] = status("robot", "slow", STATE_RECOVER, 5);
  robot.deployment.statistics["servo"] = statistics("servo", 1000);
  ExecutorStatistics main;
  main.cycles(900);
  main.missed(1);
  main.margin_us(50);
  robot.deployment.executors["main"] = main;
  robot.deployment.ports["servo.angle"] = {port(true, 500'000)};
  wire::ObservedDevice line = device("line");
  line.alive = false;
  line.deployment.modules["vision"] = status("line", "vision", STATE_EXECUTING, 3);
  line.deployment.ports["vision.angle"] = {port(true, 30'000'000)};
  return {line, robot};
}

}  // namespace takt::tool::web::seen
