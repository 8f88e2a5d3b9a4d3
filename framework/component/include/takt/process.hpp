// The header for authors of a process module in C++: the functions of <takt/process.h>, ports and properties.
// Ports and properties are global variables, or are constructed before initPeriodExe() or initSporadicExe()
// is called:
//
//   TAKT_TEXT("Holds a joint in its place.");
//   takt::InPort<motion::JointState> measured{"measured"};
//   takt::Property<double> gain{"gain", 60, {.unit = "1/s", .min = 1, .max = 200, .text = "Loop gain."}};
//   takt::Saved<Kept> kept{1};
//
//   int main() {
//     initPeriodExe();
//     while (true) {
//       waitPeriod();
//       if (measured.read()) ... gain ...
//     }
//   }
#pragma once

#ifndef __cplusplus
#error <takt/process.hpp> is for C++: a program in C includes <takt/process.h>
#endif

#include <takt/process.h>
#include <takt/component/event_port.hpp>
#include <takt/component/in_port.hpp>
#include <takt/component/log.hpp>
#include <takt/component/out_port.hpp>
#include <takt/component/owner.hpp>
#include <takt/component/property.hpp>
#include <takt/component/saved.hpp>
#include <takt/component/service.hpp>

namespace takt::detail {

template <class T>
struct ProcessHeader {};

}  // namespace takt::detail
