// The changes that make a running cell match another descriptor. Each device needs no change, changes while
// its modules run, or a restart. All functions are pure.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

enum class Change {
  none,
  in_place,  ///< running modules can take all changes, as with `takt set` and `takt swap`
  anew,      ///< the device must be stopped and restarted with the new descriptor
  added,     ///< the device is new in the cell
  removed,
};
/// The value as text: "none", "in place", "anew", "added" or "removed".
const char* to_text(Change change);

/// A change that a running module can take.
struct ModuleChange {
  std::string module;
  std::string property;  ///< the property to set; empty: the module is swapped for another file
  std::string value;     ///< the new value of the property, or the new file
  std::string words;     ///< for example "gain: 0.5 -> 0.7" or "file: servo.so -> servo2.so"
};

struct DeviceDifference {
  std::string device;
  Change change = Change::none;
  std::vector<ModuleChange> in_place{};  ///< the changes to running modules, in the order in which they are
                                         ///< applied
  std::vector<std::string> reasons{};    ///< for `anew`: why the device must restart, one text for each
                                         ///< difference

  /// Changes this result to a restart of the device, because a change cannot be made while its modules run.
  /// `why` becomes the first reason.
  void make_anew(const std::string& why);
};

/// The difference as readable text: one line for each module that changes while it runs, otherwise one line
/// for the device.
std::vector<std::string> in_words(const DeviceDifference& difference);

/// Compares two valid cells and returns the difference of each device that is in at least one of them. A
/// changed connection counts for the devices at both ends. Fails if the cells differ in their name, domain,
/// discovery or security.
Result<std::vector<DeviceDifference>> differences(const Cell& before, const Cell& after);

}  // namespace takt::model
