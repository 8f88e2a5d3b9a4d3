// The changes that bring a running cell to the state of another descriptor. A device needs no change, changes
// in place while its modules run, or a restart. Pure functions.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

enum class Change {
  none,
  in_place,  ///< only changes that `takt set` and `takt swap` can make
  anew,      ///< the device is stopped and restarted with the new descriptor
  added,     ///< a device that the cell did not have before
  removed,
};
/// "none", "in place", "anew", "added", "removed"
const char* to_text(Change change);

/// A change to a running module.
struct ModuleChange {
  std::string module;
  std::string property;  ///< the property to set; empty: the module is swapped for another file
  std::string value;     ///< the new value of the property, or the new file
  std::string words;     ///< "gain: 0.5 -> 0.7", "file: servo.so -> servo2.so"
};

struct DeviceDifference {
  std::string device;
  Change change = Change::none;
  std::vector<ModuleChange> in_place{};  ///< in the order in which they are applied
  std::vector<std::string> reasons{};    ///< for `anew`: one text for each difference

  /// Makes the device restart instead, because a change cannot be applied in place.
  void make_anew(const std::string& why);
};

/// The difference in readable form: one line for each module changed in place, else one line for the device.
std::vector<std::string> in_words(const DeviceDifference& difference);

/// The difference of each device that is in one of two valid cells. A changed connection counts for the
/// devices at both ends. Fails if the cells differ as a whole: in name, domain, discovery or security.
Result<std::vector<DeviceDifference>> differences(const Cell& before, const Cell& after);

}  // namespace takt::model
