// The changes that make a running cell match a new descriptor. A device needs no change, or changes while its
// modules run, or must restart. All functions are pure.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

enum class Change {
  none,
  in_place,  ///< all changes can be made while the modules run, as by `takt set` and `takt swap`
  anew,      ///< the device must be stopped and restarted with the new descriptor
  added,     ///< only the new descriptor contains the device
  removed,
};
/// Returns the value as text: "none", "in place", "anew", "added" or "removed".
const char* to_text(Change change);

/// A change that can be made while the module runs.
struct ModuleChange {
  std::string module;
  std::string property;  ///< the property to set; empty: the module is swapped for another component file
  std::string value;     ///< the new value of the property, or the new component file
  std::string words;  ///< the change as text, for example "gain: 0.5 -> 0.7" or "file: servo.so -> servo2.so"
};

struct DeviceDifference {
  std::string device;
  Change change = Change::none;
  /// The changes to running modules, in the order in which they are made.
  std::vector<ModuleChange> in_place{};
  /// For `anew`: why the device must restart, one text for each difference.
  std::vector<std::string> reasons{};

  /// Makes this a restart of the device, because a change cannot be made while the device's modules run.
  /// `why` becomes the first reason.
  void make_anew(const std::string& why);
  /// Adds a change: `module` is swapped for the component `file`. `words` describes this change.
  void add_file(const Module& module, const std::string& file, const std::string& words);
};

/// Returns the difference as readable text: one line for each change to a running module, otherwise one line
/// for the device.
std::vector<std::string> in_words(const DeviceDifference& difference);

/// Compares two valid cells and returns the difference of each device that is in at least one of them. A
/// changed connection counts for the devices at both ends. Fails if the cells differ in their name, domain,
/// discovery or security.
Result<std::vector<DeviceDifference>> differences(const Cell& before, const Cell& after);

}  // namespace takt::model
