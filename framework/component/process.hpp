// What the author of a program in C++ includes: the functions of <takt/process.h>, and ports. These are
// global variables, or are there before initPeriodExe() or initSporadicExe() is called:
//
//   takt::InPort<motion::JointState> measured{"measured"};
//
//   int main() {
//     initPeriodExe();
//     while (true) {
//       waitPeriod();
//       if (measured.read()) ...
//     }
//   }
#pragma once

#include <takt/component/process.h>
#include <takt/component/event_port.hpp>
#include <takt/component/in_port.hpp>
#include <takt/component/out_port.hpp>
#include <takt/component/service.hpp>
