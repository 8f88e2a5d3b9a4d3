// What is to be done to a cell that runs, so that it is as another descriptor says: nothing, what a module
// can be told while it runs, or a device that is taken down and brought up anew. Pure.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

enum class Change {
  none,
  in_place,  ///< what `takt set` and `takt swap` do, and no more
  anew,      ///< the device is taken down, and brought up as the new descriptor says
  added,     ///< a device that the cell did not have
  removed,
};
/// "none", "in place", "anew", "added", "removed"
const char* to_text(Change change);

/// What a module is told while it runs.
struct ModuleChange {
  std::string module;
  std::string property;  ///< that gets the value; empty: the module gets another file
  std::string value;
  std::string words;  ///< "gain: 0.5 -> 0.7", "file: servo.so -> servo2.so"
};

struct DeviceDifference {
  std::string device;
  Change change = Change::none;
  std::vector<ModuleChange> in_place{};  ///< in the order in which they are made
  std::vector<std::string> reasons{};    ///< of `anew`: all that differs, one each

  /// What was to be done in place cannot be.
  void make_anew(const std::string& why);
};

/// What differs, for a person: a line for each module that is changed in place, one for any other device.
std::vector<std::string> in_words(const DeviceDifference& difference);

/// Of each device that either of two valid cells has. Connections are a difference of the devices at both
/// ends. Fails where what differs is the whole cell's: its name, its domain, how its nodes find each other,
/// or whether it is secured.
Result<std::vector<DeviceDifference>> differences(const Cell& before, const Cell& after);

}  // namespace takt::model
